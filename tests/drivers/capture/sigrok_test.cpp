#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <map>

#include <doctest/doctest.h>

#include "drivers/capture/captures.h"
#include "drivers/capture/sigrok_file.h"
#include "tests/drivers/capture/line_signal.h"
#include "tests/drivers/capture/zip_writer.h"
#include "tests/sim/dmx_log/support.h"

namespace footlight::drivers {
namespace {

using footlight::testing::LineSignal;
using footlight::testing::TempFolder;
using footlight::testing::ZipWriter;

std::string metadata_text(const std::string& rate, const std::string& more = "unitsize=1\n") {
  return "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes=8\nsamplerate=" + rate +
         "\ntotal analog=0\nprobe1=D0\nprobe3=DMX+\nprobe4=DMX-\n" + more;
}

// Three frames on probe 3, the same inverted on probe 4, noise on probe 1.
std::vector<std::uint8_t> three_frames(std::size_t slots = 24) {
  LineSignal signal(1'000'000);
  signal.mark(1e5);
  for (int i = 0; i < 3; ++i) {
    std::vector<std::uint8_t> bytes(1 + slots, static_cast<std::uint8_t>(i + 1));
    bytes[0] = 0;
    signal.frame(bytes);
    signal.mark(5e5);
  }
  signal.mark(2e6);
  std::vector<std::uint8_t> samples;
  for (const std::uint8_t level : signal.samples()) {
    samples.push_back(static_cast<std::uint8_t>((level != 0 ? 4 : 8) | (samples.size() / 3 & 1)));
  }
  return samples;
}

std::string write_capture(const TempFolder& folder, const std::string& name, const ZipWriter& zip) {
  const auto bytes = zip.finish();
  testing::write_bytes(folder.file(name), std::string(bytes.begin(), bytes.end()));
  return folder.file(name);
}

std::string error_of(const std::string& path, const CaptureOptions& options = {}) {
  const auto input = open_any_log(path, options);
  return input ? "" : input.error().message;
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("a capture in one file or in many, divided inside frames, gives the frames of the line as a log") {
  const TempFolder folder;
  const auto samples = three_frames();
  for (const std::size_t piece : {samples.size(), std::size_t{1'000}, std::size_t{777}}) {
    ZipWriter zip;
    zip.add("version", "2");
    zip.add("metadata", metadata_text("1 MHz"));
    if (piece == samples.size()) {
      zip.add("logic-1", samples);
    } else {
      for (std::size_t at = 0, number = 1; at < samples.size(); at += piece, ++number) {
        zip.add("logic-1-" + std::to_string(number),
                std::span(samples).subspan(at, std::min(piece, samples.size() - at)));
      }
    }
    CaptureOptions options;
    options.universe = 7;
    auto reader = read_any_log(write_capture(folder, "a.sr", zip), options);
    REQUIRE_MESSAGE(reader, reader.error().message);
    const auto frames = testing::all_frames(*reader);
    REQUIRE(frames.size() == 3);
    CHECK(frames[2].universe == 7);
    CHECK(frames[2].slots == std::vector<std::uint8_t>(24, 3));
    // 0.1 ms rest, then 0.1 ms break, 12 us mark and 25 slots of 44 us: the time when the frame was complete.
    CHECK(std::abs(frames[0].time_ns - 1'312'000) <= 2'000);
    CHECK(reader->info().duration_ns == static_cast<DurationNs>(samples.size()) * 1'000);
  }
}

TEST_CASE("the channel with the levels is found, a selected one is used, by name or number, as it is or inverted") {
  const TempFolder folder;
  ZipWriter zip;
  zip.add("metadata", metadata_text("1 MHz"));
  zip.add("logic-1-1", three_frames());
  const std::string path = write_capture(folder, "a.sr", zip);
  const auto frames_of = [&](const std::string& channel, bool inverted) {
    CaptureOptions options;
    options.channel = channel;
    options.inverted = inverted;
    const auto info = read_line_timing(path, options);
    REQUIRE_MESSAGE(info, info.error().message);
    const bool levels = std::all_of(info->frames.begin(), info->frames.end(), [](const LineFrameTiming& frame) {
      return frame.start_code == 0 && frame.fault == LineFault::kNone;
    });
    return levels ? info->frames.size() : 0;
  };
  CHECK(frames_of("", false) == 3);
  CHECK(read_line_timing(path)->channel == "DMX+");
  CHECK(frames_of("DMX+", false) == 3);
  CHECK(frames_of("3", false) == 3);
  CHECK(frames_of("DMX-", true) == 3);
  CHECK(frames_of("DMX-", false) != 3);
  CaptureOptions options;
  options.channel = "DMX";
  CHECK(contains(error_of(path, options), "has no channel 'DMX'; it has 1 (D0), 3 (DMX+), 4 (DMX-)"));
}

TEST_CASE("the error for an invalid capture names the problem") {
  const TempFolder folder;
  const auto samples = three_frames();
  const auto capture = [&](const std::string& text) {
    ZipWriter zip;
    zip.add("metadata", text);
    zip.add("logic-1-1", samples);
    return error_of(write_capture(folder, "a.sr", zip));
  };
  CHECK(capture(metadata_text("1 MHz")).empty());
  CHECK(contains(capture(metadata_text("1 mHz")), "samplerate: expected a rate as in '1 MHz', got '1 mHz'"));
  CHECK(contains(capture(metadata_text("100 kHz")), "100000 Hz: expected a sample rate from 500000 Hz"));
  CHECK(contains(capture(metadata_text("1 MHz", "unitsize=9\n")), "unitsize: expected 1 to 8 bytes, got '9'"));
  CHECK(contains(capture(metadata_text("1 MHz", "probe12=X\nunitsize=1\n")), "12 probes do not fit a unitsize of 1"));
  CHECK(contains(capture("[global]\nsigrok version=0.5\n[device 1]\nsamplerate=1 MHz\n"), "no logic samples"));
  CHECK(contains(capture(metadata_text("1 MHz") + std::string(70'000, '#')), "longer than 65536 bytes"));
  {
    ZipWriter zip;
    zip.add("something", "else");
    CHECK(contains(error_of(write_capture(folder, "a.sr", zip)), "a zip without 'metadata'"));
  }
  {
    ZipWriter zip;
    zip.add("metadata", metadata_text("1 MHz"));
    CHECK(contains(error_of(write_capture(folder, "a.sr", zip)), "neither 'logic-1' nor 'logic-1-1' is in it"));
  }
  {
    ZipWriter zip;
    zip.add("metadata", metadata_text("1 MHz"));
    zip.add("logic-1-1", std::string(5'000, '\x04'));
    CHECK(contains(error_of(write_capture(folder, "a.sr", zip)), "no DMX frame in the first 2 s of any channel"));
  }
  testing::write_bytes(folder.file("b.sr"), "PK\x03\x04 and no more");
  CHECK(contains(error_of(folder.file("b.sr")), "not a sigrok capture"));
}

TEST_CASE("truncated samples are read up to their end, which is reported") {
  const TempFolder folder;
  const auto samples = three_frames();
  ZipWriter zip;
  zip.add("metadata", metadata_text("1 MHz"));
  zip.add("logic-1-1", samples);
  auto bytes = zip.finish();
  // A flipped bit near the end of the samples: their checksum no longer matches.
  const auto found = std::search(bytes.begin(), bytes.end(), samples.begin(), samples.end());
  REQUIRE(found != bytes.end());
  found[static_cast<std::ptrdiff_t>(samples.size()) - 10] ^= 0x80;
  testing::write_bytes(folder.file("a.sr"), std::string(bytes.begin(), bytes.end()));
  auto input = open_any_log(folder.file("a.sr"));
  REQUIRE_MESSAGE(input, input.error().message);
  FrameView frame;
  int frames = 0;
  while (*(*input)->next(frame)) ++frames;
  CHECK(frames == 3);
  CHECK((*input)->damage_count() == 1);
  CHECK(contains((*input)->notes().back(), "ends early"));
}

TEST_CASE("captures of real devices decode with the timing measured on each device") {
  const char* data = std::getenv("FOOTLIGHT_TEST_DATA");
  if (data == nullptr) {
    MESSAGE("skipped: FOOTLIGHT_TEST_DATA is not set");
    return;
  }
  struct Range {
    double low_us;
    double high_us;
  };
  struct Device {
    Range break_range;
    Range mab;
    int slots;
    Range period;  // 0: the capture has one frame
  };
  // Measured on the same captures by another decoder; periods to 10 us.
  const std::map<std::string, Device> devices = {
      {"dmx4all_mini_usb_dmx", {{96, 100}, {20, 23}, 0, {0, 0}}},
      {"ma_lighting", {{185, 202}, {11, 20}, 512, {33'045, 33'655}}},
      {"nicolaudie", {{179, 184}, {20, 24}, 512, {25'815, 25'925}}},
      {"sgm", {{308, 308}, {4, 5}, 256, {32'745, 32'785}}},
      {"u_dmx", {{50, 170}, {19, 160}, 512, {23'000, 24'400}}},
  };
  int files = 0;
  for (const auto& entry :
       std::filesystem::recursive_directory_iterator(std::string(data) + "/dmx/sigrok-dumps-dmx512")) {
    if (entry.path().extension() != ".sr") continue;
    CAPTURE(entry.path().string());
    ++files;
    const auto info = read_line_timing(entry.path().string());
    REQUIRE_MESSAGE(info, info.error().message);
    CHECK(info->counters.rejected == 0);
    CHECK(info->counters.glitches == 0);
    const auto device = devices.find(entry.path().parent_path().filename().string());
    REQUIRE(device != devices.end());
    const auto in = [](DurationNs value_ns, const Range& range) {
      return static_cast<double>(value_ns) >= range.low_us * 1e3 &&
             static_cast<double>(value_ns) <= range.high_us * 1e3;
    };
    int short_breaks = 0;
    for (const LineFrameTiming& frame : info->frames) {
      CHECK(frame.start_code == 0);
      CHECK(in(frame.break_ns, device->second.break_range));
      CHECK(in(frame.mab_ns, device->second.mab));
      if (!frame.unfinished) CHECK(frame.slot_count == device->second.slots);
      if (frame.period_ns != 0) CHECK(in(frame.period_ns, device->second.period));
      if (in(frame.break_ns, {50, 57})) ++short_breaks;
    }
    if (device->first == "u_dmx") CHECK(short_breaks * 10 >= static_cast<int>(info->frames.size()) * 7);
    CHECK(info->frames.size() >= (device->second.slots == 0 ? 1u : 29u));
  }
  CHECK(files >= 14);
}

}  // namespace footlight::drivers
