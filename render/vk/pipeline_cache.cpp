#include "render/vk/pipeline_cache.h"

#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>

#include <unistd.h>

#include "sim/core/fnv.h"

namespace footlight::render::vk {
namespace {

namespace fs = std::filesystem;

struct Header {
  char magic[8];
  std::uint8_t cache_uuid[VK_UUID_SIZE];
  std::uint8_t device_uuid[VK_UUID_SIZE];
  std::uint32_t driver_version;
  std::uint32_t pad;
  std::uint64_t bytes;
  std::uint64_t checksum;
};
static_assert(sizeof(Header) == 64);

Header header_of(const DeviceFacts& facts, std::span<const std::byte> data) {
  Header header{};
  std::memcpy(header.magic, "FLPIPE01", sizeof(header.magic));
  std::memcpy(header.cache_uuid, facts.properties.pipelineCacheUUID, VK_UUID_SIZE);
  std::memcpy(header.device_uuid, facts.id.deviceUUID, VK_UUID_SIZE);
  header.driver_version = facts.properties.driverVersion;
  header.bytes = data.size();
  header.checksum = fnv_sum(data);
  return header;
}

}  // namespace

std::string pipeline_cache_path(const std::string& folder, const DeviceFacts& facts) {
  std::string name = folder + "/pipelines-";
  for (const std::uint8_t byte : facts.id.deviceUUID) name += fmt::format("{:02x}", byte);
  return name + fmt::format("-{:08x}.bin", facts.properties.driverVersion);
}

std::vector<std::byte> read_pipeline_cache(const std::string& path, const DeviceFacts& facts) {
  std::error_code trouble;
  if (!fs::is_regular_file(path, trouble)) return {};  // no pipe, that would block
  const auto size = fs::file_size(path, trouble);
  if (trouble || size < sizeof(Header) || size > sizeof(Header) + kPipelineCacheBytesMax) return {};
  std::ifstream stream(path, std::ios::binary);
  Header header{};
  std::vector<std::byte> data(static_cast<std::size_t>(size) - sizeof(Header));
  stream.read(reinterpret_cast<char*>(&header), sizeof(header));
  stream.read(reinterpret_cast<char*>(data.data()), static_cast<std::streamsize>(data.size()));
  const Header expected = header_of(facts, data);
  if (!stream || std::memcmp(&header, &expected, sizeof(header)) != 0) return {};
  return data;
}

Status write_pipeline_cache(const std::string& path, const DeviceFacts& facts, std::span<const std::byte> data) {
  if (data.size() > kPipelineCacheBytesMax) {
    return fail(ErrorCode::kIo, "{}: {} bytes of compiled pipelines, expected at most {}", path, data.size(),
                kPipelineCacheBytesMax);
  }
  std::error_code trouble;
  fs::create_directories(fs::path(path).parent_path(), trouble);
  const std::string part = fmt::format("{}.{}.part", path, getpid());
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  const Header header = header_of(facts, data);
  stream.write(reinterpret_cast<const char*>(&header), sizeof(header));
  stream.write(reinterpret_cast<const char*>(data.data()), static_cast<std::streamsize>(data.size()));
  stream.close();
  if (stream && std::rename(part.c_str(), path.c_str()) == 0) return {};
  fs::remove(part, trouble);
  return fail(ErrorCode::kIo, "{}: cannot be written; FOOTLIGHT_PIPELINE_CACHE=off does without it", path);
}

}  // namespace footlight::render::vk
