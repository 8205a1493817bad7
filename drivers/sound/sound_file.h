// Reads sound files: whatever the installed libav decodes, as float samples.
//
//   FL_ASSIGN(const std::unique_ptr<SoundFile> file, SoundFile::open("track.flac"));
//   std::vector<float> samples;
//   while (true) {
//     FL_ASSIGN(const bool more, file->read(samples));
//     if (!more) break;
//   }
//
// Of a video or a file with several tracks the first sound track is read. Threads: none; one thread at a time.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/core/result.h"

namespace footlight::drivers {

struct SoundInfo {
  int rate_hz = 0;        // 8,000 to 192,000
  int channels = 0;       // 1 to 8
  std::string codec;      // "flac"
  std::string container;  // "flac", "wav", "mov,mp4,m4a,3gp,3g2,mj2"
};

class SoundFile {
 public:
  virtual ~SoundFile() = default;
  // Errors: kNotFound, kPermission, kBadInput (no sound, or a rate or number of channels out of range), kUnsupported
  // (this build has no libav, or it lacks the decoder).
  [[nodiscard]] static Result<std::unique_ptr<SoundFile>> open(const std::string& path);
  [[nodiscard]] virtual const SoundInfo& info() const = 0;
  // Replaces `interleaved` by the next samples, 1 is full scale: at least one frame. False at the end. Samples of
  // float files may be NaN, infinite or above 1. A damaged packet is left out and counted.
  virtual Result<bool> read(std::vector<float>& interleaved) = 0;
  [[nodiscard]] virtual std::uint64_t damaged_packets() const = 0;
};

}  // namespace footlight::drivers
