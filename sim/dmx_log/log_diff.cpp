#include "sim/dmx_log/log_diff.h"

#include <algorithm>
#include <array>
#include <bitset>
#include <cmath>
#include <cstdlib>
#include <map>
#include <unordered_map>
#include <utility>

namespace footlight {
namespace {

constexpr std::size_t kWindow = 48;       // frames of each side aligned at a time
constexpr DurationNs kReachNs = kNsPerS;  // the largest distance of a pair
constexpr DurationNs kPeriodMinNs = kNsPerMs;
constexpr std::size_t kVotersMax = 100'000;  // changes of a universe used to estimate the offset
// Costs of an alignment. A pair that differs costs less than two frames left over; a distance of one period costs half.
constexpr double kCostDifferent = 3.0;
constexpr double kCostLeftOver = 2.0;
constexpr double kCostPeriod = 0.5;
constexpr double kCostTimeMax = 8.0;

// The data of one frame that alignment needs.
struct Mark {
  DurationNs time_ns = 0;
  std::uint64_t hash = 0;  // of all levels
  bool change = false;
};
using Marks = std::vector<Mark>;

struct Pair {
  std::uint32_t a = 0;  // indices into Marks
  std::uint32_t b = 0;
};

// Hashes eight levels at a time with the finaliser of SplitMix64 (Steele, Lea, Flood 2014).
std::uint64_t hash_of(const LogFrame& frame) {
  std::uint64_t hash = frame.terminated ? 1 : 0;
  for (std::size_t at = 0; at < frame.levels.size(); at += 8) {
    std::uint64_t word = 0;
    for (std::size_t i = 0; i < 8; ++i) word = word << 8 | frame.levels[at + i];
    hash = (hash ^ word) + 0x9E3779B97F4A7C15u;
    hash = (hash ^ hash >> 30) * 0xBF58476D1CE4E5B9u;
    hash = (hash ^ hash >> 27) * 0x94D049BB133111EBu;
    hash ^= hash >> 31;
  }
  return hash;
}

// Reads a log repeatedly, each time leaving out the same frames.
class Walk {
 public:
  Walk(LogReader& reader, bool changes_only) : reader_(reader), changes_only_(changes_only) {}

  Status rewind() {
    counts_.clear();
    return reader_.rewind();
  }
  // The next frame that is compared, with its index among those of its universe. False at the end.
  Result<bool> next(LogFrame& frame, std::uint32_t& index) {
    while (true) {
      FL_ASSIGN(const bool any, reader_.next(frame));
      if (!any) return false;
      const auto [count, first] = counts_.try_emplace(frame.universe, 0);
      if (changes_only_ && !first && frame.changes.empty() && !frame.terminated) continue;
      index = count->second++;
      return true;
    }
  }

