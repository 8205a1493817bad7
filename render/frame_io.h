// render/shaders/shared/frame_io.h for C++.
#pragma once

#include <cstddef>
#include <cstdint>

#include <glm/glm.hpp>

#include "fixtures/compile/tables.h"

namespace footlight::render {
using uint = std::uint32_t;
using vec4 = glm::vec4;
#include "render/shaders/shared/frame_io.h"

static_assert(sizeof(FrameParams) == 160);
static_assert(offsetof(FrameParams, width) == 64);
static_assert(sizeof(BeamRow) == 160);
static_assert(sizeof(LaserRow) == 160);
static_assert(sizeof(LaserStripRow) == 192);
static_assert(sizeof(LaserListRow) == 16);
static_assert(sizeof(GlossRow) == 48);
static_assert(sizeof(PaneRow) == 144);
static_assert(sizeof(PaneGroupRow) == 144 && sizeof(GroupPaneRow) == 80 && sizeof(PaneFanRow) == 32);
static_assert(sizeof(PaneFansRow) == 144);
static_assert(sizeof(DisplayRow) == 144);
static_assert(sizeof(DisplayTileRow) == 352);
static_assert(sizeof(DisplayListsHead) == 80 && sizeof(DisplayRecordRow) == 448);
static_assert(sizeof(DisplayLevelRow) == 16 && sizeof(DisplayJobRow) == 16);
static_assert(sizeof(BladesRow) == 64);
static_assert(sizeof(CountsRow) == 112);
static_assert(sizeof(TileDepthRow) == 32);
static_assert(sizeof(CoarseRow) == 208);
static_assert(sizeof(BoxRow) == 48);
static_assert(sizeof(BodyMeshRow) == 80);
static_assert(sizeof(BodyLevelRow) == 28);
static_assert(sizeof(BodySpaceRow) == 208 && sizeof(BodyRoundsHead) == 16 && sizeof(BodyRoundRow) == 8);
static_assert(sizeof(EdgePartRow) == 68);
static_assert(sizeof(DrawBlocksHead) == 16 && sizeof(DrawBlockRow) == 16);
static_assert(sizeof(TreeRow) == 32);
static_assert(sizeof(BodyVertexRow) == 28);
static_assert(sizeof(BodySlotRow) == 16);
static_assert(sizeof(GoboTableRow) == 52);
static_assert(sizeof(GoboQueue) == 96);
static_assert(sizeof(OccluderRow) == 64);
static_assert(sizeof(BodyBoxRow) == 32);
static_assert(sizeof(ShadowListRow) == 8);
static_assert(sizeof(ShadowWordRow) == 8);
static_assert(sizeof(ShadowRow) == 208);
static_assert(sizeof(TextureRow) == 32);
static_assert(sizeof(SheenRow) == 32);
static_assert(sizeof(GateRow) == 32);
static_assert(sizeof(GatesHead) == 16);
static_assert(sizeof(RecheckRow) == 48);
static_assert(sizeof(LensesHead) == 16 && sizeof(LensRow) == 48);
static_assert(sizeof(MeterRow) == 16 + 4 * FL_METER_BINS);
static_assert(FL_METER_BINS % FL_GROUP_EXPOSE == 0);
static_assert(sizeof(BounceSolidRow) == 96);
static_assert(sizeof(BouncePatchRow) == 80);
static_assert(sizeof(BounceGrid) == 32);
static_assert(sizeof(BounceProbeRow) == 32);
static_assert(sizeof(ProbeRow) == 48 && FL_PROBE_TEXELS == 1 << 2 * FL_PROBE_SIDE_LOG2);
}  // namespace footlight::render
