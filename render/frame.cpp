#include "render/frame.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "fixtures/displays/pixel_slots.h"
#include "fixtures/simulate/machines.h"
#include "render/glare.h"
#include "render/haze.h"
#include "render/passes/beams.h"
#include "render/passes/gloss.h"
#include "render/passes/gobos.h"
#include "render/passes/haze.h"
#include "render/passes/probes.h"
#include "render/passes/records.h"
#include "render/passes/step.h"
#include "render/passes/tonemap.h"
#include "render/shadow_tables.h"

namespace footlight::render {
namespace {

// Time stamps of a frame: its beginning, the levels, the mirrored camera's picture, and the end of each pass.
std::uint32_t marks_max(const PassList& passes) { return static_cast<std::uint32_t>(passes.size()) + 3; }

constexpr double kNearM = 0.05;
constexpr double kAdaptNs = 1e9;  // time constant of the automatic exposure

// Where the step pass finds its time step: the push constants of step.comp.
struct StepPush {
  std::uint32_t dt_ns_low;
  std::uint32_t dt_ns_high;
  std::uint32_t new_exposure;
};

}  // namespace

Result<std::unique_ptr<Frame>> Frame::create(vk::Device& device, const fixtures::Rig& rig,
                                             const fixtures::CompiledRig& compiled, const FrameSettings& settings,
                                             const PassList& passes, const FrameSettings* first) {
  std::unique_ptr<Frame> frame(new Frame(device, passes));
  FL_TRY(frame->check_settings(settings));
  const FrameSettings& begun = first != nullptr ? *first : settings;
  frame->needs_ = compiled.needs;
  frame->haze_ = rig.haze;
  frame->compile_beside_tables(rig, compiled, begun);
  FrameSettings widest = settings;  // the tables are those of every setting that change() may bring
  widest.haze = true;
  widest.method = BeamMethod::kGauss;
  widest.gobo_method = GoboMethod::kTables;
  widest.view = FrameView::kPicture;
  widest.widen_thin = true;
  widest.gloss_px = std::max(settings.gloss_px, 1u);
  std::vector<bool> used(FL_BINDING_COUNT, false);
  for (const std::uint32_t binding : frame_bindings()) used[binding] = true;
  // live_error.h names them in any frame.
  used[FL_BINDING_LENSES] = used[FL_BINDING_PROBES] = used[FL_BINDING_PROBE_LIGHT] = true;
  for (const PassEntry* pass : passes) {
    if (!pass->needed(compiled.needs, widest)) continue;
    for (const std::uint32_t binding : bindings_of(*pass)) used[binding] = true;
  }
  FL_ASSIGN(frame->resources_.rig, RigTables::create(device, {rig, compiled, compiled.needs, widest}, used));
  if (frame->resources_.rig.sheen_count > 0) frame->needs_.sheen = true;  // now the files of meshes have been read
  FL_TRY(frame->films_.create(device, {rig, compiled, compiled.needs, widest}, frame->resources_.rig));
  frame->screens_ = ScreenLights(rig, compiled);
  const std::vector<bool> only_pixels = fixtures::pixel_universes(rig, compiled);
  for (std::size_t i = 0; i < only_pixels.size(); ++i) {
    if (only_pixels[i]) continue;
    auto& ranges = frame->stepped_;
    const VkDeviceSize at = i * kSlotCountMax;
    if (ranges.empty() || ranges.back().first + ranges.back().size != at) ranges.push_back({at, 0});
    ranges.back().size += kSlotCountMax;
  }
  frame->ambient_lx_ = rig.ambient_lx;
  frame->mirror_plane_ = MirrorPlane(rig);
  frame->machines_ = fixtures::MachineAir::make(rig, compiled);
  frame->media_ = fixtures::MediaPlayer::make(rig, compiled);
  frame->range_m_ = light_range_m(rig, frame->resources_.rig.objects);
  const HazeReach reach = haze_reach(rig, frame->range_m_);
  frame->haze_center_m_ = reach.center_m;
  frame->haze_radius_m_ = reach.radius_m;
  VkQueryPoolCreateInfo query{VK_STRUCTURE_TYPE_QUERY_POOL_CREATE_INFO};
  query.queryType = VK_QUERY_TYPE_TIMESTAMP;
  query.queryCount = marks_max(passes);
  if (device.facts().timestamp_bits > 0) {
    FL_TRY(vk::check(vkCreateQueryPool(device.handle, &query, nullptr, &frame->times_), "vkCreateQueryPool"));
  }
  FL_TRY(frame->change(begun));
  return frame;
}

Frame::Frame(vk::Device& device, const PassList& passes, RigTables* shared)
    : device_(device), resources_{.rig = shared != nullptr ? *shared : tables_}, entries_(passes) {}

Status Frame::check_settings(const FrameSettings& settings) const {
  if (settings.nodes < 1 || (settings.method == BeamMethod::kGauss && settings.nodes > 8)) {
    return fail(ErrorCode::kBadInput, "{} quadrature nodes: expected 1 to 8", settings.nodes);
  }
  if (!(settings.tile_error >= 0 && settings.tile_error <= 1)) {
    return fail(ErrorCode::kBadInput, "tile error {}: expected 0 to 1", settings.tile_error);
  }
  if (!(settings.body_error_px >= 0 && settings.body_error_px <= 1000)) {
    return fail(ErrorCode::kBadInput, "error of bodies {} pixels: expected 0 to 1000", settings.body_error_px);
  }
  if (settings.edge_samples != 0 && settings.edge_samples != 4 && settings.edge_samples != 8 &&
      settings.edge_samples != FL_EDGE_SAMPLES_MAX) {
    return fail(ErrorCode::kBadInput, "{} samples of a pixel with an edge: expected 0, 4, 8 or 16",
                settings.edge_samples);
  }
  FL_TRY(check_shadow_settings(settings));
  if (!(settings.glare >= 0 && settings.glare <= 1)) {
    return fail(ErrorCode::kBadInput, "glare {}: expected a share of the light, 0 to 1", settings.glare);
  }
  if (settings.white_k != 0 && !(settings.white_k >= kWhiteMinK && settings.white_k <= kWhiteMaxK)) {
    return fail(ErrorCode::kBadInput, "white balance {} K: expected 0 for none, or {} to {}", settings.white_k,
                kWhiteMinK, kWhiteMaxK);
  }
  if (settings.f_stop != 0 && !(settings.f_stop >= fixtures::kFStopMin && settings.f_stop <= fixtures::kFStopMax &&
                                settings.focus_m >= fixtures::kFocusMinM)) {
    return fail(ErrorCode::kBadInput, "f-stop {} at {} m: expected 0 for none, or {} to {} at {} m or more",
                settings.f_stop, settings.focus_m, fixtures::kFStopMin, fixtures::kFStopMax, fixtures::kFocusMinM);
  }
  if (settings.probe_texels < 1 || settings.probe_texels > FL_PROBE_TEXELS) {
    return fail(ErrorCode::kBadInput, "{} texels of a reflection probe a frame: expected 1 to {}",
                settings.probe_texels, FL_PROBE_TEXELS);
  }
  if (settings.gloss_px > 8) {
    return fail(ErrorCode::kBadInput, "{} pixels a side of one of a mirror: expected 0 to 8", settings.gloss_px);
  }
  if (settings.supersample < 1 || settings.width % settings.supersample != 0 ||
      settings.height % settings.supersample != 0) {
    return fail(ErrorCode::kBadInput, "{}x{} pixels, {} a side of one of the screen: expected whole ones",
                settings.width, settings.height, settings.supersample);
  }
  const auto size_max = static_cast<int>(std::min(device_.limits().maxImageDimension2D, 1u << 30));
  if (settings.width < 1 || settings.height < 1 || settings.width > size_max || settings.height > size_max) {
    return fail(ErrorCode::kBadInput, "picture size {}x{}: expected 1x1 to {}x{} on {}", settings.width,
                settings.height, size_max, size_max, device_.name());
  }
  return {};
}

Status Frame::change(const FrameSettings& requested) {
  FL_TRY(check_settings(requested));
  FrameSettings settings = suited(requested);
  // Numbers of triangles have 32 bits.
  if (resources_.rig.body_triangles + resources_.rig.object_triangles >= ~std::uint32_t{0}) {
    settings.triangles = TriangleMethod::kRasteriser;
  }
  const fixtures::Needs needs = drawn_needs(needs_, haze_, settings);
  if (has_bodies(needs, settings) && !resources_.rig.has_bodies) {
    return fail(ErrorCode::kBadInput, "bodies were left out when the frame was made: expected a new frame");
  }
  if (has_occluders(needs, settings) && !resources_.rig.has_occluders) {
    return fail(ErrorCode::kBadInput, "shadows were left out when the frame was made: expected a new frame");
  }
  FL_TRY(suit_shadows(needs, resources_.rig, device_.limits().maxStorageBufferRange, settings));
  if (has_bounce(needs, settings) && !resources_.rig.has_bounce) {
    return fail(ErrorCode::kBadInput, "reflected light was left out when the frame was made: expected a new frame");
  }
  if (has_bounce(needs, settings) && has_bodies(needs, settings) != resources_.rig.has_bodies) {
    return fail(ErrorCode::kBadInput, "reflected light was made with other bodies: expected a new frame");
  }
  if (has_probes(needs, settings) && !resources_.rig.has_probes) {
    return fail(ErrorCode::kBadInput, "reflection probes were left out when the frame was made: expected a new frame");
  }
  const bool has_images = resources_.picture.screen.handle != VK_NULL_HANDLE;
  const bool same_images =
      has_images && settings.width == settings_.width && settings.height == settings_.height &&
      settings.supersample == settings_.supersample && has_bodies(needs, settings) == has_bodies(needs, settings_) &&
      has_computed_triangles(needs, settings) == has_computed_triangles(needs, settings_) &&
      has_joined_words(needs, settings) == has_joined_words(needs, settings_) &&
      has_smooth_edges(needs, settings) == has_smooth_edges(drawn_needs(needs_, haze_, settings_), settings_) &&
      settings.edge_samples == settings_.edge_samples && settings.edge_pixels == settings_.edge_pixels &&
      has_glare(needs, settings) == has_glare(drawn_needs(needs_, haze_, settings_), settings_) &&
      has_depth_of_field(needs, settings) == has_depth_of_field(needs, settings_) &&
      has_gloss(needs, settings) == has_gloss(needs, settings_) && settings.gloss_px == settings_.gloss_px &&
      settings.penumbra == settings_.penumbra &&
      has_displays(needs, settings) == has_displays(needs, settings_) &&
      has_display_records(needs, settings) == has_display_records(needs, settings_) &&
      has_tile_classes(needs, settings) == has_tile_classes(drawn_needs(needs_, haze_, settings_), settings_) &&
      has_tile_depths(needs, settings) == has_tile_depths(drawn_needs(needs_, haze_, settings_), settings_) &&
      has_shadows_in_air(needs, settings) == has_shadows_in_air(drawn_needs(needs_, haze_, settings_), settings_);
  passes_.clear();
  before_views_.clear();
  mirror_.reset();
  plan_.clear();
  timed_.clear();
  settings_ = settings;
  has_solids_ = has_solids(needs, settings);
  has_fine_ = has_tile_classes(needs, settings);
  if (!same_images) {
    resources_.picture = {};  // first, so that two sizes never stand in memory
    FL_ASSIGN(resources_.picture,
              PictureImages::create(device_, needs, settings, resources_.rig.mask_words, resources_.rig.laser_rows));
    resources_.bind_all();
  }
  std::vector<std::unique_ptr<Pass>> passes;
  for (const PassEntry* entry : entries_) {
    if (!entry->needed(needs, settings)) continue;
    FL_ASSIGN(auto pass, entry->create({device_, resources_, settings_, entry->constants(needs, settings)}));
    passes.push_back(std::move(pass));
    before_views_.push_back(entry->before_views);
  }
  passes_ = std::move(passes);
  plan_ = plan_frame(needs, settings, entries_);
  if (draws(kGlossPass)) {
    FL_ASSIGN(mirror_, Mirror::create(device_, resources_, needs, settings, entries_));
  }
  has_step_ = draws(kStepPass);
  if (!draws(kProbesPass)) resources_.rig.has_probe_light = false;  // what it holds is old when the pass comes back
  return device_.pipelines().finish();
}

bool Frame::draws(const PassEntry& entry) const {
  return std::any_of(plan_.begin(), plan_.end(), [&](const PassPlan& pass) { return pass.name == entry.name; });
}

std::uint64_t Frame::bytes() const {
  std::uint64_t bytes = resources_.total_bytes + films_.bytes() + (mirror_ ? mirror_->bytes() : 0);
  for (const auto& pass : passes_) bytes += pass->own_bytes();
  return bytes;
}

Frame::~Frame() {
  (void)device_.wait_idle();
  if (times_ != VK_NULL_HANDLE) vkDestroyQueryPool(device_.handle, times_, nullptr);
}

void Frame::step(std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
  FL_CHECK_EQ(levels.size(), resources_.rig.levels_bytes);
  ++pending_count_;
  if (has_step_) {
    hold_newest();
    pending_.push_back({{}, std::max<std::int64_t>(dt_ns, 0), new_exposure});
  }
  newest_.assign(levels.begin(), levels.end());
  if (machines_) machines_->step(levels, dt_ns);
  if (media_) media_->step(levels, dt_ns);
  time_ns_ += std::max<std::int64_t>(dt_ns, 0);
}

void Frame::record(VkCommandBuffer commands, const View& view, double exposure_ev, bool adapts) {
  adapts_ = adapts;
  if (times_ != VK_NULL_HANDLE) vkCmdResetQueryPool(commands, times_, 0, marks_max(entries_));
  timed_.clear();
  resources_.rig.display_cells_fresh = false;
  is_mirrored_ = mirror_ && mirror_plane_.is_seen(view, static_cast<double>(settings_.width) / settings_.height);
  const View first = is_mirrored_ ? mirrored(view, mirror_plane_.height_m()) : view;
  upload_params(commands, first, exposure_ev, is_mirrored_ ? mirror_.get() : nullptr);
  mark(commands, "");
  record_levels(commands);
  record_pixels(commands);
  if (!has_solids_ && !draws(kBeamsPass)) clear_radiance(commands);
  if (is_mirrored_) {
    record_passes(commands, true);
    mirror_->record(commands);
    upload_params(commands, view, exposure_ev);
    mirror_->record_eyes(commands, view.position_m - first.position_m);
    mark(commands, "mirror");
  }
  record_passes(commands, false);
  if (adapts) adapt_ns_ = 0;
  exposure_ev_ = exposure_ev;
}

// before_views: those before the mirrored camera's picture; else the others, without one all but that of its light.
void Frame::record_passes(VkCommandBuffer commands, bool before_views) {
  // The first pass that adds to what surfaces have left.
  const std::string_view beams_first = has_fine_ ? kRecordsPass.name : kBeamsPass.name;
  for (std::size_t i = 0; i < passes_.size(); ++i) {
    if (is_mirrored_ ? before_views_[i] != before_views : plan_[i].name == kGlossPass.name) continue;
    if (plan_[i].name == kStepPass.name) {
      record_steps(commands, true);
    } else if (plan_[i].name == kTonemapPass.name) {
      const double passed_ns = adapts_ ? static_cast<double>(adapt_ns_) : 0;
      const auto kept = static_cast<float>(std::exp(-passed_ns / kAdaptNs));
      passes_[i]->record(commands, std::as_bytes(std::span(&kept, 1)));
    } else {
      if (plan_[i].name == beams_first && !has_solids_) clear_radiance(commands);
      if (plan_[i].name == kGlossPass.name) mirror_->record_levels(commands);
      passes_[i]->record(commands, {});
    }
    mark(commands, plan_[i].name);
  }
}

// Without solid things nothing else writes a pixel when no beam is lit. Alpha: no surface ends a ray.
void Frame::clear_radiance(VkCommandBuffer commands) {
  const VkClearColorValue black{{0, 0, 0, static_cast<float>(FL_FAR_M)}};
  const VkImageSubresourceRange range{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
  vkCmdClearColorImage(commands, resources_.picture.radiance.handle, VK_IMAGE_LAYOUT_GENERAL, &black, 1, &range);
  vk::full_barrier(commands);
}

// vkCmdUpdateBuffer keeps the bytes in the command buffer: quick for a few universes, slow for hundreds. Of those the
// newest levels are copied from memory that only one step of a recording can use.
void Frame::upload_newest(VkCommandBuffer commands) {
  const VkDeviceSize size = newest_.size();
  if (size > kUpdateBytesMax) {
    std::memcpy(resources_.rig.staged_levels.mapped, newest_.data(), size);
    const VkBufferCopy region{0, 0, size};
    vkCmdCopyBuffer(commands, resources_.rig.staged_levels.handle, resources_.rig.levels.handle, 1, &region);
  } else if (size > 0) {
    vkCmdUpdateBuffer(commands, resources_.rig.levels.handle, 0, size, newest_.data());
  }
}

void Frame::upload_levels(VkCommandBuffer commands, const PendingStep& pending) {
  if (&pending == &pending_.back()) {
    upload_newest(commands);
    return;
  }
  const std::uint8_t* from = pending.levels.data();
  for (const LevelRange& range : stepped_) {
    for (VkDeviceSize at = 0; at < range.size; at += kUpdateBytesMax) {
      const VkDeviceSize size = std::min(kUpdateBytesMax, range.size - at);
      vkCmdUpdateBuffer(commands, resources_.rig.levels.handle, range.first + at, size, from);
      from += size;
    }
  }
}

// Without fixtures there is no step pass: the newest levels alone count, for displays.
void Frame::record_levels(VkCommandBuffer commands) {
  if (pending_count_ == 0 || has_step_) return;
  if (resources_.rig.levels.handle != VK_NULL_HANDLE && !newest_.empty()) {
    upload_newest(commands);
    vk::full_barrier(commands);
  }
  pending_count_ = 0;
}

// Each pending step: its levels, its dt, one dispatch. Timed are the levels of the first.
void Frame::record_steps(VkCommandBuffer commands, bool timed) {
  for (const PendingStep& pending : pending_) {
    upload_levels(commands, pending);
    if (timed && &pending == &pending_.front()) mark(commands, "levels");
    const auto dt = static_cast<std::uint64_t>(pending.dt_ns);
    const StepPush push{static_cast<std::uint32_t>(dt), static_cast<std::uint32_t>(dt >> 32), pending.new_exposure};
    vk::full_barrier(commands);
    passes_.front()->record(commands, std::as_bytes(std::span(&push, 1)));
    vk::full_barrier(commands);
  }
  pending_.clear();
  pending_count_ = 0;
  pending_bytes_ = 0;
}

void Frame::upload_params(VkCommandBuffer commands, const View& view, double exposure_ev, const Mirror* mirror) {
  const double aspect = static_cast<double>(settings_.width) / settings_.height;
  const FrameSettings& settings = mirror != nullptr ? mirror->settings() : settings_;
  const PictureImages& picture = mirror != nullptr ? mirror->picture() : resources_.picture;
  FrameParams params{};
  params.right = vec4(view.right * (view.tan_half_fov * aspect), kNearM);
  params.up = vec4(view.up * view.tan_half_fov, range_m_);
  double scattering_per_m =
      settings_.haze ? haze_.scattering_per_m + (machines_ ? machines_->scattering_per_m() : 0) : 0;
  PlumeField plumes;
  if (settings_.haze && needs_.plumes) {
    plumes = plume_field(puffs(), scattering_per_m, time_ns_);
    scattering_per_m = plumes.head.scattering_per_m;
  }
  params.forward = vec4(view.forward, scattering_per_m);
  params.position = vec4(view.position_m, scattering_per_m + haze_.absorption_per_m);
  params.width = static_cast<std::uint32_t>(settings.width);
  params.height = static_cast<std::uint32_t>(settings.height);
  params.head_count = resources_.rig.head_count;
  params.box_count = resources_.rig.box_count;
  params.supertiles_x = picture.supertiles_x;
  params.mask_words = resources_.rig.mask_words;
  params.anisotropy = static_cast<float>(haze_.anisotropy);
  params.ambient_lx = static_cast<float>(ambient_lx_);
  params.exposure = static_cast<float>(exposure_factor(exposure_ev));
  params.dark_lm = static_cast<float>(settings_.dark_lm);
  const double pixel = 2 * view.tan_half_fov / settings.height;  // at a depth of 1
  params.thin = settings_.widen_thin ? static_cast<float>(FL_THIN_RADIUS_PX * pixel) : 0.0f;
  params.supersample = static_cast<std::uint32_t>(settings.supersample);
  params.tile_error = static_cast<float>(settings_.tile_error);
  params.tile_beams = settings.tile_beams;
  params.rims_max = picture.rims_max;
  params.cuts_max = picture.cuts_max;
  params.work_lx = static_cast<float>(work_light_lx_);
  params.body_error_px = static_cast<float>(settings_.body_error_px);
  params.computed_triangles = has_computed_triangles(needs_, settings) ? 1 : 0;
  params.object_level = resources_.rig.object_draw_count > 0 ? resources_.rig.draw_count : FL_NONE;
  params.probe_count = resources_.rig.probe_count;
  if (mirror != nullptr) params.mirror_m = static_cast<float>(mirror_plane_.height_m() - view.position_m.z);
  vk::full_barrier(commands);  // the frame before may still be reading
  vkCmdUpdateBuffer(commands, resources_.rig.params.handle, 0, sizeof(params), &params);
  if (draws(kHazePass)) upload_haze(commands, view, plumes);
  vk::full_barrier(commands);
}

// The barrier comes after the time stamp: lavapipe writes a time stamp when a barrier flushes it, so that one after the
// barrier would have the next pass in it.
void Frame::mark(VkCommandBuffer commands, std::string_view ended) {
  if (times_ != VK_NULL_HANDLE) {
    vkCmdWriteTimestamp2(commands, VK_PIPELINE_STAGE_2_ALL_COMMANDS_BIT, times_,
                         static_cast<std::uint32_t>(timed_.size()));
    timed_.push_back(ended);
  }
  vk::full_barrier(commands);
}

Status Frame::draw(const View& view, double exposure_ev) {
  return device_.run_once([&](VkCommandBuffer commands) { record(commands, view, exposure_ev); });
}

Status Frame::run_steps() {
  if (pending_count_ == 0) return {};
  if (!has_step_) {
    return device_.run_once([&](VkCommandBuffer commands) { record_levels(commands); });
  }
  return device_.run_once([&](VkCommandBuffer commands) {
    upload_params(commands, View{}, 0);
    record_steps(commands, false);
  });
}

Status Frame::read_buffer(const vk::Buffer& buffer, void* out, std::size_t bytes) {
  if (bytes == 0) return {};
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device_, bytes, 0));
  FL_TRY(device_.run_once([&](VkCommandBuffer commands) {
    vk::full_barrier(commands);
    const VkBufferCopy region{0, 0, bytes};
    vkCmdCopyBuffer(commands, buffer.handle, staging.handle, 1, &region);
    vk::host_barrier(commands);
  }));
  std::memcpy(out, staging.mapped, bytes);
  return {};
}

