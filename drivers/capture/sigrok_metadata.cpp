#include "drivers/capture/sigrok_metadata.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>

#include "drivers/capture/dmx_line.h"
#include "sim/core/words.h"

namespace footlight::drivers {
namespace {

constexpr int kProbesMax = 64;
constexpr std::size_t kNameCharsMax = 64;

template <class T>
std::optional<T> number(std::string_view text) {
  T value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || end != text.data() + text.size()) return {};
  return value;
}

// Accepts "12 MHz", "500 kHz", "24000000", "1.5 MHz".
std::optional<std::uint64_t> sample_rate(std::string_view text) {
  const std::size_t space = text.find(' ');
  const auto value = number<double>(text.substr(0, space));
  const std::string_view unit = space == std::string_view::npos ? "Hz" : trimmed(text.substr(space));
  double scale = 0.0;
  if (unit == "Hz") scale = 1.0;
  if (unit == "kHz") scale = 1e3;
  if (unit == "MHz") scale = 1e6;
  if (unit == "GHz") scale = 1e9;
  if (!value || scale == 0.0) return {};
  const double rate_hz = *value * scale;
  if (!(rate_hz >= 1.0 && rate_hz <= 1e12)) return {};
  return static_cast<std::uint64_t>(std::llround(rate_hz));
}

// Quotes text in a message.
std::string quote(std::string_view text) {
  std::string out = "'";
  for (const char c : text.substr(0, kNameCharsMax)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + "'";
}

}  // namespace

Result<SigrokMetadata> parse_sigrok_metadata(std::string_view text, const std::string& path) {
  SigrokMetadata metadata;
  bool in_device = false;
  bool any_unit_size = false;
  while (!text.empty()) {
    const std::size_t line_end = text.find('\n');
    const std::string_view line = trimmed(text.substr(0, line_end));
    text = line_end == std::string_view::npos ? std::string_view{} : text.substr(line_end + 1);
    if (line.starts_with('[')) {
      if (!metadata.capture_file.empty()) break;  // the device is complete
      in_device = line.starts_with("[device");
      continue;
    }
    const std::size_t equals = line.find('=');
    if (!in_device || equals == std::string_view::npos) continue;
    const std::string_view key = trimmed(line.substr(0, equals));
    const std::string_view value = trimmed(line.substr(equals + 1));
    if (key == "capturefile") {
      if (value.empty() || value.size() > kNameCharsMax) {
        return fail(ErrorCode::kBadInput, "{}: metadata: capturefile: expected a name, got {}", path, quote(value));
      }
      metadata.capture_file = value;
    } else if (key == "samplerate") {
      const auto rate_hz = sample_rate(value);
      if (!rate_hz) {
        return fail(ErrorCode::kBadInput, "{}: metadata: samplerate: expected a rate as in '1 MHz', got {}", path,
                    quote(value));
      }
      metadata.sample_rate_hz = *rate_hz;
    } else if (key == "total probes") {
      const auto count = number<int>(value);
      if (!count || *count < 1 || *count > kProbesMax) {
        return fail(ErrorCode::kBadInput, "{}: metadata: total probes: expected 1 to {}, got {}", path, kProbesMax,
                    quote(value));
      }
      metadata.probe_count = *count;
    } else if (key == "unitsize") {
      const auto size = number<std::size_t>(value);
      if (!size || *size < 1 || *size > kProbesMax / 8) {
        return fail(ErrorCode::kBadInput, "{}: metadata: unitsize: expected 1 to {} bytes, got {}", path,
                    kProbesMax / 8, quote(value));
      }
      metadata.unit_size = *size;
      any_unit_size = true;
    } else if (key.starts_with("probe")) {
      const auto probe = number<int>(key.substr(5));
      if (!probe || *probe < 1 || *probe > kProbesMax) continue;
      const auto same = [&](const SigrokProbe& one) { return one.number == *probe; };
      if (std::any_of(metadata.probes.begin(), metadata.probes.end(), same)) continue;
      metadata.probes.push_back({*probe, std::string(value.substr(0, kNameCharsMax))});
    }
  }
  if (metadata.capture_file.empty()) {
    return fail(ErrorCode::kBadInput, "{}: metadata: no logic samples (capturefile); is it an analog capture?", path);
  }
  if (metadata.sample_rate_hz < kLineSampleRateMinHz || metadata.sample_rate_hz > kLineSampleRateMaxHz) {
    return fail(ErrorCode::kBadInput, "{}: {} Hz: expected a sample rate from {} Hz (a bit of DMX has 4 us) to {} Hz",
                path, metadata.sample_rate_hz, kLineSampleRateMinHz, kLineSampleRateMaxHz);
  }
  std::sort(metadata.probes.begin(), metadata.probes.end(),
            [](const SigrokProbe& a, const SigrokProbe& b) { return a.number < b.number; });
  if (!metadata.probes.empty()) metadata.probe_count = std::max(metadata.probe_count, metadata.probes.back().number);
  if (metadata.probe_count == 0) {
    return fail(ErrorCode::kBadInput, "{}: metadata: expected the number of probes ('total probes')", path);
  }
  const std::size_t bytes = (static_cast<std::size_t>(metadata.probe_count) + 7) / 8;
  if (!any_unit_size) metadata.unit_size = bytes;
  if (metadata.unit_size < bytes) {
    return fail(ErrorCode::kBadInput, "{}: metadata: {} probes do not fit a unitsize of {}", path, metadata.probe_count,
                metadata.unit_size);
  }
  return metadata;
}

}  // namespace footlight::drivers