 private:
  LogReader& reader_;
  bool changes_only_;
  std::map<Universe, std::uint32_t> counts_;
};

Result<std::map<Universe, Marks>> read_marks(Walk& walk) {
  FL_TRY(walk.rewind());
  std::map<Universe, Marks> marks;
  LogFrame frame;
  std::uint32_t index = 0;
  while (true) {
    FL_ASSIGN(const bool any, walk.next(frame, index));
    if (!any) return marks;
    marks[frame.universe].push_back({frame.time_ns, hash_of(frame), index == 0 || !frame.changes.empty()});
  }
}

// Levels that a universe has only once, with their time.
std::unordered_map<std::uint64_t, DurationNs> find_unique(const Marks& marks) {
  std::unordered_map<std::uint64_t, std::pair<DurationNs, int>> seen;
  for (const Mark& mark : marks) {
    if (seen.size() == kVotersMax) break;
    if (mark.change) ++seen.try_emplace(mark.hash, mark.time_ns, 0).first->second.second;
  }
  std::unordered_map<std::uint64_t, DurationNs> unique;
  for (const auto& [hash, place] : seen) {
    if (place.second == 1) unique.emplace(hash, place.first);
  }
  return unique;
}

void estimate_offset(const std::map<Universe, Marks>& a, const std::map<Universe, Marks>& b, LogDiff& diff) {
  std::vector<DurationNs> votes;
  for (const auto& [universe, marks] : a) {
    const auto other = b.find(universe);
    if (other == b.end()) continue;
    const auto in_a = find_unique(marks);
    for (const auto& [hash, time_b_ns] : find_unique(other->second)) {
      if (const auto found = in_a.find(hash); found != in_a.end()) votes.push_back(time_b_ns - found->second);
    }
    if (diff.offset_from == LogOffsetFrom::kNothing) {
      diff.offset_from = LogOffsetFrom::kFirstFrames;
      diff.offset_ns = other->second.front().time_ns - marks.front().time_ns;
    }
  }
  // The first frame of a log is always a change. Alone it does not determine the offset.
  if (votes.size() < 2) return;
  const auto middle = votes.begin() + static_cast<std::ptrdiff_t>(votes.size() / 2);
  std::nth_element(votes.begin(), middle, votes.end());
  diff.offset_from = LogOffsetFrom::kChanges;
  diff.offset_ns = *middle;
  diff.offset_votes = votes.size();
}

DurationNs median_gap_ns(const Marks& marks) {
  std::vector<DurationNs> gaps;
  for (std::size_t i = 1; i < marks.size(); ++i) gaps.push_back(marks[i].time_ns - marks[i - 1].time_ns);
  if (gaps.empty()) return kReachNs;
  const auto middle = gaps.begin() + static_cast<std::ptrdiff_t>(gaps.size() / 2);
  std::nth_element(gaps.begin(), middle, gaps.end());
  return *middle;
}

// Pairs the frames of one universe.
class Aligner {
 public:
  Aligner(const Marks& a, const Marks& b, DurationNs offset_ns)
      : a_(a),
        b_(b),
        offset_ns_(static_cast<double>(offset_ns)),
        period_ns_(static_cast<double>(std::max(kPeriodMinNs, std::min(median_gap_ns(a), median_gap_ns(b))))) {}

  std::vector<Pair> run() {
    while (i_ < a_.size() && j_ < b_.size()) {
      const double apart_ns = apart(i_, j_);
      if (same(i_, j_) && std::abs(apart_ns) <= period_ns_ / 2) {
        take_pair();
      } else if (apart_ns > static_cast<double>(kReachNs)) {
        ++i_;
      } else if (apart_ns < -static_cast<double>(kReachNs)) {
        ++j_;
      } else {
        align_window();
      }
    }
    return std::move(pairs_);
  }

 private:
  [[nodiscard]] bool same(std::size_t i, std::size_t j) const { return a_[i].hash == b_[j].hash; }
  [[nodiscard]] double apart(std::size_t i, std::size_t j) const {
    return static_cast<double>(b_[j].time_ns - a_[i].time_ns) - offset_ns_;
  }

  void take_pair() {
    const double apart_ns = apart(i_, j_);
    if (std::abs(apart_ns) <= period_ns_ / 2) offset_ns_ += apart_ns / 32;
    pairs_.push_back({static_cast<std::uint32_t>(i_++), static_cast<std::uint32_t>(j_++)});
  }