Status Frame::read_image(const vk::Image& image, int width, int height, void* out, std::size_t bytes) {
  FL_ASSIGN(vk::Buffer staging, vk::Buffer::host_visible(device_, bytes, 0));
  FL_TRY(device_.run_once([&](VkCommandBuffer commands) {
    vk::full_barrier(commands);
    VkBufferImageCopy region{};
    region.imageSubresource = {VK_IMAGE_ASPECT_COLOR_BIT, 0, 0, 1};
    region.imageExtent = {static_cast<std::uint32_t>(width), static_cast<std::uint32_t>(height), 1};
    vkCmdCopyImageToBuffer(commands, image.handle, VK_IMAGE_LAYOUT_GENERAL, staging.handle, 1, &region);
    vk::host_barrier(commands);
  }));
  std::memcpy(out, staging.mapped, bytes);
  return {};
}

Result<RadianceImage> Frame::read_radiance(std::vector<float>* distances_m) {
  const std::size_t pixels = static_cast<std::size_t>(settings_.width) * static_cast<std::size_t>(settings_.height);
  std::vector<float> rgba(pixels * 4);
  FL_TRY(read_image(resources_.picture.radiance, settings_.width, settings_.height, rgba.data(),
                    rgba.size() * sizeof(float)));
  RadianceImage image{settings_.width, settings_.height, std::vector<float>(pixels * 3)};
  for (std::size_t i = 0; i < pixels; ++i) std::copy_n(&rgba[i * 4], 3, &image.rgb[i * 3]);
  for (std::size_t i = 0; distances_m != nullptr && i < pixels; ++i) distances_m->push_back(rgba[i * 4 + 3]);
  return image;
}

