#include <algorithm>
#include <cstdio>
#include <functional>

#include "sim/dmx_log/ola_show.h"
#include "tests/sim/dmx_log/patterns.h"
#include "tests/sim/dmx_log/support.h"

using namespace footlight;
using namespace footlight::testing;

namespace {

std::string slurp(const std::string& path) {
  const auto bytes = read_bytes(path);
  return {bytes.begin(), bytes.end()};
}

std::vector<OlaShowFrame> read_show(const std::string& path, DurationNs* end_ns = nullptr) {
  auto show = OlaShowReader::open(path);
  REQUIRE_MESSAGE(show, show.error().message);
  std::vector<OlaShowFrame> frames;
  OlaShowFrame frame;
  while (true) {
    const auto any = show->next(frame);
    REQUIRE_MESSAGE(any, any.error().message);
    if (!*any) break;
    frames.push_back(frame);
  }
  if (end_ns != nullptr) *end_ns = show->time_ns();
  return frames;
}

std::string error_of(const std::string& text, int universe_offset = 0) {
  const TempFolder folder;
  const std::string path = folder.file("bad.show");
  write_bytes(path, text);
  auto show = OlaShowReader::open(path, universe_offset);
  Error error{ErrorCode::kBadInput, ""};
  if (show) {
    OlaShowFrame frame;
    Result<bool> any = true;
    while (any && *any) any = show->next(frame);
    if (any) return "";
    error = any.error();
  } else {
    error = show.error();
  }
  CHECK(error.code == ErrorCode::kBadInput);
  CHECK(error.message.find("bad.show") != std::string::npos);
  return error.message.substr(error.message.find("bad.show"));
}

}  // namespace

TEST_CASE("an OLA Show is read with either line end, with frames of any length and a last delay") {
  const TempFolder folder;
  const std::string path = folder.file("a.show");
  for (const std::string end : {"\n", "\r\n"}) {
    write_bytes(path, "OLA Show" + end + "1 0,255,7" + end + "23" + end + "2 9" + end + "0" + end + "1 1,2" + end +
                          "977" + end);
    DurationNs end_ns = 0;
    const auto frames = read_show(path, &end_ns);
    REQUIRE(frames.size() == 3);
    CHECK(frames[0].slots == std::vector<std::uint8_t>{0, 255, 7});
    CHECK(frames[1].universe == 2);
    CHECK(frames[1].time_ns == 23 * kNsPerMs);
    CHECK(frames[2].time_ns == 23 * kNsPerMs);
    CHECK(frames[2].slots == std::vector<std::uint8_t>{1, 2});
    CHECK(end_ns == kNsPerS);
  }
  write_bytes(path, "OLA Show\n1 5");  // no line end at all
  CHECK(read_show(path).size() == 1);
  write_bytes(path, "OLA Show\n");
  CHECK(read_show(path).empty());
}

TEST_CASE("an OLA Show that ends inside a line is described as unfinished, and a note names the line") {
  const TempFolder folder;
  const std::string path = folder.file("a.show");
  const std::string whole = "OLA Show\n1 0,255\n20\n1 0,128\n977\n";
  const auto describe_first = [&](std::size_t size) {
    write_bytes(path, whole.substr(0, size));
    auto input = open_log_input(path);
    REQUIRE_MESSAGE(input, input.error().message);
    const auto info = describe(**input);
    REQUIRE_MESSAGE(info, info.error().message);
    return std::pair{info->finished, (*input)->notes()};
  };
  const std::size_t first_line = whole.find('\n') + 1;
  for (std::size_t size = first_line; size <= whole.size(); ++size) {
    CAPTURE(size);
    const auto [finished, notes] = describe_first(size);
    const bool between_lines = whole[size - 1] == '\n';
    CHECK(finished == between_lines);
    REQUIRE(notes.size() == (between_lines ? 0 : 1));
    if (between_lines) continue;
    const auto line = 1 + std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size), '\n');
    CHECK(notes[0].find("a.show:" + std::to_string(line) + ": the last line has no line end") != std::string::npos);
  }
}

