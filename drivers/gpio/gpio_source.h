// Strobe inputs: lines of one GPIO chip as a source of DMX. Each line owns one slot, in the order of the lines from one
// address on. StrobeConfig (strobe_line.h) sets the effect of an edge.
//
// - Edges come from the kernel's interrupts with the kernel's stamps; nothing is polled. Each change delivers a frame
//   with the stamp of its edge.
// - The whole frame is repeated every 800 ms, with its own silence limit, so that no merge timeout removes it.
// - Only the slots of the lines have a priority (frames with start code 0xDD). Other slots are not claimed, even under
//   LTP and at high priorities.
// - If the chip is gone or a line cannot be read, every line of the port is off and the port is kGone. It requests its
//   lines again four times a second, and reads the levels when it succeeds.
// - Levels are read again every second, after every full queue and at the end of every debounce window, so that no lost
//   edge leaves a lamp on.
// - A line with more than 200 edges within 100 ms (a floating input) is ignored for 100 ms; then its level is read.
#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "drivers/gpio/gpio_chip.h"
#include "drivers/gpio/strobe_line.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

struct GpioConfig {
  // Required.
  std::string chip;                // GpioLineRequest::chip
  std::vector<std::string> lines;  // GpioLineRequest::line; not empty, no line twice
  // Optional.
  Universe universe = 1;
  Address address = 1;  // of the first line; the others follow, to 512 at most
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;
  StrobeConfig strobe;  // of every line
  std::uint8_t priority = kPriorityDefault;
  bool wait_for_device = false;  // open() succeeds even if the chip is missing
  std::string name = {};         // Port::name(); empty: "gpio:" and the chip
};

class GpioSource final : public Source {
 public:
  // Errors: kBadInput (more lines than addresses), and those of GpioChips::request(); the message starts with the name.
  [[nodiscard]] static Result<std::unique_ptr<GpioSource>> open(GpioConfig config, std::shared_ptr<GpioChips> chips,
                                                                Clock& clock);
  ~GpioSource() override;
  GpioSource(const GpioSource&) = delete;
  GpioSource& operator=(const GpioSource&) = delete;

  [[nodiscard]] std::string name() const override { return config_.name; }
  [[nodiscard]] int poll_fd() const override { return epoll_fd_; }
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override { return is_open() ? PortState::kWorking : PortState::kGone; }
  [[nodiscard]] std::string trouble() const override { return trouble_; }
  [[nodiscard]] PortCounters counters() const override;
  [[nodiscard]] std::optional<PortNotice> take_notice() override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override { return {&config_.universe, 1}; }

  // For the line with that index in GpioConfig::lines.
  [[nodiscard]] const StrobeLine& strobe(std::size_t line) const { return lines_[line].strobe; }

 private:
  struct Line {
    explicit Line(const StrobeConfig& config) : strobe(config) {}
    StrobeLine strobe;
    std::unique_ptr<GpioLine> input;       // nullptr: gone
    std::uint8_t sent = 0;                 // its value in the last frame
    TimeNs storm_ns = 0;                   // start of the 100 ms in which edges are counted
    int storm_edges = 0;                   // so far
    TimeNs ignored_until_ns = kTimeNever;  // after a storm
    std::uint64_t reported_capped = 0;     // value of the counter that was reported last
  };

  GpioSource(GpioConfig config, std::shared_ptr<GpioChips> chips, Clock& clock);
  Status make_epoll();
  Status open_lines(TimeNs now_ns);
  void lose_lines(const Error& error, TimeNs now_ns, FrameReceiver& receiver);
  [[nodiscard]] bool is_open() const { return lines_.front().input != nullptr; }
  Status listen(std::size_t index, bool on);

  Status read_ready(TimeNs now_ns, FrameReceiver& receiver);
  Status read_line(std::size_t index, TimeNs now_ns, FrameReceiver& receiver);
  Status read_due_levels(TimeNs now_ns, FrameReceiver& receiver);
  void deliver_changes(FrameReceiver& receiver);
  void deliver(TimeNs stamp_ns, std::uint8_t start_code, FrameReceiver& receiver);
  void report_capped(TimeNs now_ns);

  GpioConfig config_;
  std::shared_ptr<GpioChips> chips_;
  Clock& clock_;
  std::vector<Line> lines_;
  int epoll_fd_ = -1;
  std::array<std::uint8_t, kSlotCountMax> levels_{};
  std::array<std::uint8_t, kSlotCountMax> priorities_{};
  std::uint32_t sequence_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t errors_ = 0;
  TimeNs repeat_ns_ = INT64_MIN;         // when the whole frame is due again
  TimeNs read_levels_ns_ = 0;            // when all levels are read again
  TimeNs retry_ns_ = kTimeNever;         // while gone
  TimeNs report_capped_ns_ = INT64_MIN;  // not before
  TimeNs report_storm_ns_ = INT64_MIN;   // not before
  std::string trouble_;
  std::vector<PortNotice> notices_;  // oldest first
};

// The source of an endpoint: lines of this machine, or of the model if the chip is "mock".
[[nodiscard]] Result<std::unique_ptr<Source>> open_gpio_source(GpioConfig config, Clock& clock);

}  // namespace footlight::drivers
