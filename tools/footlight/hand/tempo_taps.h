// An input whose lines tap the tempo (gpio:gpiochip0/17=tempo): each slot that turns on is a tap, at the time of its
// frame, which is the kernel's stamp of the edge. It delivers no frames. Threads: the pump's.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/core/ports.h"
#include "sim/tempo.h"

namespace footlight::tools {

class TempoTaps final : public Source {
 public:
  TempoTaps(std::unique_ptr<Source> lines, std::shared_ptr<Tempo> tempo)
      : lines_(std::move(lines)), taps_(std::move(tempo)) {}

  [[nodiscard]] std::string name() const override { return lines_->name(); }
  [[nodiscard]] int poll_fd() const override { return lines_->poll_fd(); }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return lines_->next_deadline_ns(); }
  [[nodiscard]] PortState state() const override { return lines_->state(); }
  [[nodiscard]] std::string trouble() const override { return lines_->trouble(); }
  [[nodiscard]] PortCounters counters() const override { return lines_->counters(); }
  void take_figures(std::vector<PortFigure>& into) const override { lines_->take_figures(into); }
  [[nodiscard]] std::optional<PortNotice> take_notice() override { return lines_->take_notice(); }
  Status poll(TimeNs now_ns, FrameReceiver& /*receiver*/) override { return lines_->poll(now_ns, taps_); }
  [[nodiscard]] std::span<const Universe> universes() const override { return {}; }

 private:
  class Taps final : public FrameReceiver {
   public:
    explicit Taps(std::shared_ptr<Tempo> tempo) : tempo_(std::move(tempo)) {}
    void receive(const FrameView& frame) override;

   private:
    std::shared_ptr<Tempo> tempo_;
    Slots last_ = {};
    bool known_ = false;  // of the lines as they stand now: one that is on at the start is no tap
  };

  std::unique_ptr<Source> lines_;
  Taps taps_;
};

}  // namespace footlight::tools