  // Aligns the next frames and keeps the first half of the result, because the end of a window is uncertain.
  void align_window() {
    const std::size_t m = std::min(kWindow, a_.size() - i_);
    const std::size_t n = std::min(kWindow, b_.size() - j_);
    const auto cost = [&](std::size_t p, std::size_t q) -> double& { return costs_[p * (kWindow + 1) + q]; };
    const auto pair_cost = [&](std::size_t p, std::size_t q) {
      const double time = std::min(kCostPeriod * std::abs(apart(i_ + p, j_ + q)) / period_ns_, kCostTimeMax);
      return time + (same(i_ + p, j_ + q) ? 0.0 : kCostDifferent);
    };
    for (std::size_t p = 0; p <= m; ++p) {
      for (std::size_t q = 0; q <= n; ++q) {
        if (p == 0 || q == 0) {
          cost(p, q) = static_cast<double>(p + q) * kCostLeftOver;
          continue;
        }
        cost(p, q) = std::min({cost(p - 1, q - 1) + pair_cost(p - 1, q - 1), cost(p - 1, q) + kCostLeftOver,
                               cost(p, q - 1) + kCostLeftOver});
      }
    }
    // If the window ends before the logs do, remaining frames of one side cost nothing yet.
    std::size_t p = m;
    std::size_t q = n;
    if (i_ + m < a_.size() || j_ + n < b_.size()) {
      for (std::size_t k = 0; k <= n; ++k) {
        if (cost(m, k) < cost(p, q)) p = m, q = k;
      }
      for (std::size_t k = 0; k <= m; ++k) {
        if (cost(k, n) < cost(p, q)) p = k, q = n;
      }
    }
    enum class Step : std::uint8_t { kPair, kOnlyA, kOnlyB };
    std::array<Step, 2 * kWindow> steps;  // in reverse order
    std::size_t count = 0;
    while (p > 0 || q > 0) {
      if (p > 0 && q > 0 && cost(p, q) == cost(p - 1, q - 1) + pair_cost(p - 1, q - 1)) {
        steps[count++] = Step::kPair;
        --p;
        --q;
      } else if (p > 0 && (q == 0 || cost(p, q) == cost(p - 1, q) + kCostLeftOver)) {
        steps[count++] = Step::kOnlyA;
        --p;
      } else {
        steps[count++] = Step::kOnlyB;
        --q;
      }
    }
    const bool last = i_ + m == a_.size() && j_ + n == b_.size();
    const std::size_t kept = last ? 0 : count / 2;
    for (std::size_t k = count; k-- > kept;) {
      switch (steps[k]) {
        case Step::kPair: take_pair(); break;
        case Step::kOnlyA: ++i_; break;
        case Step::kOnlyB: ++j_; break;
      }
    }
    if (count == 0) ++i_;  // unreachable with m and n above 0; guarantees progress
  }

