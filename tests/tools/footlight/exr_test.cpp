// OpenEXR files, read back with the OpenEXR library: the light of the renderer, and the header.
#include <cerrno>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <string>
#include <vector>

#include <sys/resource.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <doctest/doctest.h>

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wconversion"
#pragma GCC diagnostic ignored "-Wsign-conversion"
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

#include "render/frame.h"
#include "tests/support/headless_vulkan.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/pictures/exr_file.h"
#include "tools/footlight/pictures/frame_options.h"
#include "tools/footlight/pictures/picture_file.h"
#include "tools/footlight/pictures/timeline.h"

namespace footlight::testing {
namespace {

using tools::ExrHeader;

const std::map<std::string, std::string> kNoLeaks = {{"ASAN_OPTIONS", "detect_leaks=0"}};

render::RadianceImage read_exr(const std::string& path, Imf::Header& header) {
  Imf::InputFile file(path.c_str());
  header = file.header();
  const auto window = header.dataWindow();
  render::RadianceImage image{window.max.x - window.min.x + 1, window.max.y - window.min.y + 1, {}};
  image.rgb.resize(static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height) * 3);
  Imf::FrameBuffer buffer;
  std::size_t offset = 0;
  for (const char* name : {"R", "G", "B"}) {
    const Imf::Channel* channel = header.channels().findChannel(name);
    REQUIRE(channel != nullptr);
    CHECK(channel->type == Imf::FLOAT);
    buffer.insert(name, Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(image.rgb.data()) + offset, 3 * sizeof(float),
                                   3 * sizeof(float) * static_cast<std::size_t>(image.width)));
    offset += sizeof(float);
  }
  file.setFrameBuffer(buffer);
  file.readPixels(window.min.y, window.max.y);
  return image;
}

bool equal_bits(const std::vector<float>& a, const std::vector<float>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(float)) == 0;
}

double number_of(const Imf::Header& header, const char* name) {
  return header.typedAttribute<Imf::DoubleAttribute>(name).value();
}

TEST_CASE("every float comes back from an OpenEXR file bit for bit, with units, colours and times in its header") {
  const TempFolder folder;
  render::RadianceImage image{37, 19, {}};
  std::uint32_t bits = 12345;
  for (int i = 0; i < 37 * 19 * 3; ++i) {
    bits = bits * 1664525u + 1013904223u;
    float value = 0;
    std::memcpy(&value, &bits, sizeof(value));  // every kind of float: tiny, huge, negative, NaN
    image.rgb.push_back(value);
  }
  image.rgb[0] = std::numeric_limits<float>::denorm_min();
  image.rgb[1] = std::numeric_limits<float>::infinity();
  image.rgb[2] = -0.0f;
  const std::string path = folder.file("a.exr");
  REQUIRE(tools::write_exr(path, image,
                           {.exposure_ev = 4.5,
                            .time_ns = 12'520'000'000,
                            .shutter_ns = 20'000'000,
                            .frame_ns = 40'000'000,
                            .settings = R"({"nodes":3})"}));
  CHECK(!std::filesystem::exists(path + ".part"));
  Imf::Header header;
  const render::RadianceImage back = read_exr(path, header);
  CHECK(back.width == 37);
  CHECK(back.height == 19);
  CHECK(equal_bits(back.rgb, image.rgb));

  CHECK(header.compression() == Imf::ZIP_COMPRESSION);
  REQUIRE(Imf::hasWhiteLuminance(header));
  CHECK(Imf::whiteLuminance(header) == 1.0f);
  const Imf::Chromaticities& rgb = Imf::chromaticities(header);  // Rec. ITU-R BT.709, table 1
  CHECK(rgb.red == Imath::V2f(0.64f, 0.33f));
  CHECK(rgb.green == Imath::V2f(0.30f, 0.60f));
  CHECK(rgb.blue == Imath::V2f(0.15f, 0.06f));
  CHECK(rgb.white == Imath::V2f(0.3127f, 0.3290f));
  CHECK(Imf::expTime(header) == 0.02f);
  CHECK(Imf::framesPerSecond(header) == 25.0);
  CHECK(header.typedAttribute<Imf::StringAttribute>("footlight/units").value() == "cd/m^2");
  CHECK(header.typedAttribute<Imf::StringAttribute>("footlight/settings").value() == R"({"nodes":3})");
  CHECK(number_of(header, "footlight/exposureEv") == 4.5);
  CHECK(number_of(header, "footlight/timeS") == doctest::Approx(12.52).epsilon(1e-15));

  REQUIRE(tools::write_exr(path, image, {.frame_ns = 0}));
  read_exr(path, header);
  CHECK(!Imf::hasFramesPerSecond(header));
}

