// Pictures as DMX: decodes what a PictureInput gives.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/vrsl/grid.h"
#include "drivers/vrsl/picture_port.h"
#include "drivers/vrsl/vrsl_options.h"
#include "sim/core/ports.h"

namespace footlight::drivers {

// What became of pictures. Each is in exactly one of the first five.
struct VrslReaderCounters {
  std::uint64_t used = 0;
  std::uint64_t no_grid = 0;    // none was found
  std::uint64_t uncertain = 0;  // the confidence of a universe was below kGridConfidenceMin
  std::uint64_t damaged = 0;    // by the check row
  std::uint64_t repeated = 0;   // the number of the check row is that of the picture before
  std::uint64_t lost = 0;       // numbers of the check row that never came
};

// Decodes one picture after another: finds the grid, refuses pictures that are damaged or show something else, and
// counts. Threads: one.
class VrslReader {
 public:
  explicit VrslReader(const VrslOptions& options) : options_(options) {}
  // True: levels() and the rest are of this picture. False: it was refused, and refusal() is why.
  [[nodiscard]] bool read(const PictureView& picture);
  [[nodiscard]] std::span<const std::uint8_t> levels() const { return levels_; }  // 9 x 512
  [[nodiscard]] const std::optional<GridCodec>& codec() const { return codec_; }
  [[nodiscard]] const GridReading& reading() const { return reading_; }
  [[nodiscard]] const VrslReaderCounters& counters() const { return counters_; }
  [[nodiscard]] const std::string& refusal() const { return refusal_; }
  [[nodiscard]] const std::vector<std::string>& open() const { return open_; }  // GridFinding::open

 private:
  bool find(const PictureView& picture);
  [[nodiscard]] float confidence() const;

  VrslOptions options_;
  std::optional<GridCodec> codec_;
  std::vector<std::uint8_t> levels_ = std::vector<std::uint8_t>(std::size_t{kGridUniversesMax} * kSlotCountMax);
  GridReading reading_;
  VrslReaderCounters counters_;
  std::string refusal_;
  std::vector<std::string> open_;
  std::optional<std::uint16_t> last_sequence_;
  int refused_in_a_row_ = 0;
};

// Pictures of files are due at their times since the first poll(), live ones when they come. A frame for each universe
// of every picture; refused pictures give none, so that a universe whose pictures stay unreadable falls silent and the
// merge removes it. A thread reads and decodes.
class VrslSource final : public Source {
 public:
  // `options` from vrsl_in_options().
  [[nodiscard]] static Result<std::unique_ptr<VrslSource>> open(const VrslOptions& options,
                                                                std::unique_ptr<PictureInput> input);
  ~VrslSource() override;

  [[nodiscard]] std::string name() const override;
  [[nodiscard]] int poll_fd() const override;
  [[nodiscard]] TimeNs next_deadline_ns() const override;
  [[nodiscard]] PortState state() const override;
  [[nodiscard]] std::string trouble() const override;
  [[nodiscard]] PortCounters counters() const override;
  void take_figures(std::vector<PortFigure>& into) const override;
  [[nodiscard]] std::optional<PortNotice> take_notice() override;
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override;

 private:
  struct Impl;
  explicit VrslSource(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

// "horizontal-bottom, rgb, full, linear, at 0, 872 with cells of 16 px"
[[nodiscard]] std::string text_of(const GridCodec& codec);

}  // namespace footlight::drivers
