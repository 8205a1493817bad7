#include "tools/footlight/preview/ui/beam_aim.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

#include "fixtures/edit/rig_edits.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/encode.h"
#include "fixtures/simulate/walker.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

using fixtures::f64::Walker;

constexpr double kPi = std::numbers::pi;
constexpr double kDegrees = 180 / kPi;
constexpr double kNearestM = 1e-3;  // a point nearer to the lens than this has no direction
constexpr double kSame = 1e-9;
constexpr double kReached = 1e-6;  // an angle between the beam and the way to the point
constexpr double kStillM = 1e-6;   // a lens that moves less has arrived

template <class Vector>
glm::dvec3 vector_of(const Vector& v) {
  return {v.x, v.y, v.z};
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

// A direction that turns with an angle: middle + a cos(angle) + b sin(angle).
struct Turning {
  glm::dvec3 middle;
  glm::dvec3 a;
  glm::dvec3 b;
};
template <class At>
Turning turning_of(const At& at) {
  const glm::dvec3 from = at(0.0);
  const glm::dvec3 across = at(kPi / 2);
  const glm::dvec3 back = at(kPi);
  const glm::dvec3 middle = (from + back) / 2.0;
  return {middle, from - middle, across - middle};
}

// The physical range of an attribute over all channels of a mode; from > to: no channel has it.
struct Range {
  double from = 1e30;
  double to = -1e30;
};
Range range_of(const fixtures::Mode& mode, std::string_view attribute) {
  Range range;
  for (const fixtures::Channel& channel : mode.channels) {
    if (channel.slot_offsets.empty()) continue;
    for (const fixtures::ChannelFunction& function : channel.functions) {
      if (!fixtures::same_attribute(function.attribute, attribute)) continue;
      range.from = std::min({range.from, function.physical_from, function.physical_to});
      range.to = std::max({range.to, function.physical_from, function.physical_to});
    }
  }
  return range;
}

}  // namespace

struct BeamAim::State {
  explicit State(const fixtures::CompiledRig& compiled) : walker(compiled) {}
  Walker walker;
  std::size_t computed = 0;
};

// A head whose joints can be turned.
struct BeamAim::Head {
  Walker& walker;
  const fixtures::HeadRow& row;
  const fixtures::TypeRow& type;
  Walker::HeadState state;
  std::size_t& computed;  // BeamAim::computed()

  [[nodiscard]] StageRay beam() const {
    const Walker::BeamPose pose = walker.beam_pose(row, type, state);
    ++computed;
    return {vector_of(pose.lens_m), vector_of(pose.axis)};
  }
  [[nodiscard]] double& angle(fixtures::uint param) { return param == fixtures::kParamPan ? state.pan : state.tilt; }
  [[nodiscard]] glm::dvec3 way_at(fixtures::uint param, double angle_rad) {
    const double before = std::exchange(angle(param), angle_rad);
    const glm::dvec3 way = beam().way;
    angle(param) = before;
    return way;
  }
  // The first joint of these, from the hanging point on; kParamCount: there is none.
  [[nodiscard]] fixtures::uint joint(fixtures::uint number) const {
    for (fixtures::uint j = 0; j < type.joint_count; ++j) {
      const fixtures::uint param = walker.fl_joint(type.joint_first + j).param;
      if (param != fixtures::kParamPan && param != fixtures::kParamTilt) continue;
      if (number-- == 0) return param;
    }
    return fixtures::kParamCount;
  }
};

BeamAim::BeamAim(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled)
    : rig_(rig), compiled_(compiled), state_(std::make_unique<State>(compiled)) {}

BeamAim::~BeamAim() = default;

std::size_t BeamAim::computed() const { return state_->computed; }

std::optional<std::size_t> BeamAim::head_of(int fixture) const {
  const auto at = static_cast<std::size_t>(fixture);
  const std::size_t first = compiled_.head_first[at];
  const std::size_t end = compiled_.head_first[at + 1];
  for (std::size_t head = first; head < end; ++head) {
    const fixtures::TypeRow& type = compiled_.types[compiled_.heads[head].type];
    for (fixtures::uint j = 0; j < type.joint_count; ++j) {
      const fixtures::uint param = compiled_.joints[type.joint_first + j].param;
      if (param == fixtures::kParamPan || param == fixtures::kParamTilt) return head;
    }
  }
  return first < end ? std::optional(first) : std::nullopt;
}

