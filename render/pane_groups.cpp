#include "render/pane_groups.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "render/pane_tables.h"

namespace footlight::render {
namespace {

constexpr double kSameNormal = 1e-4;   // sine between two normals
constexpr double kSamePlaneM = 2e-3;   // between two planes: what is typed in millimetres is off by that
constexpr double kEmptyShareMost = 4;  // of a group's rectangle, over the area of its panes
constexpr double kLinesMax = 8192;
constexpr double kStationsATexel = 0.5;
constexpr int kTexelsLeast = 256;         // that a side of a pane counts for
constexpr std::uint32_t kEvenMost = 4;    // so many panes without images need no table
constexpr double kGridMax = 64;  // cells a side

struct Box {
  glm::dvec2 low{std::numeric_limits<double>::infinity()};
  glm::dvec2 high{-std::numeric_limits<double>::infinity()};

  void add(glm::dvec2 place) {
    low = glm::min(low, place);
    high = glm::max(high, place);
  }
  [[nodiscard]] double area() const { return (high.x - low.x) * (high.y - low.y); }
};

// A pane: from its middle to those of its right and its upper edge.
struct Glass {
  glm::dvec3 center, right, up;
};
Glass glass_of(const fixtures::Pane& pane) {
  const glm::dmat4 pose = fixtures::pose_of(pane);
  return {pane.position_m, glm::dvec3(pose[0]) * (pane.width_m / 2), glm::dvec3(pose[2]) * (pane.height_m / 2)};
}

// Panes in a plane: places in it are x and y from the middle of the first one, m.
struct Group {
  Glass first;
  glm::dvec3 x_axis, y_axis;
  Box box;
  double area = 0;
  std::vector<std::size_t> panes;

