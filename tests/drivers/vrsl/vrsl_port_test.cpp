#include <doctest/doctest.h>

#include <poll.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "drivers/vrsl/grid_find.h"
#include "drivers/vrsl/vrsl_sink.h"
#include "drivers/vrsl/vrsl_source.h"
#include "tests/drivers/vrsl/grids.h"

using namespace footlight;
using namespace footlight::drivers;

namespace {

struct Shown {
  std::vector<Picture> pictures;
  std::vector<DurationNs> times;
  bool finished = false;
};

// Keeps what it is shown; refuses the pictures from `fail_from` up to `fail_to`.
class KeepingOutput final : public PictureOutput {
 public:
  KeepingOutput(std::shared_ptr<Shown> shown, std::size_t fail_from = 0, std::size_t fail_to = 0)
      : shown_(std::move(shown)), fail_from_(fail_from), fail_to_(fail_to) {}
  Status show(const Picture& picture, DurationNs time_ns) override {
    const std::size_t at = calls_++;
    if (at >= fail_from_ && at < fail_to_) return fail(ErrorCode::kIo, "the disk is full");
    shown_->pictures.push_back(picture);
    shown_->times.push_back(time_ns);
    return {};
  }
  Status finish() override {
    shown_->finished = true;
    return {};
  }

 private:
  std::shared_ptr<Shown> shown_;
  std::size_t fail_from_, fail_to_, calls_ = 0;
};

// Gives pictures at 10 a second, or as they are if live.
class GivingInput final : public PictureInput {
 public:
  GivingInput(std::vector<Picture> pictures, bool live, std::atomic<int>* calls = nullptr)
      : pictures_(std::move(pictures)), live_(live), calls_(calls) {}
  Result<PictureStep> next(Picture& picture, std::optional<DurationNs>& time_ns, DurationNs) override {
    if (calls_ != nullptr) ++*calls_;
    if (at_ == pictures_.size()) return PictureStep::kEnd;
    if (!live_) time_ns = static_cast<DurationNs>(at_) * 100 * kNsPerMs;
    picture = pictures_[at_++];
    return PictureStep::kPicture;
  }