Result<RadianceImage> Frame::read_seen() {
  FL_ASSIGN(const RadianceImage whole, read_radiance());
  const RadianceImage light = averaged(whole, settings_.supersample);
  if (resources_.picture.glare.handle == VK_NULL_HANDLE) return light;
  const GlareShape shape = glare_shape(settings_);
  std::vector<float> rgba(static_cast<std::size_t>(shape.width) * static_cast<std::size_t>(shape.height) * 4);
  FL_TRY(read_image(resources_.picture.glare, shape.width, shape.height, rgba.data(), rgba.size() * sizeof(float)));
  return with_glare(light, shape, rgba);
}

Result<double> Frame::read_exposure_ev() {
  if (!settings_.auto_exposure) return exposure_ev_;
  float luminance = 0;
  FL_TRY(read_buffer(resources_.rig.meter, &luminance, sizeof(luminance)));
  return luminance > 0 ? std::log2(static_cast<double>(luminance) * exposure_factor(0)) : exposure_ev_;
}

Result<ScreenImage> Frame::read_screen() {
  ScreenImage image{settings_.width / settings_.supersample, settings_.height / settings_.supersample, {}};
  image.rgba.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 4);
  FL_TRY(read_image(resources_.picture.screen, image.width, image.height, image.rgba.data(), image.rgba.size()));
  return image;
}

