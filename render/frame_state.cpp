#include "render/frame_state.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <iterator>
#include <span>
#include <vector>

#include "render/frame.h"
#include "render/haze.h"
#include "render/vk/device.h"
#include "sim/core/check.h"

namespace footlight::render {
namespace {

// Of `counts` only what the step pass writes is a state: the beams and lit heads of each group. Its CountsRow is that
// of a picture.
VkDeviceSize state_offset(const RigTables& rig, const vk::Buffer& state) {
  return &state == &rig.counts ? sizeof(CountsRow) : 0;
}

// Makes the memory that states pass through, once. Returns the bytes of all states.
Result<VkDeviceSize> prepare(vk::Device& device, const RigTables& rig, const std::vector<const vk::Buffer*>& states,
                             vk::Buffer& staging) {
  VkDeviceSize bytes = 0;
  for (const vk::Buffer* state : states) bytes += state->size_bytes - state_offset(rig, *state);
  if (bytes > 0 && staging.handle == VK_NULL_HANDLE) {
    FL_ASSIGN(staging, vk::Buffer::host_visible(device, bytes, 0));
  }
  return bytes;
}

enum class Way { kOut, kIn };

// One after the other, in `staging`.
void copy(VkCommandBuffer commands, const RigTables& rig, const std::vector<const vk::Buffer*>& states,
          const vk::Buffer& staging, Way way) {
  vk::full_barrier(commands);
  VkDeviceSize at = 0;
  for (const vk::Buffer* state : states) {
    const VkDeviceSize first = state_offset(rig, *state);
    const VkDeviceSize bytes = state->size_bytes - first;
    if (bytes == 0) continue;
    const VkBufferCopy out{first, at, bytes};
    const VkBufferCopy in{at, first, bytes};
    if (way == Way::kOut) {
      vkCmdCopyBuffer(commands, state->handle, staging.handle, 1, &out);
    } else {
      vkCmdCopyBuffer(commands, staging.handle, state->handle, 1, &in);
    }
    at += bytes;
  }
}

}  // namespace

void Frame::forget_air() {
  time_ns_ = 0;
  resources_.rig.has_probe_light = false;
  if (machines_) machines_->forget();
  if (media_) media_->forget();
}

void Frame::settle_machine_air(std::span<const std::uint8_t> levels) {
  if (machines_) machines_->settle(levels);
}

std::vector<fixtures::PlumePuff> Frame::puffs() const {
  return machines_ && puffs_.empty() ? machines_->puffs() : puffs_;
}

// The last pending step is no longer the last.
void Frame::hold_newest() {
  if (pending_.empty()) return;
  std::vector<std::uint8_t>& held = pending_.back().levels;
  for (const LevelRange& range : stepped_) {
    const auto from = newest_.begin() + static_cast<std::ptrdiff_t>(range.first);
    held.insert(held.end(), from, from + static_cast<std::ptrdiff_t>(range.size));
  }
  pending_bytes_ += held.size();
}

void Frame::upload_haze(VkCommandBuffer commands, const View& view, const PlumeField& plumes) {
  f64::HazeField field = haze_field(haze_, time_ns_);
  const double away_m = glm::length(view.position_m - haze_center_m_);
  field.from_m = std::max(away_m - haze_radius_m_, 0.0);
  field.length_m = away_m + haze_radius_m_ - field.from_m;
  const f32::HazeField single = haze_field_in_float(field);
  const VkBuffer haze = resources_.rig.haze.handle;
  vkCmdUpdateBuffer(commands, haze, 0, sizeof(single), &single);
  if (!needs_.plumes) return;
  const PlumeRows rows = plume_rows(plumes);
  vkCmdUpdateBuffer(commands, haze, sizeof(single), sizeof(rows.head), &rows.head);
  const std::size_t bytes = std::span(rows.puffs).size_bytes();
  if (bytes > 0) vkCmdUpdateBuffer(commands, haze, sizeof(single) + sizeof(rows.head), bytes, rows.puffs.data());
}

// What displays and projectors show at the levels that the heads have.
void Frame::record_pixels(VkCommandBuffer commands) {
  Frame& own = owner_ != nullptr ? *owner_ : *this;
  own.films_.record(commands, resources_.rig, own.newest_);
  own.screens_.record(commands, resources_.rig, own.newest_);
}

// The buffers that the steps write, and the newest levels, which displays show.
std::vector<const vk::Buffer*> Frame::state_buffers() const {
  std::vector<const vk::Buffer*> states;
  if (resources_.rig.levels.handle != VK_NULL_HANDLE) states.push_back(&resources_.rig.levels);
  for (const vk::Buffer* buffer : resources_.rig.all_states()) {
    if (buffer->handle != VK_NULL_HANDLE) states.push_back(buffer);
  }
  return states;
}

Result<FrameState> Frame::save_state() {
  FL_TRY(run_steps());
  FrameState state;
  state.time_ns = time_ns_;
  state.newest = newest_;
  if (machines_) state.air = machines_->air();
  if (media_) state.media = media_->states();
  const auto buffers = state_buffers();
  FL_ASSIGN(const VkDeviceSize bytes, prepare(device_, resources_.rig, buffers, state_bytes_));
  if (bytes == 0) return state;
  FL_TRY(device_.run_once([&](VkCommandBuffer commands) {
    copy(commands, resources_.rig, buffers, state_bytes_, Way::kOut);
    vk::host_barrier(commands);
  }));
  state.heads.resize(bytes);
  std::memcpy(state.heads.data(), state_bytes_.mapped, bytes);
  return state;
}

Status Frame::load_state(const FrameState& state) {
  FL_TRY(run_steps());
  const auto buffers = state_buffers();
  FL_ASSIGN(const VkDeviceSize bytes, prepare(device_, resources_.rig, buffers, state_bytes_));
  FL_CHECK_EQ(state.heads.size(), bytes);
  time_ns_ = state.time_ns;
  newest_ = state.newest;
  resources_.rig.has_probe_light = false;  // it is of the state from before
  if (machines_) machines_->set_air(state.air);
  if (media_) media_->set_states(state.media, state.newest);
  if (bytes == 0) return {};
  std::memcpy(state_bytes_.mapped, state.heads.data(), bytes);
  return device_.run_once([&](VkCommandBuffer commands) {
    copy(commands, resources_.rig, buffers, state_bytes_, Way::kIn);
    vk::full_barrier(commands);
  });
}

Result<DisplayWork> Frame::read_display_work() {
  DisplayWork work;
  if (!has_displays(needs_, settings_)) return work;
  const PictureImages& picture = resources_.picture;
  if (has_display_records(needs_, settings_)) {
    DisplayListsHead head{};
    FL_TRY(read_buffer(picture.display_records, &head, sizeof(head)));
    std::copy(std::begin(head.counts), std::end(head.counts), work.records.begin());
  }
  std::vector<DisplayTileRow> tiles(picture.display_tiles.size_bytes / sizeof(DisplayTileRow));
  FL_TRY(read_buffer(picture.display_tiles, tiles.data(), tiles.size() * sizeof(DisplayTileRow)));
  for (const DisplayTileRow& tile : tiles) {
    for (const std::uint32_t bits : tile.exact) work.pixels += static_cast<std::uint64_t>(std::popcount(bits));
    for (const std::uint32_t bits : tile.solids) work.surface_pixels += static_cast<std::uint64_t>(std::popcount(bits));
  }
  work.pixels -= work.surface_pixels;
  return work;
}

}  // namespace footlight::render
