#include "drivers/transport/hidraw_opener.h"

#include <fcntl.h>
#include <linux/hidraw.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <vector>

#include "drivers/device/chooser.h"
#include "drivers/permission.h"

namespace footlight::drivers {
namespace {

class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

// What the connector and its transport share.
struct Link {
  explicit Link(Clock& the_clock) : clock(the_clock) {}
  Clock& clock;
  const Descriptor wakeups{::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)};  // readable after wake() and abort()
  std::atomic<bool> woken{false};
  std::atomic<bool> aborted{false};

  void interrupt(std::atomic<bool>& what) {
    what = true;
    constexpr std::uint64_t kOne = 1;
    (void)!::write(wakeups.get(), &kOne, sizeof kOne);  // fails only where it is readable already
  }
  // Until `fd` has something, somebody interrupts, or the deadline; late never by more than a real second, for clocks
  // that are moved by hand. What poll() found at `fd`.
  short sleep(int fd, TimeNs deadline_ns) const {
    const DurationNs left_ns = std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kNsPerS);
    pollfd fds[] = {{fd, POLLIN, 0}, {wakeups.get(), POLLIN, 0}};
    (void)::poll(fds, 2, static_cast<int>((left_ns + kNsPerMs - 1) / kNsPerMs));
    std::uint64_t count = 0;
    if (fds[1].revents != 0) (void)!::read(wakeups.get(), &count, sizeof count);
    return fds[0].revents;
  }
};

class HidrawTransport final : public Transport {
 public:
  HidrawTransport(std::shared_ptr<Link> link, Descriptor node, const FoundDevice& found,
                  std::vector<std::uint8_t> descriptors)
      : link_(std::move(link)),
        node_(std::move(node)),
        where_(found.hidraw),
        serial_(found.serial),
        descriptors_(std::move(descriptors)) {}

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
    if (link_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
    const ssize_t count = ::write(node_.get(), report.data(), report.size());
    if (count == static_cast<ssize_t>(report.size())) return {};
    if (count >= 0) return fail(ErrorCode::kIo, "{}: took {} of {} bytes of a report", where_, count, report.size());
    if (errno == ETIMEDOUT || (errno == EINTR && link_->clock.now_ns() >= deadline_ns))
      return fail(ErrorCode::kTimeout, "{}: did not take a report in time", where_);
    return failure(errno, "send");
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    while (true) {
      if (link_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
      if (link_->woken.exchange(false)) return 0;
      const ssize_t count = ::read(node_.get(), into.data() + 1, into.size() - 1);
      if (count > 0) {
        into[0] = 0;  // the number that it does not have
        return 1 + static_cast<std::size_t>(count);
      }
      if (count == 0) return failure(ENODEV, "read");
      if (errno != EAGAIN && errno != EINTR) return failure(errno, "read");
      if (link_->clock.now_ns() >= deadline_ns) return 0;
      if ((link_->sleep(node_.get(), deadline_ns) & (POLLERR | POLLHUP)) != 0) return failure(ENODEV, "read");
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
  tl::unexpected<Error> failure(int error, std::string_view action) const {
    if (error == ENODEV || error == ENXIO || error == ESHUTDOWN)
      return fail(ErrorCode::kDisconnected, "{}: unplugged", where_);
    return fail(ErrorCode::kIo, "{}: cannot {} a report: {}; plug it in again if that stays so", where_, action,
                std::strerror(error));
  }

  const std::shared_ptr<Link> link_;
  const Descriptor node_;
  const std::string where_;
  const std::string serial_;
  const std::vector<std::uint8_t> descriptors_;  // of the device, then of its configuration
};

class HidrawOpener final : public Opener {
 public:
  HidrawOpener(HidrawConfig config, Clock& clock)
      : link_(std::make_shared<Link>(clock)),
        plugging_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)),
        chooser_(std::move(config.driver_id), std::move(config.target), std::move(config.find)) {
    // IN_ATTRIB: udev gives the node its permissions after it has come. Where this fails, wait() lasts until its
    // deadline.
    if (plugging_.get() >= 0)
      (void)::inotify_add_watch(plugging_.get(), chooser_.options().dev_root.c_str(), IN_CREATE | IN_ATTRIB);
  }

  Result<std::unique_ptr<Transport>> connect() override {
    if (link_->aborted) return fail(ErrorCode::kDisconnected, "{}: closed", chooser_.driver_id());
    (void)drain_plugging();  // before looking: what comes after is news
    FL_ASSIGN(const FoundDevice found, chooser_.choose());
    if (found.hidraw.empty())
      return fail(ErrorCode::kNotFound, "{}: has no hidraw node; see: footlight devices", found.node);
    FL_ASSIGN(Descriptor node, open(found, chooser_.options()));
    chooser_.pin(found);
    const std::string path =
        fmt::format("{}/bus/usb/devices/{}/descriptors", chooser_.options().sys_root, found.port_path);
    std::ifstream file(path, std::ios::binary);
    std::vector<std::uint8_t> descriptors{std::istreambuf_iterator<char>(file), {}};
    return std::make_unique<HidrawTransport>(link_, std::move(node), found, std::move(descriptors));
  }

  void wait(TimeNs deadline_ns) override {
    while (!link_->aborted && !link_->woken.exchange(false) && link_->clock.now_ns() < deadline_ns) {
      (void)link_->sleep(plugging_.get(), deadline_ns);
      if (drain_plugging()) return;
    }
  }

  void wake() override { link_->interrupt(link_->woken); }
  void abort() override { link_->interrupt(link_->aborted); }
  std::string identity() override { return chooser_.identity(); }

 private:
  // True where something has come to /dev.
  bool drain_plugging() const {
    std::array<char, 4096> events;
    bool any = false;
    while (::read(plugging_.get(), events.data(), events.size()) > 0) any = true;
    return any;
  }

  static Result<Descriptor> open(const FoundDevice& found, const FindOptions& options) {
    const std::string& name = found.hidraw;
    Descriptor node(::open(name.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC));
    if (node.get() < 0) {
      const int error = errno;
      if (error == EACCES || error == EPERM)
        return fail(ErrorCode::kPermission, "{}", message_of(advise_on_permission(found, name, error, options)));
      return fail(error == ENOENT || error == ENODEV || error == ENXIO ? ErrorCode::kNotFound : ErrorCode::kIo,
                  "{}: cannot open: {}", name, std::strerror(error));
    }
    // Numbers of nodes are given out again: between the look into /sys and now it may have become another device's.
    hidraw_devinfo info{};
    if (::ioctl(node.get(), HIDIOCGRAWINFO, &info) < 0 || static_cast<std::uint16_t>(info.vendor) != found.usb_vendor ||
        static_cast<std::uint16_t>(info.product) != found.usb_product)
      return fail(ErrorCode::kNotFound, "{}: unplugged", name);
    return node;
  }

  const std::shared_ptr<Link> link_;  // outlives the transport, which holds it too
  const Descriptor plugging_;         // inotify: something has come to /dev
  Chooser chooser_;
};

}  // namespace

std::unique_ptr<Opener> make_hidraw_opener(HidrawConfig config, Clock& clock) {
  return std::make_unique<HidrawOpener>(std::move(config), clock);
}

}  // namespace footlight::drivers
