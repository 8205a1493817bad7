// Sound on the command line: the same levels each time, checks, the texture, and messages.
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "fixtures/gobos/png.h"
#include "sim/dmx_log/dmx_log.h"
#include "tests/sim/sound/tones.h"
#include "tests/support/must.h"
#include "tests/support/wav_bytes.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// Two seconds of a tone in the bass, silent for the first half second.
std::string write_tone(const TempFolder& folder) {
  std::vector<float> samples = sine(100, 2, 16'000, 0.7);
  std::fill(samples.begin(), samples.begin() + 8'000, 0.0F);
  return folder.write("tone.wav", wav_bytes(samples, 16'000, 1));
}

constexpr const char* kMap = R"(sound = "tone.wav"
rig = "rig.toml"
[[channel]]
signal = "bass"
address = 100
[[light]]
fixture = "Spot"
band = "bass"
smooth = false
)";
constexpr const char* kRig = R"([rig]
name = "One"

[[fixture]]
name = "Spot"
type = "vrsl/spot"
universe = 1
address = 1
position = [0, 0, 5]
)";

TEST_CASE("a sound map converts to the same log each time, and lights its fixture while the tone lasts") {
  const TempFolder folder;
  write_tone(folder);
  const std::string map = folder.write("map.toml", kMap);
  folder.write("rig.toml", kRig);
  for (const char* out : {"a.dmxlog", "b.dmxlog"}) {
    const Outcome outcome = footlight({"log", "convert", map, folder.file(out)});
    CHECK_MESSAGE(outcome.exit_code == 0, outcome.err);
  }
  CHECK(bytes_of(folder.file("a.dmxlog")) == bytes_of(folder.file("b.dmxlog")));
  const Outcome info = footlight({"log", "info", map, "--json"});
  const auto json = nlohmann::json::parse(info.out);
  CHECK(json["format"] == "sound");
  CHECK(json["frames"] == 181);
  const Outcome trace = footlight({"trace", folder.file("rig.toml"), "--log", map, "--every", "250ms"});
  REQUIRE_MESSAGE(trace.exit_code == 0, trace.err);
  // The column light is 0 while it is silent, and above 0 at 1 s.
  std::istringstream lines(trace.out);
  std::string line;
  int silent = 0;
  int lit = 0;
  while (std::getline(lines, line)) {
    std::vector<std::string> cells;
    std::istringstream row(line);
    for (std::string cell; std::getline(row, cell, ',');) cells.push_back(cell);
    if (cells[0] == "0.25" || cells[0] == "0.5") silent += std::stod(cells[7]) == 0;
    if (cells[0] == "1" || cells[0] == "1.5") lit += std::stod(cells[7]) > 0;
  }
  CHECK(silent == 2);
  CHECK(lit == 2);
}

TEST_CASE("a sound plays as an input of a bridge, on five slots") {
  const TempFolder folder;
  const std::string tone = write_tone(folder);
  const std::string log = folder.file("out.dmxlog");
  const Outcome outcome =
      footlight({"run", "--in", "audio:" + tone + "=4.25", "--out", "log:" + log, "--for", "1200ms"});
  REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.err);
  const LogReader reader = must(LogReader::open(log));
  REQUIRE(reader.info().universes.size() == 1);
  CHECK(reader.info().universes[0].universe == 4);
}

TEST_CASE("audio check prints what is in a sound") {
  const TempFolder folder;
  std::vector<float> samples = clicks(120, 8, 8'000);
  for (std::size_t i = 50'000; i < 50'050; ++i) samples[i] = 1;
  samples[60'000] = std::nanf("");
  samples.insert(samples.begin(), 8'000, 0.0F);
  const std::string path = folder.write("a.wav", wav_bytes(samples, 8'000, 1, WavForm::kFloat));
  const Outcome outcome = footlight({"audio", "check", path, "--json"});
  REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.err);
  const auto json = nlohmann::json::parse(outcome.out);
  CHECK(json["rate_hz"] == 8'000);
  CHECK(json["channels"] == 1);
  CHECK(json["duration_s"] == doctest::Approx(9));
  CHECK(json["peak_db"] == doctest::Approx(0).epsilon(1e-3));
  CHECK(json["clipped_samples"] == 50);
  CHECK(json["not_finite_samples"] == 1);
  CHECK(json["bpm"] == doctest::Approx(120).epsilon(0.01));
  CHECK(json["silent_start_s"] == doctest::Approx(1).epsilon(0.02));
  CHECK(json["bands"].size() == 4);
  CHECK(contains(json["advice"].dump(), "The sound is clipped"));
}

TEST_CASE("the texture has AudioLink's size, its bands in rows 0 to 3 and 0 in what is not filled") {
  const TempFolder folder;
  const std::string tone = write_tone(folder);
  const std::string out = folder.file("t.png");
  const Outcome outcome = footlight({"audio", "texture", tone, "--at", "1s", "-o", out});
  REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.err);
  const std::string bytes = bytes_of(out);
  const auto pixels = fixtures::rgba_of(128, 64, std::as_bytes(std::span(bytes)));
  REQUIRE(pixels.size() == 128U * 64 * 4);
  const auto red = [&](std::size_t x, std::size_t y) { return int{pixels[(y * 128 + x) * 4]}; };
  CHECK(red(0, 0) > 0);                                        // the tone is in the bass
  CHECK(red(60, 0) == 0);                                      // two thirds of a second ago it was silent
  CHECK(red(0, 28) > 0);                                       // filtered
  CHECK(red(0, 32) > 0);                                       // the history of levels
  CHECK(red(127, 32) == 0);                                    // 1.4 s ago
  for (std::size_t y = 6; y < 22; ++y) CHECK(red(5, y) == 0);  // the waveform is not filled
  CHECK(footlight({"audio", "texture", tone, "--every", "500ms", "-o", folder.file("t_%04d.png")}).exit_code == 0);
  CHECK(std::filesystem::exists(folder.file("t_0004.png")));
  CHECK_FALSE(std::filesystem::exists(folder.file("t_0005.png")));
}

#ifdef FOOTLIGHT_HAVE_ALSA
// ALSA's own file plugin is the device: no hardware, and the real library.
TEST_CASE("an ALSA device plays into a log, and an unknown one is reported") {
  const TempFolder folder;
  std::string raw;
  for (const float sample : sine(100, 3, 96'000, 0.7)) put_bytes(raw, std::bit_cast<std::uint32_t>(sample), 4);
  const std::string config =
      folder.write("asound.conf", "pcm.tone {\n type file\n slave.pcm { type null }\n file /dev/null\n infile \"" +
                                      folder.write("tone.raw", raw) + "\"\n format raw\n}\n");
  const std::string log = folder.file("out.dmxlog");
  Footlight live({"run", "--in", "audio:alsa:tone=1.1", "--out", "log:" + log, "--for", "700ms"},
                 {{"ALSA_CONFIG_PATH", config}});
  const Outcome outcome = live.wait();
  REQUIRE_MESSAGE(outcome.exit_code == 0, outcome.err);
  const LogReader reader = must(LogReader::open(log));
  REQUIRE(reader.info().universes.size() == 1);
  CHECK(reader.info().universes[0].frames > 20);
  CHECK(reader.info().universes[0].changes > 1);
  Footlight unknown({"run", "--in", "audio:alsa:nosuch=1.1", "--out", "log:" + log, "--for", "1s"},
                    {{"ALSA_CONFIG_PATH", config}});
  const Outcome refused = unknown.wait();
  CHECK(refused.exit_code == 3);
  CHECK(contains(refused.err, "alsa:nosuch"));
  CHECK(contains(refused.err, "arecord -L"));
}
#endif

struct Running {
  bool alsa = false;
  bool libav = false;
  int threads = 0;
};

// A bridge with a GPIO model and these arguments, once it runs.
Running running_with(const std::vector<std::string>& more) {
  const TempFolder folder;
  std::vector<std::string> arguments = {
      "run", "--in", "gpio:mock/2=1.1", "--out", "log:" + folder.file("o.dmxlog"), "--json", "--for", "30s"};
  arguments.insert(arguments.end(), more.begin(), more.end());
  Footlight bridge(arguments, {{"XDG_RUNTIME_DIR", folder.file("")}});
  bridge.wait_for(R"("event":"ready")");
  Running found;
  const std::string process = "/proc/" + std::to_string(bridge.pid());
  const std::string maps = bytes_of(process + "/maps");
  CHECK(contains(maps, "libc.so"));
  found.alsa = contains(maps, "libasound");
  found.libav = contains(maps, "libavcodec") || contains(maps, "libavformat") || contains(maps, "libswscale");
  const std::filesystem::directory_iterator tasks(process + "/task");
  found.threads = static_cast<int>(std::distance(begin(tasks), end(tasks)));
  bridge.signal(SIGTERM);
  bridge.wait();
  return found;
}

TEST_CASE("a bridge loads no library and has no thread for sound and video unless an endpoint needs them") {
  const TempFolder folder;
  const std::string tone = write_tone(folder);
  const Running plain = running_with({});
  CHECK_FALSE(plain.alsa);
  CHECK_FALSE(plain.libav);
  const Running device = running_with({"--in", "audio:mock=1.10"});
  CHECK(device.threads == plain.threads + 1);
  CHECK_FALSE(device.alsa);
  CHECK_FALSE(device.libav);
  const Running file = running_with({"--in", "audio:" + tone + "=1.10"});
  CHECK(file.threads == plain.threads);
  CHECK(file.libav);
  CHECK_FALSE(file.alsa);
  const Running picture = running_with({"--out", "vrsl:1@" + folder.file("p.png")});
  CHECK(picture.threads == plain.threads + 1);
  CHECK_FALSE(picture.libav);
}

TEST_CASE("wrong arguments of sound are reported with the next step") {
  const TempFolder folder;
  const std::string tone = write_tone(folder);
  const std::string text = folder.write("text.wav", "no sound");
  const std::string device =
      folder.write("live.toml", "sound = \"alsa\"\n[[channel]]\nsignal = \"bass\"\naddress = 1\n");
  struct Wrong {
    std::vector<std::string> arguments;
    int exit_code;
    std::vector<std::string> named;
  };
  for (const Wrong& wrong : std::vector<Wrong>{
           {{"audio", "check"}, 2, {"audio check", "track.flac"}},
           {{"audio", "check", folder.file("no.wav")}, 3, {"no.wav", "no such file"}},
           {{"audio", "check", text}, 2, {"text.wav", "sound file"}},
           {{"audio", "check", device}, 2, {"alsa", "device"}},
           {{"audio", "texture", tone, "-o", "x.png"}, 2, {"--at", "--every"}},
           {{"audio", "texture", tone, "--at", "9s", "-o", folder.file("x.png")}, 2, {"--at", "2.00 s"}},
           {{"audio", "texture", tone, "--at", "1s", "-o", "x.jpg"}, 2, {".png"}},
           {{"audio", "texture", tone, "--every", "1s", "-o", "x.png"}, 2, {"%04d"}},
           {{"log", "convert", device, folder.file("x.dmxlog")}, 2, {"alsa", "record"}},
           {{"run", "--in", "audio:" + tone, "--out", "mock:enttec-pro"}, 2, {"=1.25"}},
           {{"run", "--in", "mock:enttec-pro", "--out", "audio:" + tone + "=1.1"}, 2, {"input", "--in"}},
       }) {
    const Outcome outcome = footlight(wrong.arguments);
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == wrong.exit_code);
    for (const std::string& part : wrong.named) CHECK(contains(outcome.err, part));
  }
}

}  // namespace
}  // namespace footlight::testing
