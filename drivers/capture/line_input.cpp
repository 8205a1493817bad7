#include <algorithm>
#include <charconv>
#include <optional>
#include <utility>

#include "drivers/capture/captures.h"
#include "drivers/capture/sigrok_file.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kSearchNs = 2 * kNsPerS;  // length of the search for a DMX line

struct Line {
  SigrokProbe probe;
  bool inverted = false;
  // Slots of levels in valid frames, then slots of any kind: an inverted line gives short frames with odd start codes.
  std::pair<std::uint64_t, std::uint64_t> score = {};
  [[nodiscard]] unsigned bit() const { return static_cast<unsigned>(probe.number - 1); }
};

std::vector<SigrokProbe> probes_of(const SigrokMetadata& metadata) {
  if (!metadata.probes.empty()) return metadata.probes;
  std::vector<SigrokProbe> probes;
  for (int number = 1; number <= metadata.probe_count; ++number) probes.push_back({number, std::to_string(number)});
  return probes;
}

void take_score(DmxLineDecoder& decoder, Line& line) {
  LineFrame frame;
  while (decoder.take(frame)) {
    if (frame.timing.fault != LineFault::kNone) continue;
    const auto slots = static_cast<std::uint64_t>(frame.timing.slot_count);
    if (frame.timing.start_code == footlight::kStartCodeLevels) line.score.first += slots;
    line.score.second += slots;
  }
}

Result<Line> find_line(SigrokFile& file, const std::string& path, const CaptureOptions& options) {
  const SigrokMetadata& metadata = file.metadata();
  const auto probes = probes_of(metadata);
  std::string names;
  for (const SigrokProbe& probe : probes)
    names += fmt::format("{}{} ({})", names.empty() ? "" : ", ", probe.number, probe.name);
  if (!options.channel.empty()) {
    int number = 0;
    const char* const end = options.channel.data() + options.channel.size();
    const auto [at, fault] = std::from_chars(options.channel.data(), end, number);
    const bool is_number = fault == std::errc{} && at == end;
    for (const SigrokProbe& probe : probes) {
      if (probe.name == options.channel) return Line{probe, options.inverted, {}};
    }
    for (const SigrokProbe& probe : probes) {
      if (is_number && probe.number == number) return Line{probe, options.inverted, {}};
    }
    return fail(ErrorCode::kBadInput, "{}: has no channel '{}'; it has {}", path, options.channel, names);
  }
  std::vector<std::pair<Line, DmxLineDecoder>> tried;
  for (const SigrokProbe& probe : probes) {
    for (const bool inverted : {false, true}) {
      tried.emplace_back(Line{probe, inverted, {}}, DmxLineDecoder(metadata.sample_rate_hz));
    }
  }
  while (tried.front().second.now_ns() < kSearchNs) {
    const auto samples = file.read();
    if (samples.empty()) break;
    for (auto& [line, decoder] : tried) {
      decoder.feed_samples(samples, metadata.unit_size, line.bit(), line.inverted);
      take_score(decoder, line);
    }
  }
  for (auto& [line, decoder] : tried) {
    decoder.finish();
    take_score(decoder, line);
  }
  file.rewind();
  // The first of equals: DMX+ as it is comes before inverted DMX-.
  const auto best = std::max_element(tried.begin(), tried.end(),
                                     [](const auto& a, const auto& b) { return a.first.score < b.first.score; });
  if (best->first.score == std::pair<std::uint64_t, std::uint64_t>{}) {
    return fail(ErrorCode::kBadInput,
                "{}: no DMX frame in the first {} s of any channel: {}; name a channel to see the reason", path,
                kSearchNs / kNsPerS, names);
  }
  return best->first;
}

class LineInput final : public LogInput {
 public:
  LineInput(SigrokFile file, std::string path, Line line, Universe universe)
      : file_(std::move(file)),
        path_(std::move(path)),
        line_(std::move(line)),
        universe_(universe),
        decoder_(file_.metadata().sample_rate_hz) {}