Result<CountsRow> Frame::read_counts() {
  CountsRow counts{};
  FL_TRY(read_buffer(resources_.rig.counts, &counts, sizeof(counts)));
  return counts;
}

template <class Row>
Result<std::vector<Row>> Frame::read_rows(const vk::Buffer& buffer, std::uint32_t count) {
  std::vector<Row> rows(count);
  FL_TRY(read_buffer(buffer, rows.data(), rows.size() * sizeof(Row)));
  return rows;
}

Result<std::vector<fixtures::f32::Walker::HeadState>> Frame::read_states() {
  static_assert(sizeof(fixtures::f32::Walker::HeadState) == kStateBytes);
  return read_rows<fixtures::f32::Walker::HeadState>(resources_.rig.states, resources_.rig.head_count);
}

Result<std::vector<fixtures::f32::Motor>> Frame::read_motors() {
  static_assert(sizeof(fixtures::f32::Motor) == kMotorStateBytes);
  return read_rows<fixtures::f32::Motor>(resources_.rig.motor_states, resources_.rig.motor_count);
}

Result<std::vector<fixtures::f32::Spin>> Frame::read_spins() {
  static_assert(sizeof(fixtures::f32::Spin) == kSpinStateBytes);
  return read_rows<fixtures::f32::Spin>(resources_.rig.spin_states, resources_.rig.spin_count);
}

