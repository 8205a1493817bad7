// Compiled pipelines in a file.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/frame.h"
#include "render/vk/pipeline.h"
#include "render/vk/pipeline_cache.h"
#include "tests/support/headless_vulkan.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"

namespace footlight::render::vk {
namespace {

namespace fs = std::filesystem;
using footlight::testing::HeadlessVulkan;
using footlight::testing::must;
using footlight::testing::TempFolder;

DeviceFacts some_facts() {
  DeviceFacts facts;
  facts.properties.driverVersion = 0x1234;
  for (std::size_t i = 0; i < VK_UUID_SIZE; ++i) {
    facts.id.deviceUUID[i] = static_cast<std::uint8_t>(i);
    facts.properties.pipelineCacheUUID[i] = static_cast<std::uint8_t>(100 + i);
  }
  return facts;
}

std::vector<std::byte> some_data(std::size_t size) {
  std::vector<std::byte> data(size);
  for (std::size_t i = 0; i < size; ++i) data[i] = static_cast<std::byte>(i * 7);
  return data;
}

std::string read(const std::string& path) {
  std::ifstream stream(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

void write(const std::string& path, const std::string& bytes) { std::ofstream(path, std::ios::binary) << bytes; }

std::size_t files_in(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), fs::directory_iterator()));
}

TEST_CASE("pipelines are read back unchanged, by the same device and driver only") {
  const TempFolder folder;
  const DeviceFacts facts = some_facts();
  const std::string path = pipeline_cache_path(folder.file("new/folder"), facts);
  CHECK(read_pipeline_cache(path, facts).empty());
  must(write_pipeline_cache(path, facts, some_data(1000)));
  CHECK(read_pipeline_cache(path, facts) == some_data(1000));
  must(write_pipeline_cache(path, facts, some_data(70)));
  CHECK(read_pipeline_cache(path, facts) == some_data(70));
  CHECK(files_in(folder.file("new/folder")) == 1);  // replaced, without a temporary file

  DeviceFacts other = facts;
  other.properties.driverVersion = 0x1235;
  CHECK(pipeline_cache_path("/a", other) != pipeline_cache_path("/a", facts));
  CHECK(read_pipeline_cache(path, other).empty());
  other = facts;
  other.id.deviceUUID[3] ^= 1;
  CHECK(pipeline_cache_path("/a", other) != pipeline_cache_path("/a", facts));
  CHECK(read_pipeline_cache(path, other).empty());
  other = facts;
  other.properties.pipelineCacheUUID[15] ^= 1;
  CHECK(read_pipeline_cache(path, other).empty());
}

TEST_CASE("a file with a flipped bit, a truncated file and a longer file are ignored") {
  const TempFolder folder;
  const DeviceFacts facts = some_facts();
  const std::string path = folder.file("a.bin");
  must(write_pipeline_cache(path, facts, some_data(40)));
  const std::string whole = read(path);
  for (std::size_t i = 0; i < whole.size(); ++i) {
    std::string damaged = whole;
    damaged[i] = static_cast<char>(damaged[i] ^ (1 << i % 8));
    write(path, damaged);
    CHECK_MESSAGE(read_pipeline_cache(path, facts).empty(), i);
    write(path, whole.substr(0, i));
    CHECK_MESSAGE(read_pipeline_cache(path, facts).empty(), i);
  }
  write(path, whole + "x");
  CHECK(read_pipeline_cache(path, facts).empty());
  write(path, whole);
  CHECK(read_pipeline_cache(path, facts) == some_data(40));
  CHECK(read_pipeline_cache(folder.path().string(), facts).empty());
}

TEST_CASE("a folder that cannot be created is an error that names the setting without a cache") {
  const TempFolder folder;
  write(folder.file("file"), "");
  const Status status = write_pipeline_cache(folder.file("file") + "/a.bin", some_facts(), some_data(1));
  REQUIRE(!status);
  CHECK((status.error().message.find("FOOTLIGHT_PIPELINE_CACHE=off") != std::string::npos));
}

TEST_CASE("a device writes its pipelines to the folder, and another one reads them or works without them") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const DeviceOptions options{
      .validation = true, .name_contains = vulkan.device().name(), .cache_folder = folder.file("cache")};
  const std::string path = pipeline_cache_path(options.cache_folder, vulkan.device().facts());
  const Spirv tonemap = pass_shaders().back().pipelines.at(0).at(0);
  const auto compile = [&] {
    const auto device = must(Device::create(options));
    CHECK(device->pipelines().compute(tonemap, {}));
    CHECK(device->validation_messages().empty());
  };
  { const auto unused = must(Device::create(options)); }
  CHECK(!fs::exists(path));  // nothing was compiled
  compile();
  CHECK(!read_pipeline_cache(path, vulkan.device().facts()).empty());
  compile();
  write(path, "damaged");
  compile();
  CHECK(!read_pipeline_cache(path, vulkan.device().facts()).empty());  // written again
  CHECK(files_in(options.cache_folder) == 1);
}

}  // namespace
}  // namespace footlight::render::vk