  [[nodiscard]] LogFormat format() const override { return LogFormat::kLineCapture; }
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] std::vector<Universe> universes() const override { return {universe_}; }
  [[nodiscard]] TimeNs end_ns() const override { return decoder_.now_ns(); }
  [[nodiscard]] std::uint64_t damage_count() const override { return file_.trouble().empty() ? 0 : 1; }

  // The next frame of the line, valid or not.
  bool next_line_frame(LineFrame& frame) {
    while (!decoder_.take(frame)) {
      if (ended_) return false;
      const auto samples = file_.read();
      if (samples.empty()) {
        decoder_.finish();
        ended_ = true;
      } else {
        decoder_.feed_samples(samples, file_.metadata().unit_size, line_.bit(), line_.inverted);
      }
    }
    return true;
  }

  Result<bool> next(FrameView& frame) override {
    while (next_line_frame(frame_)) {
      if (frame_.timing.fault != LineFault::kNone) continue;
      if (frame_.timing.start_code != footlight::kStartCodeLevels) {
        ++other_start_codes_;
        continue;
      }
      if (frame_.timing.unfinished) unfinished_ = frame_.timing.slot_count;
      frame = {};
      frame.universe = universe_;
      frame.stamp_ns = frame_.timing.end_ns;  // when a receiver has all of it
      frame.slots = frame_.slots();
      return true;
    }
    return false;
  }

  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes;
    const LineCounters& counters = decoder_.counters();
    notes.push_back(
        fmt::format("channel {} ({}){}", line_.probe.number, line_.probe.name, line_.inverted ? ", inverted" : ""));
    for (int fault = 1; fault < kLineFaultCount; ++fault) {
      const std::uint64_t count = counters.faults[static_cast<std::size_t>(fault)];
      if (count > 0) notes.push_back(fmt::format("{} frames: {}", count, text_of(static_cast<LineFault>(fault))));
    }
    if (unfinished_ >= 0) {
      notes.push_back(fmt::format("the capture ends inside the last frame, after slot {}", unfinished_));
    }
    if (other_start_codes_ > 0) {
      notes.push_back(fmt::format("{} frames of other start codes; a log holds levels only", other_start_codes_));
    }
    if (counters.glitches > 0) notes.push_back(fmt::format("{} pulses below 1.5 us were ignored", counters.glitches));
    if (!file_.trouble().empty()) notes.push_back("the capture ends early: " + file_.trouble());
    return notes;
  }

  [[nodiscard]] const LineCounters& counters() const { return decoder_.counters(); }
  [[nodiscard]] const Line& line() const { return line_; }
  [[nodiscard]] std::uint64_t sample_rate_hz() const { return file_.metadata().sample_rate_hz; }

 private:
  SigrokFile file_;
  std::string path_;
  Line line_;
  Universe universe_;
  DmxLineDecoder decoder_;
  LineFrame frame_;
  bool ended_ = false;
  std::uint64_t other_start_codes_ = 0;
  int unfinished_ = -1;  // slots of the last frame if the samples end inside it; else -1
};

Result<std::unique_ptr<LineInput>> open_line(const std::string& path, const CaptureOptions& options) {
  FL_ASSIGN(SigrokFile file, SigrokFile::open(path));
  FL_ASSIGN(Line line, find_line(file, path, options));
  return std::make_unique<LineInput>(std::move(file), path, std::move(line), options.universe);
}

}  // namespace

Result<std::unique_ptr<LogInput>> open_sigrok(const std::string& path, const CaptureOptions& options) {
  FL_ASSIGN(std::unique_ptr<LineInput> input, open_line(path, options));
  return std::unique_ptr<LogInput>(std::move(input));
}

Result<LineCaptureInfo> read_line_timing(const std::string& path, const CaptureOptions& options) {
  FL_ASSIGN(const std::unique_ptr<LineInput> input, open_line(path, options));
  LineCaptureInfo info;
  LineFrame frame;
  while (input->next_line_frame(frame)) info.frames.push_back(frame.timing);
  info.channel = input->line().probe.name;
  info.inverted = input->line().inverted;
  info.sample_rate_hz = static_cast<double>(input->sample_rate_hz());
  info.duration_ns = input->end_ns();
  info.counters = input->counters();
  info.notes = input->notes();
  return info;
}

}  // namespace footlight::drivers
