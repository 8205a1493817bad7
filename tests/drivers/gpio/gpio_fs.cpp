#include "tests/drivers/gpio/gpio_fs.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <ctime>

#include <fmt/format.h>

#include "sim/core/check.h"

namespace footlight::testing {
namespace {

constexpr const char* kNode = "/dev/gpiochip0";
constexpr int kQueueEdges = 16;

template <std::size_t N>
void copy_name(char (&to)[N], const std::string& from) {
  std::snprintf(to, N, "%s", from.c_str());
}

}  // namespace

GpioFs::GpioFs(Testbed& testbed, std::vector<std::string> names)
    : testbed_(testbed), handler_(umockdev_ioctl_base_new()) {
  for (std::string& name : names) lines_.push_back({.name = std::move(name)});
  g_signal_connect(handler_, "handle-ioctl", G_CALLBACK(&GpioFs::on_ioctl), this);
  FL_CHECK(umockdev_testbed_attach_ioctl(testbed_.get(), kNode, handler_, nullptr));
  // libgpiod compares the numbers of the node with those in /sys.
  add_device(testbed_.get(), fmt::format("P: /devices/platform/footlight-gpio/gpiochip0\nN: gpiochip0\n"
                                         "E: SUBSYSTEM=gpio\nE: MAJOR=254\nE: MINOR=0\nE: DEVNAME={}\n"
                                         "A: dev=254:0\\n\n\n",
                                         kNode));
  plug();
}

GpioFs::~GpioFs() {
  unplug();
  g_object_unref(handler_);
}

void GpioFs::plug() {
  const std::lock_guard lock(mutex_);
  if (plugged_) return;
  plugged_ = true;
  make_fifo(kNode);
}

void GpioFs::unplug() {
  const std::lock_guard lock(mutex_);
  if (!plugged_) return;
  plugged_ = false;
  for (Line& line : lines_) {
    if (line.write_fd >= 0) ::close(line.write_fd);
    line.write_fd = -1;
  }
  // The entry in /sys stays, because umockdev cannot create a node twice. libgpiod opens the node first and fails.
  ::unlink((testbed_.root() + kNode).c_str());
}

void GpioFs::drive(unsigned number, bool level, std::int64_t stamp_ns) {
  const std::lock_guard lock(mutex_);
  Line& line = lines_.at(number);
  if (line.level == level) return;
  line.level = level;
  if (!in_use(line)) return;
  int queued = 0;
  ::ioctl(line.write_fd, FIONREAD, &queued);
  if (queued >= kQueueEdges * static_cast<int>(sizeof(gpioevent_data))) {
    ++line.lost;
    return;
  }
  if (stamp_ns == 0) {
    timespec time{};
    ::clock_gettime(CLOCK_MONOTONIC, &time);
    stamp_ns = static_cast<std::int64_t>(time.tv_sec) * kNsPerS + time.tv_nsec;
  }
  const bool active = level != ((line.handle_flags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0);
  const gpioevent_data event{.timestamp = static_cast<__u64>(stamp_ns),
                             .id = active ? __u32{GPIOEVENT_EVENT_RISING_EDGE} : __u32{GPIOEVENT_EVENT_FALLING_EDGE}};
  FL_CHECK(::write(line.write_fd, &event, sizeof event) == sizeof event);
}

void GpioFs::hold(unsigned line, const std::string& consumer) {
  const std::lock_guard lock(mutex_);
  lines_.at(line).held = !consumer.empty();
  lines_.at(line).consumer = consumer;
}

void GpioFs::refuse(int number) {
  const std::lock_guard lock(mutex_);
  refusal_ = number;
}

void GpioFs::fail_levels(int number) {
  const std::lock_guard lock(mutex_);
  level_error_ = number;
}

bool GpioFs::is_requested(unsigned line) {
  const std::lock_guard lock(mutex_);
  return in_use(lines_.at(line));
}

unsigned GpioFs::handle_flags(unsigned line) {
  const std::lock_guard lock(mutex_);
  return lines_.at(line).handle_flags;
}

std::string GpioFs::consumer(unsigned line) {
  const std::lock_guard lock(mutex_);
  return lines_.at(line).consumer;
}

int GpioFs::lost(unsigned line) {
  const std::lock_guard lock(mutex_);
  return lines_.at(line).lost;
}

// True while the other end of the FIFO is open; the handler detects a release by the close.
bool GpioFs::in_use(Line& line) const {
  if (line.write_fd < 0) return false;
  pollfd fd{.fd = line.write_fd, .events = 0, .revents = 0};
  if (::poll(&fd, 1, 0) == 0) return true;
  ::close(line.write_fd);
  line.write_fd = -1;
  return false;
}

void GpioFs::make_fifo(const std::string& node) const {
  const std::string path = testbed_.root() + node;
  ::unlink(path.c_str());
  FL_CHECK(::mkfifo(path.c_str(), 0600) == 0);
}

gboolean GpioFs::on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, GpioFs* self) {
  self->answer(client);
  return TRUE;
}

void GpioFs::answer(UMockdevIoctlClient* client) {
  const std::lock_guard lock(mutex_);
  UMockdevIoctlData* const argument = umockdev_ioctl_client_get_arg(client);
  switch (umockdev_ioctl_client_get_request(client)) {
    case GPIO_GET_CHIPINFO_IOCTL: {
      const Argument<gpiochip_info> info(argument);
      copy_name(info->name, "gpiochip0");
      copy_name(info->label, "footlight-gpio");
      info->lines = static_cast<__u32>(lines_.size());
      return reply(client, 0);
    }
    case GPIO_GET_LINEINFO_IOCTL: {
      const Argument<gpioline_info> info(argument);
      if (info->line_offset >= lines_.size()) return reply(client, -1, EINVAL);
      Line& line = lines_[info->line_offset];
      copy_name(info->name, line.name);
      copy_name(info->consumer, line.consumer);
      info->flags = line.held || in_use(line) ? GPIOLINE_FLAG_KERNEL : 0;
      return reply(client, 0);
    }
    case GPIO_GET_LINEEVENT_IOCTL: return answer_line_event(client, argument);
    case GPIOHANDLE_GET_LINE_VALUES_IOCTL: {
      const Argument<gpiohandle_data> data(argument);
      const auto found = line_of_node_.find(umockdev_ioctl_client_get_devnode(client));
      if (!plugged_ || found == line_of_node_.end()) return reply(client, -1, ENODEV);
      if (level_error_ != 0) return reply(client, -1, level_error_);
      const Line& line = lines_[found->second];
      data->values[0] = line.level != ((line.handle_flags & GPIOHANDLE_REQUEST_ACTIVE_LOW) != 0) ? 1 : 0;
      return reply(client, 0);
    }
    default: return reply(client, -1, ENOTTY);
  }
}

void GpioFs::answer_line_event(UMockdevIoctlClient* client, UMockdevIoctlData* argument) {
  const Argument<gpioevent_request> request(argument);
  if (refusal_ != 0) return reply(client, -1, refusal_);
  if (request->lineoffset >= lines_.size()) return reply(client, -1, EINVAL);
  Line& line = lines_[request->lineoffset];
  if (line.held || in_use(line)) return reply(client, -1, EBUSY);
  const std::string node = fmt::format("{}.line{}", kNode, node_count_++);
  FL_CHECK(umockdev_testbed_attach_ioctl(testbed_.get(), node.c_str(), handler_, nullptr));
  make_fifo(node);
  line_of_node_[node] = request->lineoffset;
  // A FIFO opens for writing only when it has a reader. The path below / is emulated, the one of the testbed is not.
  const int read_fd = ::open(node.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  line.write_fd = ::open((testbed_.root() + node).c_str(), O_WRONLY | O_NONBLOCK | O_CLOEXEC);
  FL_CHECK(read_fd >= 0 && line.write_fd >= 0);
  ::fcntl(read_fd, F_SETFL, 0);  // the kernel's descriptor blocks by default
  line.consumer = request->consumer_label;
  line.handle_flags = request->handleflags;
  request->fd = read_fd;
  return reply(client, 0);
}

}  // namespace footlight::testing