  const Marks& a_;
  const Marks& b_;
  double offset_ns_;
  double period_ns_;
  std::size_t i_ = 0;
  std::size_t j_ = 0;
  std::vector<Pair> pairs_;
  std::array<double, (kWindow + 1) * (kWindow + 1)> costs_ = {};
};

void measure_times(const Marks& a, const Marks& b, const std::vector<Pair>& pairs, DurationNs offset_ns,
                   LogUniverseDiff& diff) {
  if (pairs.empty()) return;
  std::vector<DurationNs> apart;
  double sum_t = 0.0;
  double sum_d = 0.0;
  const DurationNs base_ns = a[pairs.front().a].time_ns;
  const auto t_of = [&](const Pair& pair) { return static_cast<double>(a[pair.a].time_ns - base_ns); };
  const auto d_of = [&](const Pair& pair) {
    return static_cast<double>(b[pair.b].time_ns - a[pair.a].time_ns - offset_ns);
  };
  for (const Pair& pair : pairs) {
    apart.push_back(std::abs(b[pair.b].time_ns - a[pair.a].time_ns - offset_ns));
    sum_t += t_of(pair);
    sum_d += d_of(pair);
  }
  std::sort(apart.begin(), apart.end());
  diff.times = {apart[apart.size() / 2], apart[(apart.size() - 1) * 99 / 100], apart.back()};
  const double mean_t = sum_t / static_cast<double>(pairs.size());
  const double mean_d = sum_d / static_cast<double>(pairs.size());
  double covariance = 0.0;
  double variance = 0.0;
  for (const Pair& pair : pairs) {
    covariance += (t_of(pair) - mean_t) * (d_of(pair) - mean_d);
    variance += (t_of(pair) - mean_t) * (t_of(pair) - mean_t);
  }
  if (variance > 0.0) diff.drift_ppm = covariance / variance * 1e6;
}

// Pairs of one universe whose levels differ, ascending on both sides.
struct Unlike {
  std::vector<Pair> pairs;
  std::size_t at_a = 0;  // the next pair in A
  std::size_t at_b = 0;
  std::map<std::uint32_t, Slots> levels_b;  // of pairs read in B and not yet in A
  std::bitset<kSlotCountMax> slots;
};

void compare(const LogFrame& a, const Slots& b, int tolerance, Unlike& unlike, LogUniverseDiff& diff) {
  bool any = false;
  for (std::size_t slot = 0; slot < b.size(); ++slot) {
    const int distance = std::abs(int{a.levels[slot]} - int{b[slot]});
    diff.level_distance_max = std::max(diff.level_distance_max, distance);
    if (distance <= tolerance) continue;
    if (!any && diff.first_address == 0) {
      diff.first_ns = a.time_ns;
      diff.first_address = static_cast<Address>(slot) + 1;
      diff.first_level_a = a.levels[slot];
      diff.first_level_b = b[slot];
    }
    any = true;
    unlike.slots.set(slot);
  }
  if (any) ++diff.different;
}

}  // namespace

Result<LogDiff> diff_logs(LogReader& a, LogReader& b, const LogDiffOptions& options) {
  LogDiff diff;
  Walk walk_a(a, options.changes_only);
  Walk walk_b(b, options.changes_only);
  FL_ASSIGN(auto marks_a, read_marks(walk_a));
  FL_ASSIGN(auto marks_b, read_marks(walk_b));
  diff.duration_a_ns = a.info().duration_ns;
  diff.duration_b_ns = b.info().duration_ns;
  if (options.offset_ns) {
    diff.offset_from = LogOffsetFrom::kGiven;
    diff.offset_ns = *options.offset_ns;
  } else {
    estimate_offset(marks_a, marks_b, diff);
  }
  for (const auto& [universe, marks] : marks_b) marks_a.try_emplace(universe);

  std::map<Universe, Unlike> unlikes;
  for (const auto& [universe, in_a] : marks_a) {
    const Marks& in_b = marks_b[universe];
    LogUniverseDiff& one = diff.universes.emplace_back();
    one.universe = universe;
    one.frames_a = in_a.size();
    one.frames_b = in_b.size();
    const std::vector<Pair> pairs = Aligner(in_a, in_b, diff.offset_ns).run();
    one.pairs = pairs.size();
    one.only_a = in_a.size() - pairs.size();
    one.only_b = in_b.size() - pairs.size();
    measure_times(in_a, in_b, pairs, diff.offset_ns, one);
    for (const Pair& pair : pairs) {
      if (in_a[pair.a].hash != in_b[pair.b].hash) unlikes[universe].pairs.push_back(pair);
    }
  }

  if (!unlikes.empty()) {
    FL_TRY(walk_a.rewind());
    FL_TRY(walk_b.rewind());
    LogFrame frame_a;
    LogFrame frame_b;
    std::uint32_t index_a = 0;
    std::uint32_t index_b = 0;
    while (true) {
      FL_ASSIGN(const bool any, walk_a.next(frame_a, index_a));
      if (!any) break;
      const auto found = unlikes.find(frame_a.universe);
      if (found == unlikes.end()) continue;
      Unlike& unlike = found->second;
      if (unlike.at_a == unlike.pairs.size() || unlike.pairs[unlike.at_a].a != index_a) continue;
      const std::uint32_t wanted = unlike.pairs[unlike.at_a++].b;
      while (!unlike.levels_b.contains(wanted)) {
        FL_ASSIGN(const bool any_b, walk_b.next(frame_b, index_b));
        if (!any_b) return fail(ErrorCode::kIo, "{}: has changed while it was read", b.info().path);
        const auto other = unlikes.find(frame_b.universe);
        if (other == unlikes.end()) continue;
        Unlike& of = other->second;
        if (of.at_b == of.pairs.size() || of.pairs[of.at_b].b != index_b) continue;
        ++of.at_b;
        std::copy(frame_b.levels.begin(), frame_b.levels.end(), of.levels_b[index_b].begin());
      }
      const auto one = std::find_if(diff.universes.begin(), diff.universes.end(),
                                    [&](const LogUniverseDiff& each) { return each.universe == frame_a.universe; });
      compare(frame_a, unlike.levels_b[wanted], options.level_tolerance, unlike, *one);
      unlike.levels_b.erase(wanted);
      one->slots_different = static_cast<int>(unlike.slots.count());
    }
  }

  diff.equal = std::all_of(diff.universes.begin(), diff.universes.end(), [&](const LogUniverseDiff& one) {
    return one.only_a == 0 && one.only_b == 0 && one.different == 0 && one.times.max_ns <= options.time_tolerance_ns;
  });
  return diff;
}

}  // namespace footlight
