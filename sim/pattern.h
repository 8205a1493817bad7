// A made-up console: a source that plays a pattern, to try the program without hardware or network.
//
//   FL_ASSIGN(const Pattern pattern, pattern_of("chase"));
//   PatternSource source("mock:chase", pattern, every_slot(universes));
//
// The slots are grouped in voices, which move together. A voice has a light from 0 to 1; each of its slots goes from
// its dark level to its lit level. With every_slot() each slot is a voice; a rig makes one voice of each fixture.
// 16-bit values are interpolated byte by byte, so the fine byte is wrong by up to a step of the coarse one: 1/255.
//
// Frames come 40 times a second, as from a console, at priority 0: every other sender wins. A pattern depends on the
// clock and the tempo (sim/tempo.h) alone, so two sources with one of each play in step.
//
// Threads: the pump's; play() may be called from any thread.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sim/core/dmx.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/tempo.h"

namespace footlight {

enum class Pattern : std::uint8_t {
  kChase,  // every fourth voice is lit, the next one with the next beat: a voice flashes every 2 s at 120 a minute
  kFull,   // all are lit
  kSine,   // each rises and falls once in 8 beats, 4 s; together they are one wave over all voices
};
inline constexpr std::array<std::string_view, 3> kPatternWords{"chase", "full", "sine"};  // as Pattern
inline constexpr DurationNs kPatternFrameNs = 25 * kNsPerMs;
inline constexpr std::size_t kChaseVoices = 4;
inline constexpr std::int64_t kSineBeats = 8;
// At the default tempo.
inline constexpr DurationNs kChaseStepNs = 500 * kNsPerMs;
inline constexpr DurationNs kSineNs = kSineBeats * kChaseStepNs;

// kBadInput names the words there are.
[[nodiscard]] Result<Pattern> pattern_of(std::string_view word);
[[nodiscard]] bool is_pattern(std::string_view word);

struct PatternSlot {
  std::uint32_t index = 0;  // of the level: universe's place in the plan x 512 + slot
  std::uint8_t dark = 0;
  std::uint8_t lit = 255;
};
struct PatternPlan {
  std::vector<Universe> universes;   // ascending, each once
  std::vector<std::uint8_t> levels;  // universes x 512: of the slots that are in no voice
  std::vector<std::vector<PatternSlot>> voices;
};
// Every slot is a voice, from 0 to 255.
[[nodiscard]] PatternPlan every_slot(std::vector<Universe> universes);

// The light of a voice, 0 to 1.
[[nodiscard]] double pattern_light(Pattern pattern, std::size_t voice, std::size_t voices, const TempoBeat& beat);

class PatternSource final : public Source {
 public:
  // tempo: null: the default one.
  PatternSource(std::string name, Pattern pattern, PatternPlan plan, std::shared_ptr<const Tempo> tempo = {});

  // Another plan for the same universes, from the next frame on.
  void play(PatternPlan plan);

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return next_ns_; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {.frames = frames_}; }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;
  [[nodiscard]] std::span<const Universe> universes() const override { return universes_; }
  [[nodiscard]] std::string sender_text(SenderId) const override { return name_ + " (made up)"; }

 private:
  const std::string name_;
  const Pattern pattern_;
  const std::vector<Universe> universes_;
  const std::shared_ptr<const Tempo> tempo_;
  std::mutex mutex_;
  std::shared_ptr<const PatternPlan> plan_;  // guarded by mutex_
  std::vector<std::uint8_t> levels_;
  TimeNs next_ns_ = 0;
  std::uint64_t frames_ = 0;
  std::uint32_t sequence_ = 0;
};

}  // namespace footlight
