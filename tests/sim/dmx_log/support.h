// Shared by the tests of the log: frames that own their slots, a temporary folder, traffic generated from a seed.
#pragma once

#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <unistd.h>

#include <doctest/doctest.h>

#include "sim/core/check.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/log_input.h"
#include "tests/support/temp_folder.h"

namespace footlight::testing {

// SplitMix64 (Steele, Lea, Flood 2014): the same on every machine.
class Random {
 public:
  explicit Random(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    std::uint64_t z = state_ += 0x9E3779B97F4A7C15u;
    z = (z ^ z >> 30) * 0xBF58476D1CE4E5B9u;
    z = (z ^ z >> 27) * 0x94D049BB133111EBu;
    return z ^ z >> 31;
  }
  std::uint64_t below(std::uint64_t bound) { return next() % bound; }
  int between(int low, int high) { return low + static_cast<int>(below(static_cast<std::uint64_t>(high - low + 1))); }
  std::uint8_t byte() { return static_cast<std::uint8_t>(next()); }

 private:
  std::uint64_t state_;
};

struct OwnedFrame {
  DurationNs time_ns = 0;
  Universe universe = 0;
  SenderId sender = 0;
  std::uint32_t sequence = 0;
  std::uint8_t priority = kPriorityDefault;
  bool terminated = false;
  std::vector<std::uint8_t> slots;
  bool operator==(const OwnedFrame&) const = default;

  [[nodiscard]] FrameView view(TimeNs origin_ns = 0) const {
    FrameView view;
    view.universe = universe;
    view.stamp_ns = origin_ns + time_ns;
    view.sender = sender;
    view.sequence = sequence;
    view.priority = priority;
    view.terminated = terminated;
    view.slots = slots;
    return view;
  }
};

inline OwnedFrame own(const LogFrame& frame) {
  OwnedFrame owned{frame.time_ns, frame.universe, frame.sender, frame.sequence, frame.priority, frame.terminated, {}};
  if (!frame.terminated) owned.slots.assign(frame.slots().begin(), frame.slots().end());
  return owned;
}

inline std::vector<std::uint8_t> read_bytes(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  REQUIRE(stream.good());
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

inline void write_bytes(const std::string& path, const std::string& text) {
  std::ofstream stream(path, std::ios::binary);
  stream << text;
  REQUIRE(stream.good());
}

// Frames of every kind: short and long, repeats, small and large changes, several senders, ends of streams.
inline std::vector<OwnedFrame> random_frames(std::uint64_t seed, int count, int universe_count) {
  Random random(seed);
  std::vector<OwnedFrame> frames;
  std::vector<OwnedFrame> last(static_cast<std::size_t>(universe_count));
  DurationNs time_ns = static_cast<DurationNs>(random.below(3)) * 1'234'567;
  for (int i = 0; i < count; ++i) {
    const auto index = static_cast<std::size_t>(random.below(last.size()));
    OwnedFrame& frame = last[index];
    frame.universe = 1 + static_cast<Universe>(index) * 7;
    frame.terminated = false;
    frame.sequence = random.below(50) == 0 ? static_cast<std::uint32_t>(random.next()) : (frame.sequence + 1) & 0xFF;
    if (frame.slots.empty() || random.below(40) == 0) {
      frame.slots.resize(random.below(4) == 0 ? random.below(513) : 512);
    }
    switch (random.below(6)) {
      case 0: break;  // a repeat
      case 1:
        for (auto& slot : frame.slots) slot = random.byte();
        break;
      case 2:
        for (auto& slot : frame.slots) ++slot;
        break;
      default:
        for (int change = 0; change < 5 && !frame.slots.empty(); ++change) {
          frame.slots[random.below(frame.slots.size())] = random.byte();
        }
    }
    if (random.below(60) == 0) frame.sender = random.next();
    if (random.below(60) == 0) frame.priority = static_cast<std::uint8_t>(random.below(201));
    time_ns += static_cast<DurationNs>(random.below(3) == 0 ? 0 : random.below(5'000'000));
    frame.time_ns = time_ns;
    frames.push_back(frame);
    if (random.below(100) == 0) {
      frames.back().terminated = true;
      frames.back().slots.clear();
    }
  }
  return frames;
}

// Writes a log and returns its bytes.
inline std::vector<std::uint8_t> log_bytes(const std::vector<OwnedFrame>& frames, DurationNs end_ns,
                                           LogWriterOptions options = {}) {
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  auto writer = LogWriter::create(path, options);
  REQUIRE_MESSAGE(writer, writer.error().message);
  for (const OwnedFrame& frame : frames) REQUIRE(writer->append(frame.view(options.origin_ns)));
  REQUIRE(writer->close(options.origin_ns + end_ns));
  return read_bytes(path);
}

inline Result<ConvertReport> convert_file(const std::string& in, const std::string& out,
                                          const ConvertOptions& options = {}) {
  FL_ASSIGN(const auto input, open_log_input(in));
  return convert_log(*input, out, options);
}

inline LogReader open_log(std::vector<std::uint8_t> bytes) {
  auto reader = LogReader::open_bytes(std::move(bytes), "a.dmxlog");
  REQUIRE_MESSAGE(reader, reader.error().message);
  return std::move(*reader);
}

// All frames that a sender sent; those restored after damage are counted in `restored`.
inline std::vector<OwnedFrame> all_frames(LogReader& reader, int* restored = nullptr) {
  std::vector<OwnedFrame> frames;
  LogFrame frame;
  while (true) {
    const auto any = reader.next(frame);
    REQUIRE_MESSAGE(any, any.error().message);
    if (!*any) return frames;
    if (frame.restored) {
      if (restored != nullptr) ++*restored;
      continue;
    }
    frames.push_back(own(frame));
  }
}

}  // namespace footlight::testing