BeamAim::Head BeamAim::posed(std::size_t head, std::span<const std::uint8_t> levels) {
  Walker& walker = state_->walker;
  const fixtures::HeadRow& row = compiled_.heads[head];
  Head posed{walker, row, compiled_.types[row.type], {}, state_->computed};
  walker.head_pose(posed.state, walker.decoded(levels, head));
  walker.levels = {};  // the caller's
  return posed;
}

std::optional<StageRay> BeamAim::beam_of(int fixture, std::span<const std::uint8_t> levels) {
  const auto head = head_of(fixture);
  if (!head || levels.size() != compiled_.universes.size() * kSlotCountMax) return std::nullopt;
  const StageRay beam = posed(*head, levels).beam();
  if (!std::isfinite(glm::dot(beam.from_m, beam.way))) return std::nullopt;
  return beam;
}

bool BeamAim::moves(int fixture) const {
  const auto head = head_of(fixture);
  if (!head) return false;
  const fixtures::TypeRow& type = compiled_.types[compiled_.heads[*head].type];
  const fixtures::Mode& mode = fixtures::mode_of(rig_, rig_.fixtures[static_cast<std::size_t>(fixture)]);
  for (fixtures::uint j = 0; j < type.joint_count; ++j) {
    const fixtures::uint param = compiled_.joints[type.joint_first + j].param;
    if (param != fixtures::kParamPan && param != fixtures::kParamTilt) continue;
    const Range range = range_of(mode, param == fixtures::kParamPan ? "Pan" : "Tilt");
    if (range.from < range.to) return true;
  }
  return false;
}

namespace {

// The two angles of an inner joint at which its direction has the slope `wanted` along an axis; where it cannot, the
// angle that comes nearest, twice. `now`, twice, if it does not change the slope.
std::array<double, 2> slopes_to(const Turning& turning, const glm::dvec3& axis, double wanted, double now_rad) {
  const double a = glm::dot(turning.a, axis);
  const double b = glm::dot(turning.b, axis);
  const double most = std::hypot(a, b);
  if (most < kSame) return {now_rad, now_rad};
  const double first = std::atan2(b, a);
  const double open = std::acos(std::clamp((wanted - glm::dot(turning.middle, axis)) / most, -1.0, 1.0));
  return {first + open, first - open};
}

// The angle of a joint at which its direction comes nearest to `wanted`; `now` if all angles are as near.
double nearest_angle(const Turning& turning, const glm::dvec3& wanted, double now_rad) {
  const double a = glm::dot(turning.a, wanted);
  const double b = glm::dot(turning.b, wanted);
  return std::hypot(a, b) < kSame ? now_rad : std::atan2(b, a);
}

// The angle about an axis from one direction to another; nothing if one of them is along the axis.
std::optional<double> turn_from(const glm::dvec3& from, const glm::dvec3& to, const glm::dvec3& axis) {
  const glm::dvec3 a = from - axis * glm::dot(from, axis);
  const glm::dvec3 b = to - axis * glm::dot(to, axis);
  if (glm::length(a) < kSame || glm::length(b) < kSame) return std::nullopt;
  return std::atan2(glm::dot(glm::cross(a, b), axis), glm::dot(a, b));
}

// The same direction, the fewest turns from `near`.
double turned_near(double angle_rad, double near_rad) {
  return near_rad + std::remainder(angle_rad - near_rad, 2 * kPi);
}

struct Joint {
  fixtures::uint param = fixtures::kParamCount;  // kParamCount: it is none, or no channel turns it
  double now_rad = 0;
  double from_rad = 0;
  double to_rad = 0;
  [[nodiscard]] bool moves() const { return param != fixtures::kParamCount; }
  [[nodiscard]] double within(double angle_rad) const { return std::clamp(angle_rad, from_rad, to_rad); }
};

// The direction of the axis about which a head's beam turns with a joint, whatever the joint behind it does. 0: that
// joint does not turn it.
template <class Way>
glm::dvec3 outer_axis_of(const Way& way_at) {
  glm::dvec3 best(0);
  for (const double inner : {0.0, 1.0, 2.0}) {
    const Turning turning = turning_of([&](double angle) { return way_at(angle, inner); });
    const glm::dvec3 axis = glm::cross(turning.a, turning.b);
    if (glm::length(axis) > glm::length(best)) best = axis;
  }
  const double length = glm::length(best);
  return length > kSame ? best / length : glm::dvec3(0);
}

}  // namespace