TEST_CASE("an empty level in an OLA Show is 0, also after the last comma, and stays 0 through a DMX log") {
  const TempFolder folder;
  const std::string path = folder.file("a.show");
  write_bytes(path, "OLA Show\n1 1,,3\n20\n1 ,\n20\n1 ,,,9\r\n20\n1 7,\n20\n2 \n");
  const auto frames = read_show(path);
  REQUIRE(frames.size() == 5);
  CHECK(frames[0].slots == std::vector<std::uint8_t>{1, 0, 3});
  CHECK(frames[1].slots == std::vector<std::uint8_t>{0, 0});
  CHECK(frames[2].slots == std::vector<std::uint8_t>{0, 0, 0, 9});
  CHECK(frames[3].slots == std::vector<std::uint8_t>{7, 0});
  CHECK(frames[4].slots.empty());
  REQUIRE(convert_file(path, folder.file("a.dmxlog")));
  REQUIRE(convert_file(folder.file("a.dmxlog"), folder.file("b.show")));
  CHECK(slurp(folder.file("b.show")) == "OLA Show\n1 1,0,3\n20\n1 0,0\n20\n1 0,0,0,9\n20\n1 7,0\n20\n2 \n0\n");

  // 512 levels and a last comma: OLA reads 512.
  write_bytes(path, "OLA Show\n1 " + std::string(511, ',') + "5,\n");
  CHECK(read_show(path).front().slots.size() == 512);
  CHECK(read_show(path).front().slots.back() == 5);
}