 private:
  std::vector<Picture> pictures_;
  bool live_;
  std::atomic<int>* calls_;
  std::size_t at_ = 0;
};

struct Frames final : FrameReceiver {
  void receive(const FrameView& frame) override {
    universes.push_back(frame.universe);
    stamps.push_back(frame.stamp_ns);
    slots.emplace_back(frame.slots.begin(), frame.slots.end());
  }
  std::vector<Universe> universes;
  std::vector<TimeNs> stamps;
  std::vector<std::vector<std::uint8_t>> slots;
};

Endpoint endpoint_of(std::string_view text) {
  auto endpoint = parse_endpoint(text, {});
  REQUIRE_MESSAGE(endpoint.has_value(), endpoint.error().message);
  return *endpoint;
}

VrslOptions out_options(std::string_view text) {
  auto options = vrsl_out_options(endpoint_of(text));
  REQUIRE_MESSAGE(options.has_value(), options.error().message);
  return *options;
}
VrslOptions in_options(std::string_view text) {
  auto options = vrsl_in_options(endpoint_of(text));
  REQUIRE_MESSAGE(options.has_value(), options.error().message);
  return *options;
}

// Waits until the source's thread has left something, or has ended.
void wait_for(const VrslSource& source) {
  pollfd waited{.fd = source.poll_fd(), .events = POLLIN, .revents = 0};
  REQUIRE(::poll(&waited, 1, 20'000) == 1);
}

Picture picture_of(const GridFormat& format, const std::vector<std::uint8_t>& levels, std::uint16_t sequence = 0) {
  Picture picture;
  const auto codec = GridCodec::make(format);
  REQUIRE(codec.has_value());
  codec->encode(levels, picture, sequence);
  return picture;
}

}  // namespace

TEST_CASE("a sink shows a picture at each of its times, with the newest levels of its universes") {
  auto shown = std::make_shared<Shown>();
  auto sink = VrslSink::open(out_options("vrsl:1-2=11-12@x?fps=10"), std::make_unique<KeepingOutput>(shown));
  REQUIRE(sink.has_value());
  const std::vector<Universe> universes((*sink)->universes().begin(), (*sink)->universes().end());
  CHECK(universes == std::vector<Universe>{11, 12});
  const std::vector<std::uint8_t> bright(512, 200), dim(100, 50);
  const FrameView first[] = {{.universe = 12, .slots = bright}, {.universe = 5, .slots = bright}};
  const TimeNs start = 7 * kNsPerS;
  REQUIRE((*sink)->send(start, first).has_value());
  REQUIRE((*sink)->poll(start).has_value());
  CHECK((*sink)->next_deadline_ns() == start + 100 * kNsPerMs);
  REQUIRE((*sink)->poll(start + 99 * kNsPerMs).has_value());  // not due
  const FrameView second[] = {{.universe = 12, .slots = dim}};
  REQUIRE((*sink)->send(start + 99 * kNsPerMs, second).has_value());
  REQUIRE((*sink)->poll(start + 101 * kNsPerMs).has_value());
  REQUIRE((*sink)->poll(start + 350 * kNsPerMs).has_value());  // too late for the picture at 200 ms
  (*sink)->close(start + 400 * kNsPerMs);
  CHECK(shown->finished);
  CHECK(shown->times == std::vector<DurationNs>{0, 100 * kNsPerMs, 300 * kNsPerMs});
  CHECK((*sink)->counters().frames == 3);
  CHECK((*sink)->counters().dropped == 1);
  REQUIRE(shown->pictures.size() == 3);
  const auto codec = GridCodec::make({});
  std::vector<std::uint8_t> levels(3 * 512);
  GridReading reading;
  REQUIRE(codec->decode(shown->pictures[0].view(), levels, reading).has_value());
  CHECK(levels[512] == 200);
  CHECK(levels[0] == 0);
  REQUIRE(codec->decode(shown->pictures[1].view(), levels, reading).has_value());
  CHECK(levels[512] == 50);
  CHECK(levels[512 + 100] == 200);  // past the end of a short frame
}

TEST_CASE("a sink that rests shows nothing until levels are sent again") {
  auto shown = std::make_shared<Shown>();
  auto sink = VrslSink::open(out_options("vrsl:1@x?fps=10"), std::make_unique<KeepingOutput>(shown));
  REQUIRE(sink.has_value());
  REQUIRE((*sink)->poll(0).has_value());
  (*sink)->rest(50 * kNsPerMs);
  REQUIRE((*sink)->poll(100 * kNsPerMs).has_value());
  REQUIRE((*sink)->poll(500 * kNsPerMs).has_value());
  REQUIRE((*sink)->send(550 * kNsPerMs, {}).has_value());
  REQUIRE((*sink)->poll(600 * kNsPerMs).has_value());
  (*sink)->close(kNsPerS);
  CHECK(shown->times == std::vector<DurationNs>{0, 600 * kNsPerMs});
  CHECK((*sink)->counters().dropped == 0);
}

TEST_CASE("a sink whose target refuses pictures is lost with the reason, and works again with the next one") {
  auto shown = std::make_shared<Shown>();
  auto sink = VrslSink::open(out_options("vrsl:1@x?fps=10"), std::make_unique<KeepingOutput>(shown, 0, 1));
  REQUIRE(sink.has_value());
  REQUIRE((*sink)->poll(0).has_value());
  while ((*sink)->counters().errors == 0) std::this_thread::yield();
  CHECK((*sink)->state() == PortState::kGone);
  CHECK((*sink)->trouble() == "the disk is full");
  REQUIRE((*sink)->poll(100 * kNsPerMs).has_value());
  while ((*sink)->counters().frames == 0) std::this_thread::yield();
  CHECK((*sink)->state() == PortState::kWorking);
  (*sink)->close(kNsPerS);
}

TEST_CASE("a source finds the grid and gives each picture at its time") {
  const GridFormat format{.layout = GridLayout::kVerticalLeft, .planes = GridPlanes::kRgb};
  const auto a = random_levels(1), b = random_levels(2);
  auto source = VrslSource::open(
      in_options("vrsl:1-9=101-109@x"),
      std::make_unique<GivingInput>(std::vector<Picture>{picture_of(format, a), picture_of(format, b)}, false));
  REQUIRE(source.has_value());
  Frames frames;
  const TimeNs start = 3 * kNsPerS;
  while (frames.universes.empty()) {
    wait_for(**source);
    REQUIRE((*source)->poll(start, frames).has_value());
  }
  // Universes 3, 6 and 9 are not in a vertical picture, and the others of it end early.
  CHECK(frames.universes == std::vector<Universe>{101, 102, 104, 105, 107, 108});
  CHECK(frames.slots[0] == std::vector<std::uint8_t>(a.begin(), a.begin() + 512));
  CHECK(frames.slots[1].size() == 351);
  CHECK(frames.stamps[0] == start);
  REQUIRE((*source)->poll(start + 99 * kNsPerMs, frames).has_value());
  CHECK(frames.universes.size() == 6);
  while ((*source)->next_deadline_ns() == kTimeNever) std::this_thread::yield();
  CHECK((*source)->next_deadline_ns() == start + 100 * kNsPerMs);
  REQUIRE((*source)->poll(start + 130 * kNsPerMs, frames).has_value());
  CHECK(frames.universes.size() == 12);
  CHECK(frames.stamps.back() == start + 100 * kNsPerMs);
  while ((*source)->state() != PortState::kEnded) std::this_thread::yield();
  const auto notice = (*source)->take_notice();
  REQUIRE(notice.has_value());
  CHECK(notice->id == "vrsl-grid");
  CHECK(notice->text.find("vertical-left, rgb, full, linear") != std::string::npos);
}

TEST_CASE("a source refuses and counts pictures of something else") {
  Picture film = picture_of({}, random_levels(1));
  for (int y = 880; y < 1000; ++y) {
    for (int x = 0; x < 1920; ++x) film.at(x, y)[x % 3] = static_cast<std::uint8_t>(x * y);
  }
  auto source =
      VrslSource::open(in_options("vrsl:1-3@x"), std::make_unique<GivingInput>(std::vector<Picture>(3, film), true));
  REQUIRE(source.has_value());
  Frames frames;
  while ((*source)->state() != PortState::kEnded) {
    wait_for(**source);
    REQUIRE((*source)->poll(0, frames).has_value());
  }
  CHECK(frames.universes.empty());
  CHECK((*source)->counters().rejected == 3);
  const auto notice = (*source)->take_notice();
  REQUIRE(notice.has_value());
  CHECK(notice->id == "vrsl-no-grid");
  CHECK(notice->text.find("no grid") != std::string::npos);
}

TEST_CASE("a named grid is read from the first good picture on, also after a refused one and in another size") {
  VrslReader reader(in_options("vrsl:1-3@x?layout=horizontal-bottom&planes=luma"));
  Picture noise;
  noise.clear(1280, 720);
  for (std::size_t i = 0; i < noise.rgb.size(); ++i) noise.rgb[i] = static_cast<std::uint8_t>(i * i >> 3);
  CHECK_FALSE(reader.read(noise.view()));
  CHECK(reader.read(picture_of({}, random_levels(1)).view()));
  CHECK_FALSE(reader.read(noise.view()));
  CHECK(reader.read(picture_of({}, random_levels(2)).view()));
  CHECK(reader.counters().used == 2);
}

TEST_CASE("refused pictures of a file are not read ahead of their time") {
  Picture small;
  small.clear(64, 36);
  std::atomic<int> calls = 0;
  auto source = VrslSource::open(in_options("vrsl:1-3@x"),
                                 std::make_unique<GivingInput>(std::vector<Picture>(500, small), false, &calls));
  REQUIRE(source.has_value());
  Frames frames;
  for (int i = 0; i < 2000; ++i) {
    REQUIRE((*source)->poll(0, frames).has_value());
    std::this_thread::yield();
  }
  // One that was due, and four ahead.
  CHECK(calls <= 6);
  CHECK((*source)->state() == PortState::kWaiting);
  CHECK(frames.universes.empty());
}

TEST_CASE("the check row makes lost, repeated and damaged pictures known") {
  GridFormat format;
  format.check_row = true;
  const auto sent = random_levels(3);
  VrslReader reader(in_options("vrsl:1-3@x?check=yes&layout=horizontal-bottom"));
  CHECK(reader.read(picture_of(format, sent, 65'534).view()));
  CHECK(!reader.read(picture_of(format, sent, 65'534).view()));  // again
  CHECK(reader.read(picture_of(format, sent, 2).view()));        // 65,535, 0 and 1 are missing
  Picture damaged = picture_of(format, sent, 3);
  for (int y = 880; y < 888; ++y) {
    for (int x = 160; x < 176; ++x) std::fill_n(damaged.at(x, y), 3, std::uint8_t{128});
  }
  for (int y = 872; y < 888; ++y) {
    for (int x = 160; x < 176; ++x) std::fill_n(damaged.at(x, y), 3, std::uint8_t{128});
  }
  CHECK(!reader.read(damaged.view()));
  CHECK(reader.refusal().find("CRC-32") != std::string::npos);
  CHECK(!reader.read(picture_of({}, sent).view()));  // without a row
  CHECK(reader.counters().used == 2);
  CHECK(reader.counters().repeated == 1);
  CHECK(reader.counters().lost == 3);
  CHECK(reader.counters().damaged == 2);
}

TEST_CASE("options of endpoints are checked, with the endpoint, the option and what was expected") {
  const auto options = out_options(
      "vrsl:1-2,4@x.png?layout=vertical-right&range=limited&transfer=from-srgb&flip=yes&"
      "size=1280x720&fps=59.94&check=yes&bitrate=5M");
  CHECK(name_of(options.format.layout) == "vertical-right");
  CHECK(name_of(options.format.planes) == "rgb");
  CHECK(name_of(options.format.range) == "limited");
  CHECK(name_of(options.format.transfer) == "from-srgb");
  CHECK(options.format.flipped);
  CHECK(options.format.check_row);
  CHECK(options.target.width == 1280);
  CHECK(options.target.pictures_hz == doctest::Approx(59.94));
  CHECK(options.target.options == std::vector<EndpointOption>{{"bitrate", "5M"}});
  struct Bad {
    const char* text;
    const char* message;
  };
  for (const Bad& bad :
       {Bad{"vrsl:1@x?layout=left", "expected horizontal-bottom, horizontal-top"},
        Bad{"vrsl:1@x?layout=auto", "layout=auto: expected"},
        Bad{"vrsl:1@x?range=tv", "range=tv: expected full, limited"}, Bad{"vrsl:1@x?flip=1", "expected yes or no"},
        Bad{"vrsl:1@x?fps=0", "expected pictures a second, 0.1 to 240"},
        Bad{"vrsl:1@x?fps=nan", "expected pictures a second"}, Bad{"vrsl:1@x?size=1920", "expected WIDTHxHEIGHT"},
        Bad{"vrsl:1@x?size=9000x1", "expected WIDTHxHEIGHT"}, Bad{"vrsl:1@x?place=1,2", "expected LEFT,TOP,CELL"},
        Bad{"vrsl:1@x?place=1,2,16", "is not inside a picture"},
        Bad{"vrsl:4@x?planes=luma", "planes=luma carries universes 1 to 3"},
        Bad{"vrsl:1-3@x?layout=vertical-left", "does not show universe 3"}}) {
    const auto refused = vrsl_out_options(endpoint_of(bad.text));
    CAPTURE(bad.text);
    REQUIRE(!refused.has_value());
    CHECK(refused.error().code == ErrorCode::kBadInput);
    CHECK(refused.error().message.find(bad.text) == 0);
    CHECK(refused.error().message.find(bad.message) != std::string::npos);
  }
  CHECK(in_options("vrsl:1@x").find);
  CHECK(!in_options("vrsl:1@x?layout=vertical-left").find);
  CHECK(!vrsl_in_options(endpoint_of("vrsl:1@x?range=limited")).has_value());
}
