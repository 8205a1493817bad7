// The spectrum of the newest samples in 240 bins, 24 to an octave, from 13.75 Hz on: AudioLink's bins and amplitudes.
//
// Each bin is the correlation with a sine under a triangular window of eight periods, at most kWindowMaxS. The windows
// end at the newest sample. So the spectrum at a time depends on earlier samples only. A sine of amplitude a in the
// middle of a bin gives 1.25 a. A constant gives 0: the windows have no mean. Bins below 1,500 Hz are read from another
// stream with fewer samples a second. Bins above 0.45 of the sample rate are 0.
//
// Source of the method: AudioLink 2 (llealloo/audiolink, AudioLink.shader). Differences: docs/sound.md.
// Threads: none; not safe to share.
#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace footlight {

inline constexpr int kSpectrumBins = 240;
inline constexpr int kSpectrumBinsPerOctave = 24;
inline constexpr double kSpectrumBottomHz = 13.75;
inline constexpr double kSpectrumWindowMaxS = 1534.0 / 24'000.0;
using SpectrumBins = std::array<float, kSpectrumBins>;

// The frequency in the middle of a bin.
[[nodiscard]] double spectrum_bin_hz(int bin);

// Keeps one of `factor` samples, after a low-pass filter. Delays by 8 samples of its output.
class Decimator {
 public:
  explicit Decimator(int factor);
  // Appends to `out`.
  void push(std::span<const float> in, std::vector<float>& out);
  [[nodiscard]] int factor() const { return factor_; }

 private:
  int factor_;
  std::vector<float> taps_;
  std::vector<float> recent_;  // a ring, written twice, so that the newest taps_.size() samples are contiguous
  std::size_t at_ = 0;
  int until_next_ = 0;
};

class Spectrum {
 public:
  // rate_hz: 8,000 to 192,000.
  explicit Spectrum(double rate_hz);
  // Finite samples, oldest first.
  void push(std::span<const float> mono);
  // At the newest sample, without corrections of any kind.
  void read(SpectrumBins& magnitudes) const;

 private:
  struct Stream {
    void keep(std::span<const float> added);
    double rate_hz = 0;
    std::vector<float> samples;  // the newest ones at the end
    std::size_t length_max = 0;  // the longest window
  };
  struct Kernel {
    std::size_t stream = 0;
    std::size_t length = 0;  // 0: the bin is above the highest frequency
    std::vector<float> cosine;
    std::vector<float> sine;
  };
  static Kernel make_kernel(int bin, double rate_hz);

  Decimator input_;  // to 40 to 80 kHz
  Decimator low_;    // to 6 to 12 kHz
  std::array<Stream, 2> streams_;
  std::vector<Kernel> kernels_;
  std::vector<float> decimated_;
  std::vector<float> low_samples_;
};

}  // namespace footlight
