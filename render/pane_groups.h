// Panes that lie in one plane, near each other: groups, which share the tables of shaftlines.comp
// (docs/decisions/0159).
#pragma once

#include <cstdint>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

inline constexpr std::uint64_t kPaneLineBytes = sizeof(float) * 3 * 2;        // of an entry
inline constexpr std::uint64_t kPaneLineBytesMax = std::uint64_t{120} << 20;  // of all groups; fits any device

struct PaneGroups {
  std::vector<PaneGroupRow> rows;
  std::vector<GroupPaneRow> panes;  // each pane of the rig once
  std::vector<std::uint32_t> grids;
  std::uint64_t entries = 0;  // of the table of sums
};

[[nodiscard]] PaneGroups pane_groups(const fixtures::Rig& rig, bool has_sums = true);
// Bytes of the buffer at a binding of groups.
[[nodiscard]] std::uint64_t pane_group_bytes(std::uint32_t binding, const fixtures::Rig& rig, bool has_sums);

// Makes the tables.
Status make_pane_groups(vk::Device& device, const fixtures::Rig& rig, bool has_sums, RigTables& r);

}  // namespace footlight::render
