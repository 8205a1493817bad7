// The interface to lines of GPIO chips, so that a model can replace the kernel.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// The kernel's queue per line (GPIO uAPI v1, GPIO_LINEEVENT_DATA_READ). When it is full, the newest edges are lost.
inline constexpr std::size_t kGpioQueueEdges = 16;

enum class GpioBias : std::uint8_t { kAsIs, kNone, kPullUp, kPullDown };

struct GpioLineRequest {
  std::string chip;  // "gpiochip0", "/dev/gpiochip0", or a label such as "pinctrl-bcm2711"
  std::string line;  // an offset, "17", or a name, "GPIO17"
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;  // kNone: switched off; kAsIs: not changed
};

// Levels are logical: true is active, which is low voltage with active_low.
struct GpioEdge {
  TimeNs stamp_ns = 0;  // when the interrupt came, on the pump's clock
  bool level = false;
};

// An input line that reports both edges. Releases the line when destroyed. Used by one thread.
class GpioLine {
 public:
  virtual ~GpioLine() = default;
  // Readable when there are edges or the chip is gone; -1: use next_edge_ns().
  [[nodiscard]] virtual int fd() const = 0;
  [[nodiscard]] virtual TimeNs next_edge_ns() const { return kTimeNever; }
  // Reads up to edges.size() edges, oldest first, and returns their number; 0: none. Does not block. kDisconnected: the
  // chip is gone; kIo: any other error.
  virtual Result<std::size_t> read_edges(std::span<GpioEdge> edges) = 0;
  virtual Result<bool> read_level() = 0;
};

class GpioChips {
 public:
  virtual ~GpioChips() = default;
  // kNotFound: no such chip or line; kPermission; kIo: in use (names the user), and other errors; kUnsupported: the
  // build, or a bias that the kernel cannot set. The message names the next step.
  virtual Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) = 0;
};

// The chips of this machine, through libgpiod. In a build without it, every request is kUnsupported.
[[nodiscard]] std::shared_ptr<GpioChips> make_gpio_chips();
// True if libgpiod was available at build time.
[[nodiscard]] bool built_with_gpio();

// The kernel stamps edges with CLOCK_MONOTONIC since 5.7 and with CLOCK_REALTIME before, without saying which. This
// uses the clock whose current time is nearer to the stamp. Returns a time of CLOCK_MONOTONIC that is not after
// `monotonic_now_ns`.
[[nodiscard]] TimeNs monotonic_stamp_ns(std::int64_t stamp_ns, TimeNs monotonic_now_ns, std::int64_t realtime_now_ns);

}  // namespace footlight::drivers
