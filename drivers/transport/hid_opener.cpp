#include "drivers/transport/hid_opener.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <sys/epoll.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <mutex>
#include <utility>
#include <vector>

#include <hidapi.h>

#include "drivers/device/chooser.h"
#include "drivers/permission.h"
#include "drivers/transport/wakeup.h"

namespace footlight::drivers {

bool built_with_hid() { return true; }

namespace {

constexpr DurationNs kSleepMaxNs = kNsPerS;  // for clocks that are moved by hand

struct CloseHidDevice {
  void operator()(hid_device* device) const { hid_close(device); }
};
using OwnedHidDevice = std::unique_ptr<hid_device, CloseHidDevice>;

// Shared by the opener and its transport.
struct Link {
  explicit Link(Clock& the_clock) : clock(the_clock) {}
  Clock& clock;
  Wakeup wakeup;

  // Real time for epoll_wait(), rounded up.
  [[nodiscard]] int ms_until(TimeNs deadline_ns) const {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kSleepMaxNs);
    return static_cast<int>((left_ns + kNsPerMs - 1) / kNsPerMs);
  }
};

// The text of hidapi's last error. device: nullptr for that of hid_open_path().
std::string hidapi_error(hid_device* device) {
  std::string text;
  for (const wchar_t* at = hid_error(device); at != nullptr && *at != 0; ++at)
    text += *at > 0 && *at < 0x80 ? static_cast<char>(*at) : '?';
  return text;
}

// An own file of the node, open for as long as hidapi's. It is never read or written. It tells three things that hidapi
// cannot tell: which device it is, whether that device is still there, and when a report has arrived.
//
// While it is open the kernel does not give the node's number to another device, so hidapi opens the same device.
class Node {
 public:
  static Result<Node> open(const FoundDevice& found, const FindOptions& options) {
    const std::string& name = found.hidraw;
    Fd fd(::open(name.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (fd.get() < 0) {
      const int error = errno;
      if (error == EACCES || error == EPERM)
        return fail(ErrorCode::kPermission, "{}", message_of(advise_on_permission(found, name, error, options)));
      return fail(error == ENOENT || error == ENODEV || error == ENXIO ? ErrorCode::kNotFound : ErrorCode::kIo,
                  "{}: cannot open: {}", name, std::strerror(error));
    }
    // hidapi makes this request first, and 0.13 does not survive its failure.
    int descriptor_size = 0;
    if (::ioctl(fd.get(), HIDIOCGRDESCSIZE, &descriptor_size) < 0) {
      if (errno == ENODEV) return fail(ErrorCode::kNotFound, "{}: unplugged", name);
      return fail(ErrorCode::kIo, "{}: is not a hidraw node: {}", name, std::strerror(errno));
    }
    // Since /sys was read the node's number may have been given to another device.
    hidraw_devinfo info{};
    if (::ioctl(fd.get(), HIDIOCGRAWINFO, &info) < 0 || static_cast<std::uint16_t>(info.vendor) != found.usb_vendor ||
        static_cast<std::uint16_t>(info.product) != found.usb_product)
      return fail(ErrorCode::kNotFound, "{}: unplugged", name);
    return Node(std::move(fd));
  }

  [[nodiscard]] bool is_gone() const {
    hidraw_devinfo info{};
    return ::ioctl(fd_.get(), HIDIOCGRAWINFO, &info) < 0;
  }
  [[nodiscard]] int fd() const { return fd_.get(); }

 private:
  explicit Node(Fd fd) : fd_(std::move(fd)) {}
  Fd fd_;
};

// hidapi keeps the text of the last hid_open_path() error in a variable of the process, without a lock.
Result<OwnedHidDevice> open_with_hidapi(const std::string& name) {
  static std::mutex mutex;
  const std::lock_guard lock(mutex);
  OwnedHidDevice device(hid_open_path(name.c_str()));
  if (!device) return fail(ErrorCode::kNotFound, "{}: cannot open: {}", name, hidapi_error(nullptr));
  return device;
}

class HidTransport final : public Transport {
 public:
  HidTransport(std::shared_ptr<Link> link, Node node, OwnedHidDevice device, const FoundDevice& found,
               std::vector<std::uint8_t> descriptors)
      : link_(std::move(link)),
        node_(std::move(node)),
        device_(std::move(device)),
        where_(found.hidraw),
        serial_(found.serial),
        descriptors_(std::move(descriptors)) {
    epoll_event wakeup{.events = EPOLLIN, .data = {.fd = link_->wakeup.fd()}};
    (void)::epoll_ctl(events_.get(), EPOLL_CTL_ADD, link_->wakeup.fd(), &wakeup);
    // Edge-triggered: the reports in this file stay unread, and each new one is an event all the same. When its queue
    // of 64 is full the kernel drops further reports from it alone.
    epoll_event report{.events = EPOLLIN | EPOLLET, .data = {.fd = node_.fd()}};
    (void)::epoll_ctl(events_.get(), EPOLL_CTL_ADD, node_.fd(), &report);
  }

  std::string where() const override { return where_; }
  std::string serial() const override { return serial_; }

  Status wait(TimeNs deadline_ns) override {
    std::array<std::uint8_t, 4096> dropped;
    while (true) {
      FL_ASSIGN(const std::size_t size, read(dropped, deadline_ns));
      if (size == 0) return {};
    }
  }

  Status write(std::span<const std::uint8_t> report, TimeNs deadline_ns) override {
    if (link_->wakeup.aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
    const int count = hid_write(device_.get(), report.data(), report.size());
    if (count == static_cast<int>(report.size())) return {};
    if (count >= 0) return fail(ErrorCode::kIo, "{}: took {} of {} bytes of a report", where_, count, report.size());
    // hidapi gives a text and no error code. What fails after the deadline is a timeout of the kernel.
    if (!node_.is_gone() && link_->clock.now_ns() >= deadline_ns)
      return fail(ErrorCode::kTimeout, "{}: did not take a report in time", where_);
    return failure("send");
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    while (true) {
      if (link_->wakeup.aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (link_->wakeup.take_wake()) return 0;
      const int count = hid_read_timeout(device_.get(), into.data() + 1, into.size() - 1, 0);
      if (count < 0) return failure("read");
      if (count > 0) {
        into[0] = 0;  // the report number, which these devices do not send
        return 1 + static_cast<std::size_t>(count);
      }
      if (link_->clock.now_ns() >= deadline_ns) return 0;
      sleep(deadline_ns);
    }
  }

  Result<std::size_t> control_in(const ControlRequest& request, std::span<std::uint8_t> into, TimeNs) override {
    constexpr std::uint8_t kFromDevice = 0x80, kGetDescriptor = 6;
    constexpr std::size_t kDeviceSize = 18;
    if (request.request_type != kFromDevice || request.request != kGetDescriptor ||
        (request.value != 0x0100 && request.value != 0x0200))
      return fail(ErrorCode::kUnsupported, "{}: takes no control transfers", where_);
    const auto all = std::span<const std::uint8_t>(descriptors_);
    const std::size_t split = std::min(kDeviceSize, all.size());
    const auto part = request.value == 0x0100 ? all.first(split) : all.subspan(split);
    const std::size_t size = std::min(part.size(), into.size());
    std::copy_n(part.begin(), size, into.begin());
    return size;
  }

 private:
  // Until a report arrives, the device is unplugged, wake() or abort() is called, or the deadline.
  void sleep(TimeNs deadline_ns) const {
    epoll_event events[2];
    const int count = ::epoll_wait(events_.get(), events, 2, link_->ms_until(deadline_ns));
    for (int i = 0; i < count; ++i)
      if (events[i].data.fd == link_->wakeup.fd()) link_->wakeup.clear();
  }

  tl::unexpected<Error> failure(std::string_view action) const {
    if (node_.is_gone()) return fail(ErrorCode::kDisconnected, "{}: unplugged", where_);
    return fail(ErrorCode::kIo, "{}: cannot {} a report: {}; if this happens again, unplug it and plug it in again",
                where_, action, hidapi_error(device_.get()));
  }

  const std::shared_ptr<Link> link_;
  const Node node_;
  const OwnedHidDevice device_;
  const Fd events_{::epoll_create1(EPOLL_CLOEXEC)};
  const std::string where_;
  const std::string serial_;
  const std::vector<std::uint8_t> descriptors_;  // of the device, then of its configuration
};

class HidOpener final : public Opener {
 public:
  HidOpener(HidConfig config, Clock& clock)
      : link_(std::make_shared<Link>(clock)),
        plugging_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)),
        chooser_(std::move(config.driver_id), std::move(config.target), std::move(config.find)) {
    // IN_ATTRIB: udev sets the permissions after the node has been created. Without a watch, wait() lasts until its
    // deadline.
    if (plugging_.get() >= 0)
      (void)::inotify_add_watch(plugging_.get(), chooser_.options().dev_root.c_str(), IN_CREATE | IN_ATTRIB);
  }
  [[nodiscard]] bool usable() const { return link_->wakeup.usable(); }

  Result<std::unique_ptr<Transport>> connect() override {
    if (link_->wakeup.aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", chooser_.driver_id());
    (void)drain_plugging();  // before the search, so that later events end the next wait()
    FL_ASSIGN(const FoundDevice found, chooser_.choose());
    if (found.hidraw.empty())
      return fail(ErrorCode::kNotFound, "{}: has no hidraw node; see: footlight devices", found.node);
    FL_ASSIGN(Node node, Node::open(found, chooser_.options()));
    link_->clock.sleep_until_ns(link_->clock.now_ns() + kHidSettleNs);
    if (link_->wakeup.aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", chooser_.driver_id());
    if (node.is_gone())
      return fail(ErrorCode::kNotFound, "{}: unplugged within {} ms", found.hidraw, kHidSettleNs / kNsPerMs);
    FL_ASSIGN(OwnedHidDevice device, open_with_hidapi(found.hidraw));
    chooser_.pin(found);
    const std::string path =
        fmt::format("{}/bus/usb/devices/{}/descriptors", chooser_.options().sys_root, found.port_path);
    std::ifstream file(path, std::ios::binary);
    std::vector<std::uint8_t> descriptors{std::istreambuf_iterator<char>(file), {}};
    return std::make_unique<HidTransport>(link_, std::move(node), std::move(device), found, std::move(descriptors));
  }

  void wait(TimeNs deadline_ns) override {
    while (!link_->wakeup.aborted() && !link_->wakeup.take_wake() && link_->clock.now_ns() < deadline_ns) {
      short got = 0;
      (void)link_->wakeup.poll_until(plugging_.get(), POLLIN, link_->clock, deadline_ns, got);
      if (drain_plugging()) return;
    }
  }

  void wake() override { link_->wakeup.wake(); }
  void abort() override { link_->wakeup.abort(); }
  std::string identity() override { return chooser_.identity(); }

 private:
  // True if a node has come to /dev or changed its permissions.
  bool drain_plugging() const {
    std::array<char, 4096> events;
    bool any = false;
    while (::read(plugging_.get(), events.data(), events.size()) > 0) any = true;
    return any;
  }

  const std::shared_ptr<Link> link_;  // shared with the transport
  const Fd plugging_;                 // inotify
  Chooser chooser_;
};

}  // namespace

Result<std::unique_ptr<Opener>> make_hid_opener(HidConfig config, Clock& clock) {
  auto opener = std::make_unique<HidOpener>(std::move(config), clock);
  if (!opener->usable()) return fail(ErrorCode::kUnsupported, "the system gives no file descriptors");
  return opener;
}

}  // namespace footlight::drivers