  [[nodiscard]] glm::dvec2 place_of(const glm::dvec3& from_first) const {
    return {glm::dot(x_axis, from_first), glm::dot(y_axis, from_first)};
  }
  [[nodiscard]] Box with(const Glass& glass, Box all) const {
    for (const double u : {-1.0, 1.0}) {
      for (const double v : {-1.0, 1.0}) {
        all.add(place_of(glass.center + u * glass.right + v * glass.up - first.center));
      }
    }
    return all;
  }
  // Adds the pane if it lies in the plane and leaves little of the rectangle empty.
  bool add(std::size_t pane, const Glass& glass) {
    const glm::dvec3 normal = glm::cross(x_axis, y_axis);
    const glm::dvec3 other = glm::normalize(glm::cross(glass.right, glass.up));
    const bool same = glm::length(glm::cross(normal, other)) < kSameNormal &&
                      std::abs(glm::dot(normal, glass.center - first.center)) < kSamePlaneM;
    const double own = 4 * glm::length(glass.right) * glm::length(glass.up);
    const Box all = with(glass, box);
    if (!same || all.area() > kEmptyShareMost * (area + own)) return false;
    box = all;
    area += own;
    panes.push_back(pane);
    return true;
  }
};

std::vector<Group> groups_of_rig(const fixtures::Rig& rig) {
  std::vector<Group> groups;
  for (std::size_t i = 0; i < rig.panes.size(); ++i) {
    const Glass glass = glass_of(rig.panes[i]);
    const bool known = std::any_of(groups.begin(), groups.end(), [&](Group& group) { return group.add(i, glass); });
    if (known) continue;
    Group group{glass, glm::normalize(glass.right), glm::normalize(glass.up), {}, 0, {}};
    group.add(i, glass);
    groups.push_back(group);
  }
  return groups;
}

std::uint32_t whole_of(double v, double least, double most) {
  return static_cast<std::uint32_t>(std::lround(std::clamp(v, least, most)));
}

// The row's rectangle and sizes of texels, and the rows of its panes.
void add_panes(const fixtures::Rig& rig, const std::vector<PaneRow>& rows, const Group& group, PaneGroups& all,
               PaneGroupRow& row) {
  const glm::dvec2 half = (group.box.high - group.box.low) * 0.5, middle = (group.box.high + group.box.low) * 0.5;
  const glm::dvec3 right = group.x_axis * half.x, up = group.y_axis * half.y;
  const glm::dvec3 center = group.first.center + group.x_axis * middle.x + group.y_axis * middle.y;
  const glm::dvec3 normal = glm::cross(group.x_axis, group.y_axis);
  const glm::dvec3 sun = rig.sun.direction;
  const bool shines = std::abs(glm::dot(normal, sun)) >= kPaneCosineLeast;
  const glm::dvec3 along = shines ? sun : normal;
  const double volume = glm::dot(glm::cross(right, up), along);
  row.center = vec4(center, glm::length(half));
  row.across = vec4(glm::cross(up, along) / volume, half.x);
  row.upward = vec4(glm::cross(along, right) / volume, half.y);
  const bool lit = std::any_of(group.panes.begin(), group.panes.end(),
                               [&](std::size_t i) { return rows[i].light.x + rows[i].light.y + rows[i].light.z > 0; });
  row.along = vec4(glm::cross(right, up) / volume, shines && lit ? 1 : 0);
  row.sun = vec4(sun, 0);
  row.pane_first = static_cast<std::uint32_t>(all.panes.size());
  row.pane_count = static_cast<std::uint32_t>(group.panes.size());
  glm::dvec2 texel(2);
  bool even = row.pane_count <= kEvenMost;
  for (const std::size_t i : group.panes) {
    const Glass glass = glass_of(rig.panes[i]);
    const fixtures::PaneImage& image = image_of(rig.panes[i]);
    // From places of the group to those on the pane.
    const glm::dvec3 u = glass.right / glm::dot(glass.right, glass.right), v = glass.up / glm::dot(glass.up, glass.up);
    // Light that passes a place of the group passes the pane farther along the sun, by some millimetres at most.
    const double farther_m = glm::dot(normal, glass.center - center) / glm::dot(normal, along);
    const glm::dvec3 from = center + along * farther_m - glass.center;
    GroupPaneRow pane{};
    pane.to_u = vec4(glm::dot(u, right), glm::dot(u, up), glm::dot(u, from), 0);
    pane.to_v = vec4(glm::dot(v, right), glm::dot(v, up), glm::dot(v, from), 0);
    pane.light = rows[i].light;
    pane.glass = rows[i].glass;
    pane.texel_first = rows[i].texel_first;
    pane.width = rows[i].width;
    pane.height = rows[i].height;
    pane.levels = rows[i].levels;
    all.panes.push_back(pane);
    even = even && image.width * image.height == 1;
    const glm::dvec2 step_x = group.place_of(glass.right) * (2.0 / std::max(image.width, kTexelsLeast)) / half;
    const glm::dvec2 step_y = group.place_of(glass.up) * (2.0 / std::max(image.height, kTexelsLeast)) / half;
    texel = glm::min(texel, glm::max(glm::abs(step_x), glm::abs(step_y)));
  }
  row.is_even = even ? 1 : 0;
  row.texel_u = static_cast<float>(texel.x);
  row.texel_v = static_cast<float>(texel.y);
}

// Which panes each cell of the rectangle may show.
void add_grid(PaneGroups& all, PaneGroupRow& row) {
  struct Range {
    glm::dvec2 low, high;
  };
  std::vector<Range> ranges;
  glm::dvec2 least(2);
  for (std::uint32_t i = 0; i < row.pane_count; ++i) {
    const GroupPaneRow& pane = all.panes[row.pane_first + i];
    // The pane's corners in places of the group.
    const glm::dmat2 to(pane.to_u.x, pane.to_v.x, pane.to_u.y, pane.to_v.y);
    const glm::dmat2 back = glm::inverse(to);
    const glm::dvec2 middle = back * -glm::dvec2(pane.to_u.z, pane.to_v.z);
    const glm::dvec2 reach = glm::abs(back[0]) + glm::abs(back[1]);
    ranges.push_back({middle - reach, middle + reach});
    least = glm::min(least, reach);
  }
  const double cells = row.pane_count == 1 ? 1 : kGridMax;
  row.grid_x = whole_of(4 / least.x, 1, cells);
  row.grid_y = whole_of(4 / least.y, 1, cells);
  row.grid_first = static_cast<std::uint32_t>(all.grids.size());
  all.grids.resize(all.grids.size() + std::size_t{row.grid_x} * row.grid_y);
  const double slack = 1e-5;
  for (std::uint32_t cell = 0; cell < row.grid_x * row.grid_y; ++cell) {
    const glm::dvec2 size(2.0 / row.grid_x, 2.0 / row.grid_y);
    const glm::dvec2 low = glm::dvec2(cell % row.grid_x, cell / row.grid_x) * size - 1.0;
    const auto first = static_cast<std::uint32_t>(all.grids.size());
    std::uint32_t count = 0;
    for (std::uint32_t i = 0; i < row.pane_count; ++i) {
      const bool apart = glm::any(glm::greaterThan(ranges[i].low, low + size + slack)) ||
                         glm::any(glm::lessThan(ranges[i].high, low - slack));
      if (apart) continue;
      all.grids.push_back(row.pane_first + i);
      ++count;
    }
    all.grids[row.grid_first + cell] = first << FL_PANE_GRID_COUNT_BITS | count;
  }
}

// Lines and stations of each group that needs sums: by its texels, and fewer where all together have no room.
void share_lines(PaneGroups& all) {
  const auto give = [&](double share) {
    all.entries = 0;
    for (PaneGroupRow& row : all.rows) {
      row.line_first = static_cast<std::uint32_t>(all.entries);
      row.lines = 0;
      row.stations = 2;
      if (row.is_even != 0 || !(row.along.w > 0)) continue;
      const double u = 2.0 / static_cast<double>(row.texel_u), v = 2.0 / static_cast<double>(row.texel_v);
      row.lines = whole_of(share * std::min(2 * (u + v), kLinesMax), 32, kLinesMax);
      row.stations = whole_of(share * std::min(std::max(u, v) * kStationsATexel, double{FL_PANE_STATIONS_MAX}), 16,
                              FL_PANE_STATIONS_MAX);
      all.entries += std::uint64_t{row.lines} * row.stations;
    }
  };
  give(1);
  const double all_bytes = static_cast<double>(all.entries * kPaneLineBytes);
  if (all_bytes > static_cast<double>(kPaneLineBytesMax)) {
    give(0.98 * std::sqrt(static_cast<double>(kPaneLineBytesMax) / all_bytes));
  }
}

std::uint64_t line_bytes(const PaneGroups& groups) {
  return std::max<std::uint64_t>(groups.entries, 1) * kPaneLineBytes;
}

}  // namespace

PaneGroups pane_groups(const fixtures::Rig& rig, bool has_sums) {
  PaneGroups all;
  const std::vector<PaneRow> rows = pane_rows(rig);
  for (const Group& group : groups_of_rig(rig)) {
    PaneGroupRow row{};
    add_panes(rig, rows, group, all, row);
    add_grid(all, row);
    all.rows.push_back(row);
  }
  if (has_sums) share_lines(all);
  return all;
}

std::uint64_t pane_group_bytes(std::uint32_t binding, const fixtures::Rig& rig, bool has_sums) {
  const PaneGroups groups = pane_groups(rig, has_sums);
  switch (binding) {
    case FL_BINDING_PANE_GROUPS: return groups.rows.size() * sizeof(PaneGroupRow);
    case FL_BINDING_GROUP_PANES: return groups.panes.size() * sizeof(GroupPaneRow);
    case FL_BINDING_PANE_GRIDS: return groups.grids.size() * sizeof(std::uint32_t);
    case FL_BINDING_PANE_FANS: return groups.rows.size() * sizeof(PaneFansRow);
    default: return line_bytes(groups);
  }
}

Status make_pane_groups(vk::Device& device, const fixtures::Rig& rig, bool has_sums, RigTables& r) {
  const PaneGroups groups = pane_groups(rig, has_sums);
  r.pane_group_count = static_cast<std::uint32_t>(groups.rows.size());
  r.pane_lines_most = 0;
  for (const PaneGroupRow& row : groups.rows) r.pane_lines_most = std::max(r.pane_lines_most, row.lines);
  FL_ASSIGN(r.pane_groups, vk::Buffer::table(device, groups.rows));
  FL_ASSIGN(r.group_panes, vk::Buffer::table(device, groups.panes));
  FL_ASSIGN(r.pane_grids, vk::Buffer::table(device, groups.grids));
  // No table yet.
  FL_ASSIGN(r.pane_fans, vk::Buffer::table(device, std::vector<PaneFansRow>(groups.rows.size())));
  FL_ASSIGN(r.pane_lines,
            vk::Buffer::device_local(device, line_bytes(groups), VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  return {};
}

}  // namespace footlight::render
