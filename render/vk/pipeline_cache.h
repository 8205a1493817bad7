// Compiled pipelines of one device and driver, kept in a file from run to run.
//
// The file is replaced as a whole. One that is damaged, of another driver or unreadable is ignored, since the pipelines
// can always be compiled again; drivers may crash on damaged data, so our own header has a checksum of all of it.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <vector>

#include "render/vk/demands.h"
#include "sim/core/result.h"

namespace footlight::render::vk {

inline constexpr std::size_t kPipelineCacheBytesMax = std::size_t{256} << 20;

// In `folder`, named by the device's UUID and the driver's version.
[[nodiscard]] std::string pipeline_cache_path(const std::string& folder, const DeviceFacts& facts);
// What write_pipeline_cache() was given; empty where the file is missing, damaged or not of this driver.
[[nodiscard]] std::vector<std::byte> read_pipeline_cache(const std::string& path, const DeviceFacts& facts);
// Makes the folder where it is missing.
Status write_pipeline_cache(const std::string& path, const DeviceFacts& facts, std::span<const std::byte> data);

}  // namespace footlight::render::vk
