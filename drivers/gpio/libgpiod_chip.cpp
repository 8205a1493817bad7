// Lines of this machine's chips, through libgpiod 1.6 (GPIO uAPI v1: one descriptor per line).
#include <fcntl.h>
#include <gpiod.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <ctime>
#include <optional>

#include "drivers/gpio/gpio_chip.h"

namespace footlight::drivers {
namespace {

constexpr const char* kConsumer = "footlight";

std::int64_t clock_ns(clockid_t id) {
  timespec time{};
  ::clock_gettime(id, &time);
  return static_cast<std::int64_t>(time.tv_sec) * kNsPerS + time.tv_nsec;
}

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }
};
using ChipHandle = std::unique_ptr<gpiod_chip, CloseChip>;

Error trouble_of(int number, const std::string& where, const char* what) {
  const bool gone = number == ENODEV || number == ENXIO || number == EPIPE;
  return {gone ? ErrorCode::kDisconnected : ErrorCode::kIo,
          fmt::format("{}: {}: {}", where, what, gone ? "the chip is gone" : std::strerror(number))};
}

class LibgpiodLine final : public GpioLine {
 public:
  LibgpiodLine(ChipHandle chip, gpiod_line* line, int fd, std::string where)
      : chip_(std::move(chip)), line_(line), fd_(fd), where_(std::move(where)) {}
  ~LibgpiodLine() override { gpiod_line_release(line_); }
  LibgpiodLine(const LibgpiodLine&) = delete;
  LibgpiodLine& operator=(const LibgpiodLine&) = delete;

  [[nodiscard]] int fd() const override { return fd_; }

  Result<std::size_t> read_edges(std::span<GpioEdge> edges) override {
    std::array<gpiod_line_event, kGpioQueueEdges> events;
    const auto count_max = static_cast<unsigned>(std::min(edges.size(), events.size()));
    // The descriptor is non-blocking. An end of file reads as EIO.
    const int count = gpiod_line_event_read_fd_multiple(fd_, events.data(), count_max);
    if (count < 0) {
      if (errno == EAGAIN || errno == EINTR) return 0;
      return tl::unexpected(trouble_of(errno, where_, "reading edges"));
    }
    const TimeNs now_ns = clock_ns(CLOCK_MONOTONIC);
    const std::int64_t realtime_ns = clock_ns(CLOCK_REALTIME);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
      const std::int64_t stamp_ns = static_cast<std::int64_t>(events[i].ts.tv_sec) * kNsPerS + events[i].ts.tv_nsec;
      edges[i] = {.stamp_ns = monotonic_stamp_ns(stamp_ns, now_ns, realtime_ns),
                  .level = events[i].event_type == GPIOD_LINE_EVENT_RISING_EDGE};
    }
    return static_cast<std::size_t>(count);
  }

  Result<bool> read_level() override {
    const int level = gpiod_line_get_value(line_);
    if (level < 0) return tl::unexpected(trouble_of(errno, where_, "reading the level"));
    return level != 0;
  }

 private:
  ChipHandle chip_;
  gpiod_line* line_;  // owned by the chip
  const int fd_;      // of the line
  const std::string where_;
};

std::optional<unsigned> number_of(const std::string& text) {
  unsigned number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return number;
}

Result<ChipHandle> open_chip(const std::string& name) {
  errno = 0;
  // By name or path first: a search by label opens every chip.
  ChipHandle chip(name.starts_with('/') ? gpiod_chip_open(name.c_str()) : gpiod_chip_open_by_name(name.c_str()));
  const int number = errno;
  if (chip) return chip;
  const std::string path = name.starts_with('/') ? name : "/dev/" + name;
  if (number == EACCES || number == EPERM)
    return fail(ErrorCode::kPermission, "{}: {}; run 'footlight devices' for the command that gives access", path,
                std::strerror(number));
  if (number == EBUSY || number == EMFILE) return fail(ErrorCode::kIo, "{}: {}", path, std::strerror(number));
  ChipHandle labelled(gpiod_chip_open_by_label(name.c_str()));
  if (labelled) return labelled;
  if (number == ENOTTY || number == ENODEV || number == EINVAL)
    return fail(ErrorCode::kNotFound, "{}: not a GPIO chip; 'gpiodetect' lists them", path);
  return fail(ErrorCode::kNotFound,
              "{}: no such GPIO chip; 'gpiodetect' (package gpiod) lists them, and expanders on USB come and go", path);
}

class LibgpiodChips final : public GpioChips {
 public:
  Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) override {
    FL_ASSIGN(ChipHandle chip, open_chip(request.chip));
    const std::string chip_name = gpiod_chip_name(chip.get());
    const std::string where = fmt::format("/dev/{} line {}", chip_name, request.line);
    const auto offset = number_of(request.line);
    gpiod_line* const line =
        offset ? gpiod_chip_get_line(chip.get(), *offset) : gpiod_chip_find_line(chip.get(), request.line.c_str());
    if (line == nullptr)
      return fail(ErrorCode::kNotFound, "{}: no such line; the chip has {}, 0 to {}: 'gpioinfo {}' lists them", where,
                  gpiod_chip_num_lines(chip.get()), gpiod_chip_num_lines(chip.get()) - 1, chip_name);

    int flags = request.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
    switch (request.bias) {
      case GpioBias::kAsIs: break;
      case GpioBias::kNone: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE; break;
      case GpioBias::kPullUp: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP; break;
      case GpioBias::kPullDown: flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN; break;
    }
    if (gpiod_line_request_both_edges_events_flags(line, kConsumer, flags) != 0)
      return refusal(errno, line, where, chip_name, request);
    const int fd = gpiod_line_event_get_fd(line);
    const int fd_flags = ::fcntl(fd, F_GETFL);
    if (fd < 0 || fd_flags < 0 || ::fcntl(fd, F_SETFL, fd_flags | O_NONBLOCK) != 0) {
      const int number = errno;
      gpiod_line_release(line);
      return fail(ErrorCode::kIo, "{}: {}", where, std::strerror(number));
    }
    return std::unique_ptr<GpioLine>(std::make_unique<LibgpiodLine>(std::move(chip), line, fd, where));
  }

 private:
  static tl::unexpected<Error> refusal(int number, gpiod_line* line, const std::string& where,
                                       const std::string& chip_name, const GpioLineRequest& request) {
    if (number == EBUSY) {
      const char* const holder = gpiod_line_update(line) == 0 ? gpiod_line_consumer(line) : nullptr;
      const bool named = holder != nullptr && *holder != '\0';
      return fail(ErrorCode::kIo, "{}: in use by {}; end that program or take another line: 'gpioinfo {}' lists them",
                  where, named ? fmt::format("\"{}\"", holder) : std::string("another program or the kernel"),
                  chip_name);
    }
    if (number == EACCES || number == EPERM)
      return fail(ErrorCode::kPermission, "{}: {}", where, std::strerror(number));
    if (number == EINVAL && request.bias != GpioBias::kAsIs)
      return fail(ErrorCode::kUnsupported,
                  "{}: the kernel or the chip cannot set this bias (needs Linux 5.5); leave it out and wire a resistor",
                  where);
    if (number == EINVAL || number == ENXIO || number == ENOTSUP)
      return fail(ErrorCode::kUnsupported, "{}: {}: the line has no interrupts, or is no input; take another line",
                  where, std::strerror(number));
    return tl::unexpected(trouble_of(number, where, "requesting edges"));
  }
};

}  // namespace

std::shared_ptr<GpioChips> make_gpio_chips() { return std::make_shared<LibgpiodChips>(); }
bool built_with_gpio() { return true; }

}  // namespace footlight::drivers
