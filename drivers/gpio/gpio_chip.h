// Lines of GPIO chips: what the driver needs of them, so that a model can stand in for the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// What the kernel keeps of a line that is not read (GPIO uAPI v1, GPIO_LINEEVENT_DATA_READ); the newest are then lost.
inline constexpr std::size_t kGpioQueueEdges = 16;

enum class GpioBias : std::uint8_t { kAsIs, kNone, kPullUp, kPullDown };

struct GpioLineRequest {
  std::string chip;  // "gpiochip0", "/dev/gpiochip0", or a label such as "pinctrl-bcm2711"
  std::string line;  // an offset, "17", or a name, "GPIO17"
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;  // kNone: switched off; kAsIs: left as it was
};

// Levels are logical: true is active, low voltage where active_low.
struct GpioEdge {
  TimeNs stamp_ns = 0;  // when the interrupt came, on the clock of the pump
  bool level = false;
};

// An input line that reports both edges. Gives the line back when destroyed. Used by one thread.
class GpioLine {
 public:
  virtual ~GpioLine() = default;
  // Readable when there are edges, or when the chip is gone; -1: next_edge_ns() tells.
  [[nodiscard]] virtual int fd() const = 0;
  [[nodiscard]] virtual TimeNs next_edge_ns() const { return kTimeNever; }
  // Up to edges.size() of them, oldest first, and how many; 0: none. Does not block. kDisconnected: the chip is gone;
  // kIo: the rest.
  virtual Result<std::size_t> read_edges(std::span<GpioEdge> edges) = 0;
  virtual Result<bool> read_level() = 0;
};

class GpioChips {
 public:
  virtual ~GpioChips() = default;
  // kNotFound: no such chip or line; kPermission; kIo: in use, by whom, and the rest; kUnsupported: the build, or a
  // bias that the kernel cannot set. The message names the next step.
  virtual Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) = 0;
};

// Those of this machine, through libgpiod; where the build has none, every request is kUnsupported.
[[nodiscard]] std::shared_ptr<GpioChips> make_gpio_chips();
// True where libgpiod was there at build time.
[[nodiscard]] bool built_with_gpio();

// The kernel stamps edges by CLOCK_MONOTONIC since 5.7 and by CLOCK_REALTIME before, and does not say which: the one
// that is nearer to its clock now. Returns a time of CLOCK_MONOTONIC that is not after `monotonic_now_ns`.
[[nodiscard]] TimeNs monotonic_stamp_ns(std::int64_t stamp_ns, TimeNs monotonic_now_ns, std::int64_t realtime_now_ns);

}  // namespace footlight::drivers