std::optional<BeamAim::Angles> BeamAim::angles_to(int fixture, const glm::dvec3& point_m,
                                                  std::span<const std::uint8_t> levels) {
  if (!moves(fixture) || levels.size() != compiled_.universes.size() * kSlotCountMax) return std::nullopt;
  const fixtures::Mode& mode = fixtures::mode_of(rig_, rig_.fixtures[static_cast<std::size_t>(fixture)]);
  Head head = posed(*head_of(fixture), levels);
  const auto joint_of = [&](fixtures::uint number) {
    const fixtures::uint param = head.joint(number);
    if (param == fixtures::kParamCount) return Joint{};
    const Range range = range_of(mode, param == fixtures::kParamPan ? "Pan" : "Tilt");
    if (!(range.from < range.to)) return Joint{};
    return Joint{param, head.angle(param), range.from / kDegrees, range.to / kDegrees};
  };
  Joint outer = joint_of(0);
  Joint inner = joint_of(1);
  if (!outer.moves()) std::swap(outer, inner);
  // Neither of these depends on where the lens is.
  const auto way_at = [&](double outer_rad, double inner_rad) {
    if (inner.moves()) head.angle(inner.param) = inner_rad;
    return head.way_at(outer.param, outer_rad);
  };
  const glm::dvec3 axis = inner.moves() ? outer_axis_of(way_at) : glm::dvec3(0);
  const bool outer_alone = !inner.moves();
  const bool inner_alone = inner.moves() && axis == glm::dvec3(0);
  const Turning turning = turning_of(
      [&](double angle) { return outer_alone ? way_at(angle, 0) : way_at(inner_alone ? outer.now_rad : 0, angle); });
  head.angle(outer.param) = outer.now_rad;
  if (inner.moves()) head.angle(inner.param) = inner.now_rad;

  Angles best;
  double best_turn = 0;
  std::vector<std::array<double, 2>> tried;  // in a pass, within the ranges
  glm::dvec3 lens_m(0);
  for (int pass = 0; pass < 8; ++pass) {
    const glm::dvec3 from_m = head.beam().from_m;
    if (pass > 0 && glm::length(from_m - lens_m) < kStillM) break;
    lens_m = from_m;
    const glm::dvec3 between = point_m - lens_m;
    if (!(glm::length(between) > kNearestM)) return std::nullopt;
    const glm::dvec3 wanted = glm::normalize(between);
    best.off_rad = 1e30;
    tried.clear();
    const auto take = [&](double outer_rad, double inner_rad) {
      for (int turns = -2; turns <= 2; ++turns) {
        for (int inner_turns = -1; inner_turns <= 1; ++inner_turns) {
          const double a = outer.within(turned_near(outer_rad, outer.now_rad) + turns * 2 * kPi);
          const double b = inner.within(turned_near(inner_rad, inner.now_rad) + inner_turns * 2 * kPi);
          const std::array<double, 2> both{a, b};
          if (std::find(tried.begin(), tried.end(), both) != tried.end()) continue;
          tried.push_back(both);
          head.angle(outer.param) = a;
          if (inner.moves()) head.angle(inner.param) = b;
          const double off = angle_between(head.beam().way, wanted);
          const double turn = std::abs(a - outer.now_rad) + (inner.moves() ? std::abs(b - inner.now_rad) : 0);
          const bool better = off < best.off_rad - 1e-7 || (off < best.off_rad + 1e-7 && turn < best_turn);
          if (!better) continue;
          best_turn = turn;
          best = {head.state.pan, head.state.tilt, off};
        }
      }
    };
    if (outer_alone) {
      take(nearest_angle(turning, wanted, outer.now_rad), 0);
    } else if (inner_alone) {
      take(outer.now_rad, nearest_angle(turning, wanted, inner.now_rad));
    } else {
      for (const double inner_rad : slopes_to(turning, axis, glm::dot(wanted, axis), inner.now_rad)) {
        const auto turn = turn_from(way_at(0, inner_rad), wanted, axis);
        take(turn.value_or(outer.now_rad), inner_rad);
      }
      // Out of reach: at an end of the outer range another inner angle may come nearer.
      for (const double end_rad : {outer.from_rad, outer.to_rad}) {
        if (best.off_rad < kReached) break;
        const Turning at_end = turning_of([&](double angle) { return way_at(end_rad, angle); });
        take(end_rad, nearest_angle(at_end, wanted, inner.now_rad));
      }
    }
    if (!(best.off_rad < 1e30)) return std::nullopt;
    head.state.pan = *best.pan_deg;  // rad until the end
    head.state.tilt = *best.tilt_deg;
  }
  // Where the lens is with these angles.
  best.off_rad = angle_between(head.beam().way, point_m - head.beam().from_m);
  const auto degrees = [&](fixtures::uint param, double angle_rad) {
    const bool has = outer.param == param || inner.param == param;
    return has ? std::optional(angle_rad * kDegrees) : std::nullopt;
  };
  return Angles{degrees(fixtures::kParamPan, head.state.pan), degrees(fixtures::kParamTilt, head.state.tilt),
                best.off_rad};
}