TEST_CASE("a picture that cannot be written is reported with its name and the reason, and no partial file is left") {
  const TempFolder folder;
  const render::RadianceImage light{64, 64, std::vector<float>(64 * 64 * 3, 0.3f)};
  const render::ScreenImage screen = render::screen_of(light, 0);
  const std::string missing = folder.file("missing/a.exr");
  const Status nowhere = tools::write_exr(missing, light, {});
  REQUIRE(!nowhere);
  CHECK(nowhere.error().code == ErrorCode::kIo);
  CHECK(nowhere.error().message.find(missing) == 0);
  CHECK(nowhere.error().message.find("folder") != std::string::npos);
  CHECK(!tools::write_exr("/dev/null", light, {}));

  // As on a full disk: no file may be longer than 64 bytes.
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto old_action = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = before;
  tight.rlim_cur = 64;
  REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
  const std::string exr = folder.file("a.exr");
  const std::string png = folder.file("a.png");
  const Status full_exr = tools::write_exr(exr, light, {});
  const Status full_png = tools::write_png(png, screen);
  REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
  std::signal(SIGXFSZ, old_action);
  for (const auto& [path, status] : {std::pair(exr, full_exr), std::pair(png, full_png)}) {
    REQUIRE(!status);
    CHECK(status.error().code == ErrorCode::kIo);
    CHECK(status.error().message.find(path) == 0);
    CHECK(status.error().message.find(std::strerror(EFBIG)) != std::string::npos);
    CHECK(status.error().message.find("disk full") != std::string::npos);
    CHECK(!std::filesystem::exists(path));
    CHECK(!std::filesystem::exists(path + ".part"));
  }
}

TEST_CASE("--shadows chooses exact cuts or maps of so many texels, and refuses other words with what is expected") {
  render::FrameSettings settings;
  REQUIRE(tools::take_shadows("on", settings));
  CHECK(settings.shadows);
  CHECK(settings.shadow_map_px == render::kShadowsSuited);
  REQUIRE(tools::take_shadows("exact", settings));
  CHECK(settings.shadow_map_px == 0);
  REQUIRE(tools::take_shadows("maps", settings));
  CHECK(settings.shadow_map_px == 64);
  REQUIRE(tools::take_shadows("maps:256", settings));
  CHECK(settings.shadow_map_px == 256);
  REQUIRE(tools::take_shadows("off", settings));
  CHECK(!settings.shadows);
  for (const char* word : {"", "On", "maps:", "maps:48", "maps:512", "maps:64x"}) {
    const Status refused = tools::take_shadows(word, settings);
    REQUIRE(!refused);
    CHECK(refused.error().message.find(std::string("--shadows ") + word + ": expected on, off, exact, maps") == 0);
  }
}

TEST_CASE("--penumbra is 1, 4 or 7 points of a lens, and refused where shadow maps were chosen") {
  render::FrameSettings settings;
  for (const char* word : {"1", "4", "7"}) {
    REQUIRE(tools::take_penumbra(word, settings));
    CHECK(settings.penumbra == static_cast<std::uint32_t>(word[0] - '0'));
  }
  for (const char* word : {"", "0", "2", "44", "on"}) {
    const Status refused = tools::take_penumbra(word, settings);
    REQUIRE(!refused);
    CHECK(refused.error().message == std::string("--penumbra ") + word + ": expected 1, 4 or 7");
  }
  REQUIRE(tools::take_shadows("maps", settings));
  CHECK(tools::take_penumbra("1", settings));
  const Status refused = tools::take_penumbra("4", settings);
  REQUIRE(!refused);
  CHECK(refused.error().message == "--penumbra 4: shadow maps have hard edges; use --shadows exact");
}