TEST_CASE("an error in an OLA Show is reported with its line and what was expected there") {
  CHECK(error_of("") == "bad.show: is empty; expected the line 'OLA Show'");
  CHECK(error_of("OLA show\n") == "bad.show:1: expected the line 'OLA Show', got 'OLA show'");
  CHECK(error_of("OLA Show\n1 0\n1 0\n") == "bad.show:3: expected a delay in whole milliseconds, got '1 0'");
  CHECK(error_of("OLA Show\n1 0\n-5\n") == "bad.show:3: expected a delay in whole milliseconds, got '-5'");
  CHECK(error_of("OLA Show\n1 0\n1.5\n") == "bad.show:3: expected a delay in whole milliseconds, got '1.5'");
  CHECK(error_of("OLA Show\n1 0\n99999999999999999999\n").find("bad.show:3: expected a delay") == 0);
  CHECK(error_of("OLA Show\n1 0,256\n") == "bad.show:2: expected a level from 0 to 255 for address 2, got '256'");
  CHECK(error_of("OLA Show\n1 0,,256\n") == "bad.show:2: expected a level from 0 to 255 for address 3, got '256'");
  CHECK(error_of("OLA Show\n1 0,\n5\n1 ,x\n") == "bad.show:4: expected a level from 0 to 255 for address 2, got 'x'");
  CHECK(error_of("OLA Show\nx 0\n") == "bad.show:2: expected '<universe> <level>,<level>,...', got 'x 0'");
  CHECK(error_of("OLA Show\n64000 0\n") == "bad.show:2: expected a universe from 1 to 63999, got 64000");
  CHECK(error_of("OLA Show\n0 0\n").find("expected a universe from 1 to 63999, got 0; for a show") !=
        std::string::npos);
  CHECK(error_of("OLA Show\n0 0\n", 1) == "");
  std::string long_line = "OLA Show\n1 0";
  for (int i = 0; i < 512; ++i) long_line += ",0";
  CHECK(error_of(long_line) == "bad.show:2: expected at most 512 levels");
  CHECK(error_of("OLA Show\n1 " + std::string(513, ',')) == "bad.show:2: expected at most 512 levels");
  CHECK(error_of("OLA Show\n" + std::string(100'000, '7')).find("bad.show:2: the line is longer than") == 0);
  CHECK(error_of(std::string("OLA Show\n\0\n", 11)).find("bad.show:2: expected '<universe>") == 0);
  CHECK(!OlaShowReader::open("/nonexistent.show"));
  CHECK(!OlaShowReader::open("/"));
}

TEST_CASE("the output equals OLA's to the byte") {
  const TempFolder folder;
  const std::string path = folder.file("a.show");
  auto show = OlaShowWriter::create(path);
  REQUIRE(show);
  const std::vector<std::uint8_t> slots = {1, 2, 255};
  REQUIRE(show->append(0, 1, slots));
  REQUIRE(show->append(23 * kNsPerMs, 7, slots));
  REQUIRE(show->close(kNsPerS));
  CHECK(slurp(path) == "OLA Show\n1 1,2,255\n23\n7 1,2,255\n977\n");
  CHECK(!OlaShowWriter::create(path));
  CHECK(OlaShowWriter::create(path, true));
}

TEST_CASE("rounding to milliseconds moves no frame by more than half a millisecond, after any time") {
  const TempFolder folder;
  const std::string path = folder.file("a.show");
  auto show = OlaShowWriter::create(path);
  REQUIRE(show);
  std::vector<DurationNs> times;
  const std::vector<std::uint8_t> slots = {0};
  for (int i = 0; i < 26'400; ++i) {  // ten minutes of 44 Hz: 22.727 ms, of which truncation would lose 0.727 each time
    times.push_back(DurationNs{i} * 1'000'000'000 / 44);
    REQUIRE(show->append(times.back(), 1, slots));
  }
  REQUIRE(show->close(600 * kNsPerS));
  DurationNs end_ns = 0;
  const auto frames = read_show(path, &end_ns);
  REQUIRE(frames.size() == times.size());
  CHECK(end_ns == 600 * kNsPerS);
  DurationNs worst_ns = 0;
  for (std::size_t i = 0; i < times.size(); ++i) worst_ns = std::max(worst_ns, std::abs(frames[i].time_ns - times[i]));
  CHECK(worst_ns <= kNsPerMs / 2);
}

TEST_CASE("an OLA Show converted to a DMX log and back is the same to the byte") {
  const TempFolder folder;
  const std::string text = "OLA Show\n1 0,255,7\n23\n2 9,9,9,9\n0\n1 0,255,7\n40\n3 \n1\n1 1,2\n22\n2 9,9,9,8\n977\n";
  write_bytes(folder.file("a.show"), text);
  auto there = convert_file(folder.file("a.show"), folder.file("b.dmxlog"));
  REQUIRE_MESSAGE(there, there.error().message);
  CHECK(there->frames == 6);
  CHECK(there->duration_ns == 1063 * kNsPerMs);
  auto back = convert_file(folder.file("b.dmxlog"), folder.file("c.show"));
  REQUIRE_MESSAGE(back, back.error().message);
  CHECK(back->duration_ns == 1063 * kNsPerMs);
  CHECK(back->lead_dropped_ns == 0);
  CHECK(slurp(folder.file("c.show")) == text);
  CHECK(back->bytes_out == text.size());

  ConvertOptions changes_only;
  changes_only.changes_only = true;
  auto changes = convert_file(folder.file("a.show"), folder.file("d.show"), changes_only);
  REQUIRE(changes);
  CHECK(changes->left_out == 1);
  CHECK(read_show(folder.file("d.show")).size() == 5);

  auto text_input = open_log_input(folder.file("a.show"));
  REQUIRE(text_input);
  const auto of_text = describe(**text_input);
  const auto of_log = read_log_info(folder.file("b.dmxlog"));
  REQUIRE(of_text);
  REQUIRE(of_log);
  CHECK(of_text->format == LogFormat::kOlaShow);
  CHECK(of_log->format == LogFormat::kDmxLog);
  CHECK(of_text->frames == of_log->frames);
  CHECK(of_text->changes == of_log->changes);
  CHECK(of_text->duration_ns == of_log->duration_ns);
  CHECK(of_text->universes.size() == 3);
  CHECK(of_log->universes.size() == 3);
}

TEST_CASE("a failed conversion reports the place and leaves no file") {
  const TempFolder folder;
  write_bytes(folder.file("a.show"), "OLA Show\n1 1\n20\n1 2\nx\n");
  for (const std::string out : {"b.dmxlog", "b.show"}) {
    const auto failed = convert_file(folder.file("a.show"), folder.file(out));
    REQUIRE(!failed);
    CHECK(failed.error().message.find("a.show:5: expected a delay") != std::string::npos);
    CHECK(!std::filesystem::exists(folder.file(out)));
    CHECK(!std::filesystem::exists(folder.file(out + ".part")));
  }
  CHECK(!convert_file(folder.file("a.show"), folder.file("a.show")));
  CHECK(!convert_file(folder.file("none.show"), folder.file("b.dmxlog")));
  write_bytes(folder.file("c.bin"), "PNG\3\4");
  const auto neither = convert_file(folder.file("c.bin"), folder.file("b.dmxlog"));
  REQUIRE(!neither);
  CHECK(neither.error().message.find("expected a DMX log, an OLA Show") != std::string::npos);
}

TEST_CASE("silence before the first frame, which an OLA Show cannot store, is reported") {
  const TempFolder folder;
  auto writer = LogWriter::create(folder.file("a.dmxlog"), {});
  REQUIRE(writer);
  OwnedFrame frame;
  frame.universe = 1;
  frame.time_ns = 2 * kNsPerS;
  frame.slots = {1};
  REQUIRE(writer->append(frame.view()));
  REQUIRE(writer->close(5 * kNsPerS));
  const auto report = convert_file(folder.file("a.dmxlog"), folder.file("a.show"));
  REQUIRE(report);
  CHECK(report->lead_dropped_ns == 2 * kNsPerS);
  CHECK(report->duration_ns == 3 * kNsPerS);
  CHECK(slurp(folder.file("a.show")) == "OLA Show\n1 1\n3000\n");
}

TEST_CASE("a damaged log converted to a log is a valid one with the remaining frames") {
  const TempFolder folder;
  const auto frames = random_frames(3, 300, 3);
  LogWriterOptions options;
  options.block_span_ns = 20 * kNsPerMs;
  options.origin_ns = 12345;
  auto bytes = log_bytes(frames, kNsPerS, options);
  bytes.resize(bytes.size() / 2);
  write_bytes(folder.file("torn.dmxlog"), std::string(bytes.begin(), bytes.end()));
  const auto report = convert_file(folder.file("torn.dmxlog"), folder.file("whole.dmxlog"));
  REQUIRE(report);
  CHECK(report->damage_count == 1);
  auto reader = LogReader::open(folder.file("whole.dmxlog"));
  REQUIRE(reader);
  CHECK(reader->info().finished);
  CHECK(reader->info().origin_ns == 12345);
  const auto got = all_frames(*reader);
  CHECK(got.size() > 50);
  CHECK(std::equal(got.begin(), got.end(), frames.begin()));
}

TEST_CASE("shows recorded by OLA are unchanged after conversion to a DMX log and back") {
  const char* data = std::getenv("FOOTLIGHT_TEST_DATA");
  if (data == nullptr) {
    MESSAGE("skipped: FOOTLIGHT_TEST_DATA is not set");
    return;
  }
  const TempFolder folder;
  const std::string base = std::string(data) + "/dmx/ola-show-testdata/testdata/";
  for (const std::string name : {"dos_line_endings", "multiple_unis", "single_uni", "trailing_timeout"}) {
    CAPTURE(name);
    const auto there = convert_file(base + name, folder.file(name + ".dmxlog"));
    REQUIRE_MESSAGE(there, there.error().message);
    const auto back = convert_file(folder.file(name + ".dmxlog"), folder.file(name));
    REQUIRE_MESSAGE(back, back.error().message);
    DurationNs end_ns = 0;
    DurationNs end_again_ns = 0;
    const auto frames = read_show(base + name, &end_ns);
    const auto again = read_show(folder.file(name), &end_again_ns);
    REQUIRE(frames.size() > 1);
    REQUIRE(frames.size() == again.size());
    CHECK(end_ns == end_again_ns);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      CHECK(frames[i].time_ns == again[i].time_ns);
      CHECK(frames[i].universe == again[i].universe);
      CHECK(frames[i].slots == again[i].slots);
    }
  }
}

TEST_CASE("ten seconds of nine busy universes take at most a twentieth of the text, and end exactly") {
  for (const auto& [pattern, pattern_name] : kPatterns) {
    const std::string name = pattern_name;
    CAPTURE(name);
    const TempFolder folder;
    auto log = LogWriter::create(folder.file("a.dmxlog"), {});
    auto text = OlaShowWriter::create(folder.file("a.show"));
    REQUIRE(log);
    REQUIRE(text);
    play_pattern(pattern, 10.0, [&](const FrameView& view) {
      REQUIRE(log->append(view));
      REQUIRE(text->append(view.stamp_ns, view.universe, view.slots));
    });
    REQUIRE(log->close(10 * kNsPerS));
    REQUIRE(text->close(10 * kNsPerS));
    const auto text_bytes = std::filesystem::file_size(folder.file("a.show"));
    const auto log_size = std::filesystem::file_size(folder.file("a.dmxlog"));
    MESSAGE(name << ": OLA Show " << text_bytes << " bytes, DMX log " << log_size << " bytes, 1 to "
                 << static_cast<double>(text_bytes) / static_cast<double>(log_size));
    // Noise cannot be compressed: a byte stays a byte, where the text needs 3.6 characters.
    if (pattern == Pattern::kNoise) {
      CHECK(log_size * 3 < text_bytes);
    } else {
      CHECK(log_size * 20 < text_bytes);
    }
    CHECK(LogReader::open(folder.file("a.dmxlog"))->info().duration_ns == 10 * kNsPerS);
  }
}