AimCommand aim_command(BeamAim& aim, const fixtures::Rig& rig, const RigIndex& index, std::span<const int> which,
                       const glm::dvec3& point_m, std::span<const std::uint8_t> levels) {
  AimCommand aimed;
  for (const int fixture : which) {
    const auto angles = aim.angles_to(fixture, point_m, levels);
    const std::size_t before = aimed.command.edits.size();
    const fixtures::PatchedFixture& one = rig.fixtures[static_cast<std::size_t>(fixture)];
    const fixtures::FixtureType& type = fixtures::type_of(rig, one);
    const auto& channels = fixtures::mode_of(rig, one).channels;
    for (std::size_t c = 0; angles && c < channels.size(); ++c) {
      const ChannelKey key{fixture, static_cast<int>(c)};
      if (!index.place(key)) continue;
      for (const auto& [attribute, degrees] :
           {std::pair("Pan", angles->pan_deg), std::pair("Tilt", angles->tilt_deg)}) {
        if (!degrees) continue;
        const auto nearest = fixtures::nearest_raw(type, channels[c], attribute, *degrees);
        if (!nearest) continue;
        aimed.command.edits.push_back({key, nearest->raw, std::nullopt});
        break;  // each channel once
      }
    }
    const bool any = aimed.command.edits.size() > before;
    (any ? aimed.aimed : aimed.left) += 1;
    if (any) aimed.off_rad = std::max(aimed.off_rad, angles->off_rad);
  }
  // Steps of one drag are one edit, although a fixture may come out of reach on the way.
  if (!aimed.command.edits.empty()) aimed.command.moved = ChannelKey{which.front(), -1};
  return aimed;
}

Result<fixtures::RigEdit> turn_to_point(BeamAim& aim, const fixtures::Rig& edited, std::span<const int> which,
                                        const glm::dvec3& point_m, std::span<const std::uint8_t> levels) {
  fixtures::RigEdit all;
  for (const int fixture : which) {
    const auto beam = aim.beam_of(fixture, levels);
    if (!beam || aim.moves(fixture)) continue;
    // The lens turns with the fixture, about its hanging point: the turn is computed again from where it comes to.
    const glm::dvec3 pivot_m = fixtures::position_of(edited.fixtures[static_cast<std::size_t>(fixture)]);
    glm::dmat3 turn(1);
    for (int pass = 0; pass < 8; ++pass) {
      const glm::dvec3 lens_m = pivot_m + turn * (beam->from_m - pivot_m);
      const glm::dvec3 way = turn * beam->way;
      if (!(glm::length(point_m - lens_m) > kNearestM)) break;
      const glm::dvec3 wanted = glm::normalize(point_m - lens_m);
      glm::dvec3 axis = glm::cross(way, wanted);
      if (glm::length(axis) < kSame) {
        if (glm::dot(way, wanted) > 0) break;
        axis = glm::cross(way, std::abs(way.x) < 0.7 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0));
      }
      axis = glm::normalize(axis);
      const double angle = angle_between(way, wanted);
      glm::dmat3 step(1);
      for (int i = 0; i < 3; ++i) {
        const glm::dvec3 v = step[i];
        step[i] = v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) +
                  axis * glm::dot(axis, v) * (1 - std::cos(angle));
      }
      turn = step * turn;
    }
    fixtures::PatchedFixture turned;
    turned.pose = glm::dmat4(turn);
    const std::array<int, 1> only{fixture};
    FL_ASSIGN(fixtures::RigEdit one, fixtures::rotate_fixtures(edited, only, fixtures::rotation_deg_of(turned)));
    all.changes.insert(all.changes.end(), one.changes.begin(), one.changes.end());
  }
  if (all.changes.empty()) {
    return fail(ErrorCode::kBadInput, "no selected fixture can be turned to a point; select fixtures with a beam");
  }
  const std::string& first = edited.fixtures[static_cast<std::size_t>(all.changes.front().fixture)].name;
  all.text = all.changes.size() == 1
                 ? trf("aim {}", first)
                 : trf_n("aim {} fixture", "aim {} fixtures", all.changes.size(), all.changes.size());
  return all;
}

}  // namespace footlight::tools