Result<std::vector<fixtures::f32::Shutter>> Frame::read_shutters() {
  static_assert(sizeof(fixtures::f32::Shutter) == kShutterStateBytes);
  return read_rows<fixtures::f32::Shutter>(resources_.rig.shutter_states, resources_.rig.shutter_count);
}

Result<std::vector<fixtures::f32::Walker::OpticsState>> Frame::read_optics() {
  static_assert(sizeof(fixtures::f32::Walker::OpticsState) == kOpticsStateBytes);
  return read_rows<fixtures::f32::Walker::OpticsState>(resources_.rig.optics_states, resources_.rig.optics_count);
}

#define FL_LAMP_READ(number, Kind, need, State, per_head)                                                           \
  Result<std::vector<fixtures::f32::State>> Frame::read_##need##_states() {                                         \
    static_assert(sizeof(fixtures::f32::State) == kLampStateBytes);                                                 \
    return read_rows<fixtures::f32::State>(resources_.rig.lamp_states[number], resources_.rig.lamp_counts[number]); \
  }
FL_LAMPS(FL_LAMP_READ)
#undef FL_LAMP_READ

Result<std::vector<fixtures::f32::Slew>> Frame::read_dowsers() {
  static_assert(sizeof(fixtures::f32::Slew) == kDowserStateBytes);
  return read_rows<fixtures::f32::Slew>(resources_.rig.dowser_states, resources_.rig.dowser_count);
}

