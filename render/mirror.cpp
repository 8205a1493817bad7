#include "render/mirror.h"

#include <algorithm>
#include <cmath>

#include "fixtures/model/gloss.h"
#include "render/passes/beams.h"
#include "render/passes/bodies.h"
#include "render/passes/boxes.h"
#include "render/passes/compute_pass.h"
#include "render/passes/depths.h"
#include "render/passes/displays.h"
#include "render/passes/haze.h"
#include "render/passes/lenses.h"
#include "render/passes/reflections.h"
#include "render/passes/shadowtiles.h"
#include "render/passes/surfaces.h"
#include "render/passes/tiles.h"
#include "shaders/eyes.comp.h"
#include "shaders/mirrordown.comp.h"

namespace footlight::render {
namespace {

// The passes of the mirrored camera's view, in the order of the frame.
const PassEntry* const kMirrored[] = {&kBodiesPass,   &kBoxesPass,       &kTilesPass, &kSurfacesPass, &kReflectionsPass,
                                      &kDepthsPass,   &kShadowtilesPass, &kHazePass,  &kBeamsPass,
                                      &kDisplaysPass, &kLensesPass};

// The push constants of mirrordown.comp.
struct DownPush {
  std::int32_t stage;
  std::int32_t width;
  std::int32_t height;
  std::uint32_t count;
};
constexpr std::int32_t kTake = -1;

constexpr double kAboveM = 1e-3;  // a camera that is not so far above the plane sees no floor

// Without what is not mirrored: light of displays in the air.
std::vector<vk::SpecConstant> mirror_constants(const PassEntry& pass, const fixtures::Needs& needs,
                                               const FrameSettings& settings) {
  std::vector<vk::SpecConstant> constants = pass.constants(needs, settings);
  if (&pass != &kDisplaysPass) return constants;
  for (vk::SpecConstant& constant : constants) {
    if (constant.id == FL_SPEC_AIR || constant.id == FL_SPEC_HAZE) constant.value = 0;
  }
  return constants;
}

}  // namespace

std::uint64_t MirrorShape::bytes() const {
  return std::uint64_t{16} * static_cast<std::uint64_t>(width) * static_cast<std::uint64_t>(height);
}

FrameSettings mirror_settings(const FrameSettings& settings) {
  FrameSettings mirror = settings;
  const int side = static_cast<int>(std::max(settings.gloss_px, 1u)) * settings.supersample;
  mirror.width = (settings.width + side - 1) / side;
  mirror.height = (settings.height + side - 1) / side;
  mirror.supersample = 1;
  mirror.tile_beams = ~0u;  // pixel by pixel
  mirror.triangles = TriangleMethod::kRasteriser;
  mirror.edge_samples = 0;
  mirror.glare = 0;
  mirror.f_stop = 0;
  return mirror;
}

MirrorShape mirror_shape(const FrameSettings& settings) {
  const FrameSettings mirror = mirror_settings(settings);
  MirrorShape shape;
  glm::ivec2 size(mirror.width, mirror.height);
  shape.levels.push_back(size);
  shape.width = size.x;
  shape.height = size.y;
  int below = 0;
  while (shape.levels.size() < FL_MIRROR_LEVELS && (size.x > 1 || size.y > 1)) {
    size = (size + 1) / 2;
    if (shape.levels.size() == 1) shape.width += size.x;
    below += size.y;
    shape.height = std::max(shape.height, below);
    shape.levels.push_back(size);
  }
  shape.height *= 2;  // two texels a pixel
  return shape;
}

Result<vk::Image> make_mirror_image(vk::Device& device, const MirrorShape& shape) {
  FL_ASSIGN(vk::Image image,
            vk::Image::create(device, static_cast<std::uint32_t>(shape.width), static_cast<std::uint32_t>(shape.height),
                              VK_FORMAT_R32G32B32A32_SFLOAT, VK_IMAGE_USAGE_STORAGE_BIT));
  FL_TRY(device.run_once([&](VkCommandBuffer commands) {
    vk::change_layout(commands, image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
  }));
  return image;
}

std::uint64_t mirror_bytes(const MemoryShape& shape) {
  if (!has_gloss(shape.needs, shape.settings)) return 0;
  MemoryShape picture{shape.rig, shape.compiled, shape.needs, mirror_settings(shape.settings)};
  picture.settings.gloss_px = 0;
  picture.needs.laser = false;
  std::uint64_t bytes = mirror_shape(shape.settings).bytes();
  for (const int binding :
       {FL_BINDING_MASKS, FL_BINDING_LASER_MASKS, FL_BINDING_LASER_STRIPS, FL_BINDING_LASER_LISTS,
        FL_BINDING_DISPLAY_TILES, FL_BINDING_DISPLAY_RECORDS,
        FL_BINDING_TILE_DEPTHS, FL_BINDING_COARSE, FL_BINDING_RIMS, FL_BINDING_CUTS, FL_BINDING_SHADOW_WORDS,
        FL_BINDING_SHADOW_PICKS, FL_BINDING_FINE_MASKS, FL_BINDING_SHADE_WORDS, FL_BINDING_PIXEL_DEPTHS,
        FL_BINDING_PIXEL_BOXES, FL_BINDING_PIXEL_KEYS, FL_BINDING_DRAW_BLOCKS, FL_BINDING_EDGES,
        FL_BINDING_EDGE_MASKS, FL_BINDING_EDGE_PARTS, FL_BINDING_EDGE_IDS, FL_BINDING_EDGE_SAMPLES,
        FL_BINDING_SURFACE_ID, FL_BINDING_DEPTH, FL_BINDING_RADIANCE, FL_BINDING_SCREEN}) {
    bytes += binding_bytes(static_cast<std::uint32_t>(binding), picture);
  }
  return bytes;
}

std::vector<GlossRow> gloss_rows(const fixtures::Rig& rig) {
  std::vector<GlossRow> rows;
  for (const fixtures::GlossTop& top : fixtures::gloss_tops(rig)) {
    rows.push_back(
        {vec4(top.center_m, top.gloss.share), vec4(top.half_x_m, 0, top.gloss.roughness), vec4(top.half_y_m, 0, 0)});
  }
  return rows;
}

View mirrored(const View& view, double plane_m) {
  View other = view;
  other.position_m.z = 2 * plane_m - view.position_m.z;
  for (glm::dvec3* axis : {&other.right, &other.up, &other.forward}) axis->z = -axis->z;
  return other;
}

struct Mirror::Steps {
  BoundPipeline eyes, down;
};

Result<std::unique_ptr<Mirror>> Mirror::create(vk::Device& device, Resources& own, const fixtures::Needs& needs,
                                               const FrameSettings& settings, const PassList& passes) {
  std::unique_ptr<Mirror> mirror(new Mirror(own.rig));
  FL_TRY(mirror->make(device, own, needs, settings, passes));
  return mirror;
}

Status Mirror::make(vk::Device& device, Resources& own, const fixtures::Needs& needs, const FrameSettings& settings,
                    const PassList& passes) {
  shape_ = mirror_shape(settings);
  settings_ = mirror_settings(settings);
  FrameSettings plain = settings_;
  plain.gloss_px = 0;  // no pyramid of its own
  fixtures::Needs seen = needs;
  seen.laser = false;  // they are not mirrored
  FL_ASSIGN(resources_.picture, PictureImages::create(device, seen, plain, own.rig.mask_words, 0));
  resources_.bind_all();
  resources_.bindings.set_image(FL_BINDING_MIRROR, own.picture.mirror);
  resources_.bindings.set_image(FL_BINDING_OWN_RADIANCE, own.picture.radiance);
  for (const PassEntry* entry : kMirrored) {
    if (std::find(passes.begin(), passes.end(), entry) == passes.end() || !entry->needed(seen, settings_)) continue;
    FL_ASSIGN(auto pass, entry->create({device, resources_, settings_, mirror_constants(*entry, seen, settings_)}));
    passes_.push_back(std::move(pass));
  }
  const PassContext context{device, resources_, settings_, {}};
  auto steps = std::make_shared<Steps>();
  if (needs.fixtures) {
    FL_ASSIGN(steps->eyes, BoundPipeline::compute(context, kEyesComp, {{FL_SPEC_RECTANGLE, needs.rectangle}}));
  }
  FL_ASSIGN(steps->down,
            BoundPipeline::compute(
                context, kMirrordownComp,
                {{FL_SPEC_BOXES, needs.surfaces}, {FL_SPEC_BODIES, has_bodies(needs, settings_)}, {FL_SPEC_GLOSS, 1}}));
  steps_ = std::move(steps);
  return {};
}

std::uint64_t Mirror::bytes() const {
  std::uint64_t bytes = resources_.picture_bytes;
  for (const auto& pass : passes_) bytes += pass->own_bytes();
  return bytes;
}

void Mirror::record(VkCommandBuffer commands) {
  for (const auto& pass : passes_) {
    pass->record(commands, {});
    vk::full_barrier(commands);
  }
  steps_->down.bind(commands);
  record_down(commands, kTake);
}

void Mirror::record_levels(VkCommandBuffer commands) {
  steps_->down.bind(commands);
  for (std::size_t i = 0; i < shape_.levels.size(); ++i) record_down(commands, static_cast<std::int32_t>(i));
}

// stage: as in mirrordown.comp.
void Mirror::record_down(VkCommandBuffer commands, std::int32_t stage) {
  const DownPush push{stage, shape_.levels[0].x, shape_.levels[0].y, resources_.rig.gloss_count};
  const glm::ivec2 size = shape_.levels[static_cast<std::size_t>(std::max(stage, 0))];
  steps_->down.pipeline->push(commands, std::as_bytes(std::span(&push, 1)));
  vkCmdDispatch(commands, tile_groups(size.x), tile_groups(size.y), 1);
  vk::full_barrier(commands);
}

void Mirror::record_eyes(VkCommandBuffer commands, const glm::dvec3& way_m) {
  if (steps_->eyes.pipeline == nullptr) return;
  const glm::vec3 way(way_m);
  steps_->eyes.bind(commands);
  steps_->eyes.pipeline->push(commands, std::as_bytes(std::span(&way, 1)));
  vkCmdDispatch(commands, groups_of(std::max(resources_.rig.beams_max, 1u), FL_GROUP_HEADS), 1, 1);
  vk::full_barrier(commands);
}

MirrorPlane::MirrorPlane(const fixtures::Rig& rig) {
  for (const fixtures::GlossTop& top : fixtures::gloss_tops(rig)) {
    if (corners_m_.empty()) height_m_ = top.center_m.z;
    std::vector<glm::dvec3> corners;
    for (const glm::dvec2 sides : {glm::dvec2(-1, -1), glm::dvec2(1, -1), glm::dvec2(1, 1), glm::dvec2(-1, 1)}) {
      corners.push_back(top.center_m + glm::dvec3(sides.x * top.half_x_m + sides.y * top.half_y_m, 0));
    }
    corners_m_.push_back(std::move(corners));
  }
}

bool MirrorPlane::is_seen(const View& view, double aspect) const {
  if (!(view.position_m.z - height_m_ > kAboveM)) return false;
  const double up = view.tan_half_fov;
  const double across = up * aspect;
  // Inwards, of the sides of the picture's pyramid.
  const glm::dvec3 sides[] = {view.forward, view.forward * across + view.right, view.forward * across - view.right,
                              view.forward * up + view.up, view.forward * up - view.up};
  return std::any_of(corners_m_.begin(), corners_m_.end(), [&](const std::vector<glm::dvec3>& corners) {
    return std::none_of(std::begin(sides), std::end(sides), [&](const glm::dvec3& side) {
      return std::all_of(corners.begin(), corners.end(),
                         [&](const glm::dvec3& corner) { return glm::dot(side, corner - view.position_m) <= 0; });
    });
  });
}

}  // namespace footlight::render
