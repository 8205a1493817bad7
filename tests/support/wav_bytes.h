// WAV files for tests, written field by field. Samples below 1.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

namespace footlight::testing {

enum class WavForm { kU8, kS16, kS24, kS32, kFloat, kDouble };

inline void put_bytes(std::string& out, std::uint64_t value, int count) {
  for (int i = 0; i < count; ++i) out.push_back(static_cast<char>(value >> (8 * i) & 0xff));
}

inline std::string wav_bytes(const std::vector<float>& interleaved, int rate_hz, int channels,
                             WavForm form = WavForm::kS16) {
  constexpr int kBytes[] = {1, 2, 3, 4, 4, 8};
  const int size = kBytes[static_cast<int>(form)];
  std::string data;
  for (const float sample : interleaved) {
    const double one = sample;
    switch (form) {
      case WavForm::kU8: put_bytes(data, static_cast<std::uint64_t>(std::lround(one * 128) + 128), 1); break;
      case WavForm::kS16: put_bytes(data, static_cast<std::uint64_t>(std::lround(one * 32'768)), 2); break;
      case WavForm::kS24: put_bytes(data, static_cast<std::uint64_t>(std::llround(one * 8'388'608)), 3); break;
      case WavForm::kS32: put_bytes(data, static_cast<std::uint64_t>(std::llround(one * 2'147'483'648.0)), 4); break;
      case WavForm::kFloat: put_bytes(data, std::bit_cast<std::uint32_t>(sample), 4); break;
      case WavForm::kDouble: put_bytes(data, std::bit_cast<std::uint64_t>(one), 8); break;
    }
  }
  std::string file = "RIFF";
  put_bytes(file, 36 + data.size(), 4);
  file += "WAVEfmt ";
  put_bytes(file, 16, 4);
  put_bytes(file, form >= WavForm::kFloat ? 3 : 1, 2);
  put_bytes(file, static_cast<std::uint64_t>(channels), 2);
  put_bytes(file, static_cast<std::uint64_t>(rate_hz), 4);
  put_bytes(file, static_cast<std::uint64_t>(rate_hz) * static_cast<std::uint64_t>(channels * size), 4);
  put_bytes(file, static_cast<std::uint64_t>(channels * size), 2);
  put_bytes(file, static_cast<std::uint64_t>(8 * size), 2);
  file += "data";
  put_bytes(file, data.size(), 4);
  return file + data;
}

}  // namespace footlight::testing