TEST_CASE("a rendered OpenEXR file is the frame's radiance bit for bit, and its tone map is the PNG within one count") {
  const HeadlessVulkan vulkan;
  if (!vulkan) return;
  const TempFolder folder;
  const auto rendered = [&](const std::string& name, const std::vector<std::string>& more) {
    std::vector<std::string> words = {"render", "--demo", "--size", "48x28", "--glare", "off", "-o", folder.file(name)};
    words.insert(words.end(), more.begin(), more.end());
    const Outcome outcome = Footlight(words, kNoLeaks).wait();
    INFO(outcome.err);
    REQUIRE(outcome.exit_code == 0);
  };
  rendered("a.exr", {"--at", "18s"});
  Imf::Header header;
  const render::RadianceImage file = read_exr(folder.file("a.exr"), header);

  fixtures::Rig rig = fixtures::demo_rig();
  const auto bytes = demo::demo_log_bytes();
  auto log = LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show");
  REQUIRE(log);
  auto driven = tools::compile_driven(rig, std::move(*log));
  REQUIRE(driven);
  render::FrameSettings settings;
  settings.width = 48;
  settings.height = 28;
  settings.edge_samples = render::suited_edge_samples(vulkan.device());
  settings.bounce = true;
  auto frame = render::Frame::create(vulkan.device(), rig, driven->compiled, settings);
  REQUIRE(frame);
  REQUIRE(driven->timeline->advance(18 * kNsPerS, 20 * kNsPerMs,
                                    [&](std::span<const std::uint8_t> levels, std::int64_t dt_ns, bool new_exposure) {
                                      (*frame)->step(levels, dt_ns, new_exposure);
                                      if ((*frame)->pending_steps() >= 512) REQUIRE((*frame)->run_steps());
                                    }));
  const fixtures::Camera& camera = rig.cameras.front();
  REQUIRE((*frame)->draw(render::view_of(camera), camera.exposure_ev));
  const auto radiance = (*frame)->read_radiance();
  REQUIRE(radiance);
  CHECK(equal_bits(file.rgb, radiance->rgb));
  CHECK(*std::max_element(file.rgb.begin(), file.rgb.end()) > 1);
  CHECK(number_of(header, "footlight/exposureEv") == camera.exposure_ev);
  CHECK(number_of(header, "footlight/timeS") == 18);
  CHECK(Imf::expTime(header) == 0.02f);

  const std::vector<std::string> other = {"--at", "18s", "--ev", "2", "--supersample", "2"};
  rendered("a.png", {"--at", "18s"});
  rendered("b.exr", other);
  rendered("b.png", other);
  for (const std::string name : {"a", "b"}) {
    const render::RadianceImage light = read_exr(folder.file(name + ".exr"), header);
    int width = 0, height = 0, channels = 0;
    stbi_uc* png = stbi_load(folder.file(name + ".png").c_str(), &width, &height, &channels, 4);
    REQUIRE(png != nullptr);
    REQUIRE(width == light.width);
    REQUIRE(height == light.height);
    const render::ScreenImage shown = render::screen_of(light, number_of(header, "footlight/exposureEv"));
    int worst = 0;
    for (std::size_t i = 0; i < shown.rgba.size(); ++i) worst = std::max(worst, std::abs(shown.rgba[i] - png[i]));
    stbi_image_free(png);
    CHECK(worst <= 1);
  }

  // Sequences, as of PNG.
  rendered("p_%02d.exr", {"--every", "200ms", "--from", "1s", "--until", "1.4s"});
  CHECK(std::filesystem::exists(folder.file("p_02.exr")));
  CHECK(!std::filesystem::exists(folder.file("p_03.exr")));
  read_exr(folder.file("p_01.exr"), header);
  CHECK(number_of(header, "footlight/timeS") == doctest::Approx(1.2).epsilon(1e-15));
  CHECK(Imf::expTime(header) == 0.2f);
  CHECK(Imf::framesPerSecond(header) == 5.0);
  const Outcome limited =
      Footlight({"render", "--demo", "--every", "20ms", "--flashes", "limit", "-o", folder.file("l_%d.exr")}, kNoLeaks)
          .wait();
  CHECK(limited.exit_code == 2);
  CHECK(limited.err.find("--flashes limit") != std::string::npos);
}

}  // namespace
}  // namespace footlight::testing
