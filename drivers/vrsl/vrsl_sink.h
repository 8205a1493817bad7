// DMX as pictures: encodes the newest levels at a fixed rate for a PictureOutput.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/vrsl/picture_port.h"
#include "drivers/vrsl/vrsl_options.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// Picture n is due n / rate after the first poll(), whether levels have changed or not, and has the levels of the last
// send() before that. A thread encodes and writes; poll() only copies the levels for it. A picture that the target
// takes too long for is left out and counted in counters().dropped. While the target refuses pictures the state is
// kGone, with the reason in trouble().
class VrslSink final : public Sink {
 public:
  // `options` from vrsl_out_options(). Errors: those of GridCodec::make().
  [[nodiscard]] static Result<std::unique_ptr<VrslSink>> open(const VrslOptions& options,
                                                              std::unique_ptr<PictureOutput> output);
  ~VrslSink() override;

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override;
  void take_figures(std::vector<PortFigure>& into) const override;
  Status send(TimeNs now_ns, std::span<const FrameView> frames) override;
  Status poll(TimeNs now_ns) override;
  [[nodiscard]] std::span<const Universe> universes() const override;
  // No pictures until the next send().
  void rest(TimeNs now_ns) override;
  // Waits until the pictures that were due are out, and ends the file.
  void close(TimeNs now_ns) override;

 private:
  struct Impl;
  explicit VrslSink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace footlight::drivers