Result<std::vector<fixtures::f32::Smooth>> Frame::read_smooths() {
  static_assert(sizeof(fixtures::f32::Smooth) == kSmoothStateBytes);
  return read_rows<fixtures::f32::Smooth>(resources_.rig.smooth_states, resources_.rig.smooth_count);
}

Result<std::vector<CoarseRow>> Frame::read_supertiles() {
  if (!has_fine_) return std::vector<CoarseRow>{};
  return read_rows<CoarseRow>(resources_.picture.coarse,
                              resources_.picture.supertiles_x * resources_.picture.supertiles_y);
}

Result<std::vector<BeamRow>> Frame::read_beams() {
  FL_ASSIGN(const CountsRow counts, read_counts());
  std::vector<BeamRow> beams(counts.live_count);
  FL_TRY(read_buffer(resources_.rig.beams, beams.data(), beams.size() * sizeof(BeamRow)));
  return beams;
}

Result<GatesHead> Frame::read_gates() {
  GatesHead gates{};
  if (!draws(kGobosPass) || resources_.rig.gobo_queue_empty.gates == 0) return gates;
  FL_TRY(read_buffer(resources_.rig.gates, &gates, sizeof(gates)));
  return gates;
}

Result<BodyCounts> Frame::read_bodies() {
  const RigTables& rig = resources_.rig;
  BodyCounts counts{
      .bodies = rig.slot_count, .triangles = rig.body_triangles, .object_triangles = rig.object_triangles};
  if (!settings_.bodies || rig.slot_count == 0) return counts;
  FL_ASSIGN(const auto choices, read_rows<std::uint32_t>(rig.choices, rig.slot_count));
  for (const std::uint32_t choice : choices) {
    if (choice == FL_CHOICE_NONE) continue;
    ++counts.drawn;
    counts.drawn_triangles += rig.level_triangles[choice & FL_CHOICE_LEVEL];
  }
  return counts;
}

Result<std::vector<PassTime>> Frame::read_times() {
  std::vector<std::uint64_t> ticks(timed_.size());
  if (ticks.empty()) return std::vector<PassTime>{};
  FL_TRY(vk::check(
      vkGetQueryPoolResults(device_.handle, times_, 0, static_cast<std::uint32_t>(ticks.size()), ticks.size() * 8,
                            ticks.data(), 8, VK_QUERY_RESULT_64_BIT | VK_QUERY_RESULT_WAIT_BIT),
      "vkGetQueryPoolResults"));
  std::vector<PassTime> times;
  const std::uint32_t bits = device_.facts().timestamp_bits;
  const std::uint64_t mask = bits < 64 ? (std::uint64_t{1} << bits) - 1 : ~std::uint64_t{0};
  for (std::size_t i = 1; i < ticks.size(); ++i) {
    const double ns = static_cast<double>((ticks[i] - ticks[i - 1]) & mask) * device_.timestamp_period_ns();
    times.push_back({std::string(timed_[i]), ns * 1e-6});
  }
  return times;
}

}  // namespace footlight::render
