#include "sim/pattern.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <utility>

#include "sim/core/check.h"

namespace footlight {

Result<Pattern> pattern_of(std::string_view word) {
  const auto at = std::find(kPatternWords.begin(), kPatternWords.end(), word);
  if (at == kPatternWords.end()) {
    return fail(ErrorCode::kBadInput, "\"{}\" is no pattern; expected chase, full or sine", word);
  }
  return static_cast<Pattern>(at - kPatternWords.begin());
}

bool is_pattern(std::string_view word) { return pattern_of(word).has_value(); }

PatternPlan every_slot(std::vector<Universe> universes) {
  PatternPlan plan;
  plan.universes = std::move(universes);
  plan.levels.resize(plan.universes.size() * kSlotCountMax);
  for (std::uint32_t i = 0; i < plan.levels.size(); ++i) plan.voices.push_back({{.index = i}});
  return plan;
}

double pattern_light(Pattern pattern, std::size_t voice, std::size_t voices, const TempoBeat& beat) {
  switch (pattern) {
    case Pattern::kFull: return 1;
    case Pattern::kChase: return voice % kChaseVoices == static_cast<std::size_t>(beat.count) % kChaseVoices ? 1 : 0;
    case Pattern::kSine: {
      const double turns = (static_cast<double>(beat.count % kSineBeats) + beat.share) / kSineBeats -
                           static_cast<double>(voice) / static_cast<double>(std::max<std::size_t>(voices, 1));
      return 0.5 - 0.5 * std::cos(2 * std::numbers::pi * turns);
    }
  }
  return 0;
}

PatternSource::PatternSource(std::string name, Pattern pattern, PatternPlan plan, std::shared_ptr<const Tempo> tempo)
    : name_(std::move(name)),
      pattern_(pattern),
      universes_(plan.universes),
      tempo_(tempo ? std::move(tempo) : std::make_shared<const Tempo>()) {
  play(std::move(plan));
}

void PatternSource::play(PatternPlan plan) {
  FL_CHECK(plan.universes == universes_);
  FL_CHECK(plan.levels.size() == universes_.size() * kSlotCountMax);
  auto shared = std::make_shared<const PatternPlan>(std::move(plan));
  const std::lock_guard lock(mutex_);
  plan_.swap(shared);  // the one before is freed here, unless the pump has it
}

Status PatternSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  if (now_ns < next_ns_) return {};
  next_ns_ = now_ns - now_ns % kPatternFrameNs + kPatternFrameNs;  // late frames are left out
  std::shared_ptr<const PatternPlan> plan;
  {
    const std::lock_guard lock(mutex_);
    plan = plan_;
  }
  levels_ = plan->levels;
  const TempoBeat beat = tempo_->at(now_ns);
  for (std::size_t voice = 0; voice < plan->voices.size(); ++voice) {
    const double light = pattern_light(pattern_, voice, plan->voices.size(), beat);
    for (const PatternSlot& slot : plan->voices[voice]) {
      levels_[slot.index] = static_cast<std::uint8_t>(std::lround(slot.dark + light * (slot.lit - slot.dark)));
    }
  }
  ++sequence_;
  for (std::size_t i = 0; i < universes_.size(); ++i) {
    FrameView frame;
    frame.universe = universes_[i];
    frame.stamp_ns = now_ns;
    frame.sender = std::hash<std::string>{}(name_) | 1u;
    frame.sequence = sequence_;
    frame.priority = 0;
    frame.slots = std::span(levels_).subspan(i * kSlotCountMax, kSlotCountMax);
    ++frames_;
    receiver.receive(frame);
  }
  return {};
}

}  // namespace footlight
