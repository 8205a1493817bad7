#include "render/display_tables.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "fixtures/displays/screen_motion.h"

namespace footlight::render {
namespace {

// Sizes of the levels from the pixels up, and the axes of all halvings (DisplayRow::axes).
struct CellShape {
  std::vector<DisplayLevelRow> levels;
  std::uint32_t axes = 0;
  std::uint32_t part_axes = 0;
};

CellShape cell_shape_of(const fixtures::Display& display, std::uint64_t& cells) {
  CellShape shape;
  auto columns = static_cast<std::uint32_t>(display.columns), rows = static_cast<std::uint32_t>(display.rows);
  double width_m = display.width_m / columns, height_m = display.height_m / rows;
  double part_width_m = width_m, part_height_m = height_m;
  for (int bit = FL_DISPLAY_PARTS - 1; bit >= 0; --bit) {
    const bool down = part_height_m > part_width_m;
    (down ? part_height_m : part_width_m) /= 2;
    if (down) shape.part_axes |= 1u << bit;
  }
  for (std::uint32_t level = 0;; ++level) {
    const bool is_stored = level >= FL_DISPLAY_STORED;
    shape.levels.push_back({is_stored ? static_cast<std::uint32_t>(cells) : 0, columns, rows, 0});
    if (is_stored) cells += std::uint64_t{columns} * rows;
    if (columns == 1 && rows == 1) return shape;
    const bool down = columns == 1 || (rows > 1 && height_m < width_m);
    if (down) shape.axes |= 1u << level;
    (down ? rows : columns) = ((down ? rows : columns) + 1) / 2;
    (down ? height_m : width_m) *= 2;
  }
}

void set_map(const fixtures::PixelMap& map, const std::vector<Universe>& universes, DisplayRow& row) {
  const auto at = std::lower_bound(universes.begin(), universes.end(), map.universe);
  row.slot_first = static_cast<std::uint32_t>((at - universes.begin()) * kSlotCountMax);
  row.slot_start = static_cast<std::uint32_t>(slot_of_address(map.address));
  row.slots = static_cast<std::uint32_t>(map.slots);
  for (std::size_t i = 0; i < map.offsets.size(); ++i) {
    row.offsets |= (static_cast<std::uint32_t>(map.offsets[i]) & 255u) << (8 * i);
  }
  row.first_pixels = static_cast<std::uint32_t>(map.first_pixels);
  row.universe_pixels = static_cast<std::uint32_t>(map.pixels_per_universe);
  row.order = (map.columns_first ? FL_ORDER_COLUMNS : 0) | (map.serpentine ? FL_ORDER_SERPENTINE : 0) |
              (map.from_right ? FL_ORDER_FROM_RIGHT : 0) | (map.from_bottom ? FL_ORDER_FROM_BOTTOM : 0);
  row.gamma = static_cast<float>(map.gamma);
}

DisplayRow display_row(const fixtures::Display& display, const fixtures::CompiledRig& compiled) {
  const glm::dmat4 pose = fixtures::pose_of(display);
  const glm::dvec3 right(pose[0]), up(pose[2]);
  DisplayRow row{};
  row.center = vec4(display.position_m, 0);
  row.right = vec4(right, display.width_m / 2);
  row.down = vec4(-up, display.height_m / 2);
  row.front = vec4(glm::cross(right, up), 0);
  row.light = vec4(display.nits * display.color, 0);
  row.columns = static_cast<std::uint32_t>(display.columns);
  row.rows = static_cast<std::uint32_t>(display.rows);
  row.slot_first = FL_NONE;
  if (display.map) set_map(*display.map, compiled.universes, row);
  return row;
}

// Of all displays; only those of images and of even displays are not black.
std::vector<glm::vec3> first_pixels(const fixtures::Rig& rig, const DisplayTables& tables) {
  std::vector<glm::vec3> pixels(tables.pixels, glm::vec3(0));
  for (std::size_t i = 0; i < rig.displays.size(); ++i) {
    const fixtures::Display& display = rig.displays[i];
    if (display.map || fixtures::shows_film(display)) continue;
    const auto first = pixels.begin() + static_cast<std::ptrdiff_t>(tables.rows[i].pixel_first);
    const auto count = static_cast<std::ptrdiff_t>(tables.rows[i].columns) * tables.rows[i].rows;
    if (display.image) {
      std::copy_n(display.image->texels.begin(), count, first);
    } else {
      std::fill_n(first, count, glm::vec3(1));
    }
  }
  return pixels;
}

Result<vk::Buffer> empty_cells(vk::Device& device, std::uint64_t cells) {
  FL_ASSIGN(vk::Buffer buffer, vk::Buffer::device_local(device, cells * kCellBytes,
                                                        VK_BUFFER_USAGE_STORAGE_BUFFER_BIT));
  FL_TRY(device.run_once(
      [&](VkCommandBuffer commands) { vkCmdFillBuffer(commands, buffer.handle, 0, VK_WHOLE_SIZE, 0); }));
  return buffer;
}

}  // namespace

DisplayTables display_tables(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled) {
  DisplayTables tables;
  std::size_t levels_most = 0;
  for (const fixtures::Display& display : rig.displays) {
    const CellShape shape = cell_shape_of(display, tables.cells);
    DisplayRow row = display_row(display, compiled);
    row.levels = static_cast<std::uint32_t>(shape.levels.size());
    row.level_first = static_cast<std::uint32_t>(tables.levels.size());
    row.axes = shape.axes;
    row.part_axes = shape.part_axes;
    row.pixel_first = static_cast<std::uint32_t>(tables.pixels);
    tables.pixels += std::uint64_t{row.columns} * row.rows;
    tables.rows.push_back(row);
    tables.levels.insert(tables.levels.end(), shape.levels.begin(), shape.levels.end());
    levels_most = std::max(levels_most, shape.levels.size());
  }
  for (DisplayJobs* const jobs : {&tables.still, &tables.live, &tables.film}) {
    const bool live = jobs == &tables.live;
    for (std::uint32_t level = 0; level < levels_most; ++level) {
      const auto first = static_cast<std::uint32_t>(tables.jobs.size());
      for (std::uint32_t i = 0; i < tables.rows.size(); ++i) {
        const DisplayRow& row = tables.rows[i];
        const DisplayJobs* const own = row.slot_first != FL_NONE               ? &tables.live
                                       : fixtures::shows_film(rig.displays[i]) ? &tables.film
                                                                               : &tables.still;
        const bool is_made = level == 0 ? live : level >= FL_DISPLAY_STORED;
        if (own != jobs || level >= row.levels || !is_made) continue;
        const DisplayLevelRow& size = tables.levels[row.level_first + level];
        for (std::uint32_t cell = 0; cell < size.columns * size.rows; cell += FL_GROUP_DISPLAY) {
          tables.jobs.push_back({i, level, cell, 0});
        }
      }
      const auto count = static_cast<std::uint32_t>(tables.jobs.size()) - first;
      if (count > 0) jobs->push_back({first, count});
    }
  }
  return tables;
}

std::uint64_t display_bytes(std::uint32_t binding, const MemoryShape& shape) {
  if (shape.rig.displays.empty()) return 0;
  const DisplayTables tables = display_tables(shape.rig, shape.compiled);
  switch (binding) {
    case FL_BINDING_DISPLAYS: return tables.rows.size() * sizeof(DisplayRow);
    case FL_BINDING_DISPLAY_LEVELS: return tables.levels.size() * sizeof(DisplayLevelRow);
    case FL_BINDING_DISPLAY_PIXELS: return tables.pixels * kPixelBytes;
    case FL_BINDING_DISPLAY_CELLS: return tables.cells * kCellBytes;
    default: return tables.jobs.size() * sizeof(DisplayJobRow);
  }
}

Status make_display_tables(vk::Device& device, const MemoryShape& shape, RigTables& r) {
  const DisplayTables tables = display_tables(shape.rig, shape.compiled);
  for (const auto& [bytes, what] : {std::pair(tables.pixels * kPixelBytes, "pixels"),
                                    std::pair(tables.cells * kCellBytes, "cells of pixels")}) {
    if (bytes <= device.limits().maxStorageBufferRange) continue;
    return fail(ErrorCode::kUnsupported,
                "{}: maxStorageBufferRange is {}, needed: {} bytes for the {} of displays; use fewer columns or rows",
                device.name(), device.limits().maxStorageBufferRange, bytes, what);
  }
  r.display_still = tables.still;
  r.display_live = tables.live;
  r.display_film = tables.film;
  for (const fixtures::ScreenMotion& each : fixtures::screen_motions(shape.rig, shape.compiled)) {
    const fixtures::Display& display = shape.rig.displays[each.display];
    DisplayMove move{{}, {}, {}, static_cast<std::uint32_t>(each.display), each.head, each.depth, {}, 0};
    if (each.lit) move.lit = 1;
    for (int i = 0; i < 3; ++i) {
      move.light[i] = static_cast<float>(display.nits * display.color[i]);
      move.middle_m[i] = static_cast<float>(each.middle_m[i]);
      move.right[i] = static_cast<float>(each.right[i]);
      move.up[i] = static_cast<float>(each.up[i]);
    }
    r.display_moves.push_back(move);
  }
  FL_ASSIGN(r.displays, vk::Buffer::table(device, tables.rows));
  FL_ASSIGN(r.display_levels, vk::Buffer::table(device, tables.levels));
  FL_ASSIGN(r.display_pixels, vk::Buffer::table(device, first_pixels(shape.rig, tables)));
  FL_ASSIGN(r.display_cells, empty_cells(device, tables.cells));
  FL_ASSIGN(r.display_jobs, vk::Buffer::table(device, tables.jobs));
  return {};
}

std::vector<DiscoBall> disco_balls(const fixtures::Rig& rig, const fixtures::CompiledRig& compiled) {
  std::vector<DiscoBall> balls;
  for (std::size_t i = 0; i < rig.fixtures.size(); ++i) {
    const fixtures::FixtureType& type = fixtures::type_of(rig, rig.fixtures[i]);
    if (type.id != "vrsl/disco-ball" || type.beams.empty()) continue;
    const fixtures::Beam& spot = type.beams.front();
    const double half_rad = spot.field_angle_deg / 2 * std::numbers::pi / 180;
    const double candela = spot.flux_lm / (2 * std::numbers::pi * (1 - std::cos(half_rad)));
    balls.push_back({compiled.head_first[i], compiled.head_first[i + 1] - compiled.head_first[i],
                     static_cast<float>(candela)});
  }
  return balls;
}

}  // namespace footlight::render
