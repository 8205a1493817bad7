// Parses the text "metadata" of a sigrok capture (.sr): probes, sample rate, names. An INI file, as libsigrok 0.5 and
// 0.6 write it; unused keys are ignored. Bytes only.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"

namespace footlight::drivers {

struct SigrokProbe {
  int number = 0;  // sigrok's number, from 1; its bit in a sample is number - 1
  std::string name;
};

struct SigrokMetadata {
  std::string capture_file;  // "logic-1": the samples are in that file, or in logic-1-1, logic-1-2, ...
  std::uint64_t sample_rate_hz = 0;
  int probe_count = 0;              // 1 to 64
  std::size_t unit_size = 1;        // bytes of a sample, 1 to 8; holds every probe
  std::vector<SigrokProbe> probes;  // named probes, ascending, each once
};

inline constexpr std::size_t kSigrokMetadataBytesMax = 64u << 10;

// Of the first device with logic data. `path` starts the messages. kBadInput names the key.
[[nodiscard]] Result<SigrokMetadata> parse_sigrok_metadata(std::string_view text, const std::string& path);

}  // namespace footlight::drivers
