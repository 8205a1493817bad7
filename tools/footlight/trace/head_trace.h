// The states of a rig's heads over time as rows of named numbers, for tests and spreadsheets that need no picture.
//
// The heads are stepped by the same walker in float that the GPU runs (fixtures/simulate/walker.h). Fed by the same
// Timeline, its states are those behind the pictures of `footlight render`.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/clock.h"

namespace footlight::tools {

// Nothing: the head has no such part.
using TraceValue = std::variant<std::monostate, std::string, std::int64_t, float>;
// The name ends with the unit: pan_deg, light_lm. Without one it is a share, a count or a place on a wheel.
using TraceRow = std::vector<std::pair<const char*, TraceValue>>;

class HeadTrace {
 public:
  // Both outlive this.
  HeadTrace(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled);
  ~HeadTrace();
  HeadTrace(const HeadTrace&) = delete;
  HeadTrace& operator=(const HeadTrace&) = delete;

  // Only these heads are stepped from here on, and only they may be given to row(). Others keep their states.
  void follow(std::vector<std::size_t> heads);

  // As Timeline::Step: levels that are held for dt_ns >= 0. new_exposure: the means of light and shutter begin anew.
  void step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure);

  [[nodiscard]] std::size_t head_count() const;
  // Which fixture of Rig::fixtures the head belongs to, and its number within that fixture, from 1.
  [[nodiscard]] std::size_t fixture_of(std::size_t head) const;
  [[nodiscard]] int number_of(std::size_t head) const;
  // All columns of a head, the same names in the same order for every head. docs/trace.md lists them.
  [[nodiscard]] TraceRow row(std::size_t head, DurationNs time_ns) const;

 private:
  struct State;

  const fixtures::Rig& rig_;
  const fixtures::CompiledRig& compiled_;
  std::unique_ptr<State> state_;
  std::vector<std::size_t> followed_;  // all, unless follow() said otherwise
};

// One line with its newline. CSV as RFC 4180 has it but for the line's end, which is that of the system: names, and
// values; a part that is not there is an empty cell, in JSON null. Numbers are written so that they read back equal.
[[nodiscard]] std::string csv_names_of(const TraceRow& row);
[[nodiscard]] std::string csv_line_of(const TraceRow& row);
[[nodiscard]] std::string json_line_of(const TraceRow& row);

}  // namespace footlight::tools
