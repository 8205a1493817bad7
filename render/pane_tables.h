// The tables of panes that the sun shines through: their rows, and their images with all levels of detail.
#pragma once

#include <cstdint>
#include <vector>

#include "render/resources.h"

namespace footlight::render {

// The sun lies in the plane of a pane where the cosine between them is below this: then no light gets through. Within
// this angle, a hundredth of that of the sun's disc, a shaft is thinner than a pixel.
inline constexpr double kPaneCosineLeast = 1e-4;

// The image of a pane; of one without, a single clear texel.
[[nodiscard]] const fixtures::PaneImage& image_of(const fixtures::Pane& pane);
[[nodiscard]] std::vector<PaneRow> pane_rows(const fixtures::Rig& rig);
[[nodiscard]] std::uint64_t pane_texel_bytes(const fixtures::Rig& rig);
[[nodiscard]] std::uint64_t pane_mask_bytes(const fixtures::Rig& rig, std::uint64_t occluders);

// Makes the tables. After make_shadow_tables().
Status make_pane_tables(vk::Device& device, const fixtures::Rig& rig, bool has_sums, RigTables& r);

}  // namespace footlight::render
