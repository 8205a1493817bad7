#include "drivers/vrsl/vrsl_source.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include <fmt/ranges.h>

#include "drivers/fd.h"
#include "drivers/net/hash.h"
#include "drivers/vrsl/grid_find.h"
#include "sim/core/no_signals.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kDecodedMax = 4;  // pictures ahead of the pump
constexpr DurationNs kInputWaitNs = 50 * kNsPerMs;
constexpr int kFindAgainAfter = 30;  // refused pictures, before the grid is searched for again
constexpr int kFindEvery = 30;       // pictures, while there is none: a search takes up to 0.1 s

struct DecodedPicture {
  std::array<std::uint8_t, static_cast<std::size_t>(kGridUniversesMax) * kSlotCountMax> levels{};
  std::array<std::uint16_t, kGridUniversesMax> slot_counts{};  // all 0: it was refused
  std::optional<DurationNs> time_ns;
  std::uint32_t sequence = 0;
};

}  // namespace

std::string text_of(const GridCodec& codec) {
  const GridFormat& format = codec.format();
  const GridPlace& place = codec.place();
  return fmt::format("{}, {}, {}, {}{}, at {:.6g}, {:.6g} with cells of {:.4g} px", name_of(format.layout),
                     name_of(format.planes), name_of(format.range), name_of(format.transfer),
                     format.flipped ? ", upside down" : "", place.left, place.top, place.cell_width);
}

float VrslReader::confidence() const {
  float lowest = 1;
  for (const WireUniverse& universe : options_.universes) {
    if (universe.wire > codec_->universe_count()) return 0;
    lowest = std::min(lowest, reading_.confidence[static_cast<std::size_t>(universe.wire - 1)]);
  }
  return lowest;
}

bool VrslReader::find(const PictureView& picture) {
  GridFormat format = options_.format;
  std::vector<std::string> open;
  if (options_.find) {
    auto found = find_grid(picture);
    if (!found) {
      refusal_ = found.error().message;
      return false;
    }
    format = found->format;
    format.check_row = options_.format.check_row;
    open = std::move(found->open);
  } else if (options_.any_size) {
    format.width = picture.width;
    format.height = picture.height;
  }
  auto codec = GridCodec::make(format);
  if (!codec) {
    refusal_ = codec.error().message;
    return false;
  }
  codec_ = std::move(*codec);
  open_ = std::move(open);
  return true;
}

bool VrslReader::read(const PictureView& picture) {
  const auto refuse = [&](std::uint64_t& counter) {
    ++counter;
    ++refused_in_a_row_;
    return false;
  };
  const bool other_size =
      codec_ && (codec_->format().width != picture.width || codec_->format().height != picture.height);
  if (other_size || (options_.find && refused_in_a_row_ >= kFindAgainAfter)) codec_.reset();
  if (!codec_) {
    // A search takes long; a grid that is named does not.
    if (options_.find && refused_in_a_row_ % kFindEvery != 0) return refuse(counters_.no_grid);
    if (!find(picture)) return refuse(counters_.no_grid);
  }
  if (const Status status = codec_->decode(picture, levels_, reading_); !status) {
    refusal_ = status.error().message;
    return refuse(counters_.no_grid);
  }
  if (confidence() < kGridConfidenceMin) {
    refusal_ = fmt::format("the confidence is {:.2f}, expected at least {}: not a grid of {}, or too damaged",
                           confidence(), kGridConfidenceMin, text_of(*codec_));
    return refuse(counters_.uncertain);
  }
  if (codec_->format().check_row) {
    if (reading_.damaged) {
      refusal_ = reading_.sequence ? "the CRC-32 of its check row differs" : "it has no check row";
      return refuse(counters_.damaged);
    }
    const std::uint16_t sequence = *reading_.sequence;
    if (last_sequence_) {
      const auto step = static_cast<std::uint16_t>(sequence - *last_sequence_);
      if (step == 0) {
        refused_in_a_row_ = 0;
        ++counters_.repeated;
        return false;
      }
      if (step < 0x8000) counters_.lost += step - 1u;
    }
    last_sequence_ = sequence;
  }
  refused_in_a_row_ = 0;
  ++counters_.used;
  return true;
}

struct VrslSource::Impl {
  Impl(const VrslOptions& options_in, std::unique_ptr<PictureInput> input_in)
      : options(options_in), input(std::move(input_in)), reader(options_in) {
    for (const WireUniverse& universe : options.universes) shows.push_back(universe.show);
    if (options.target.pictures_hz < 2) silence_max_ns = std::llround(5e9 / options.target.pictures_hz);
    sender = std::max<SenderId>(mix64(fnv1a64(options.target.endpoint)), 1);
    const NoSignals for_the_thread;
    thread = std::thread([this] { run(); });
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() {
    {
      const std::lock_guard lock(mutex);
      stopping = true;
    }
    wake.notify_one();
    thread.join();
  }

  void run() {
    Picture picture;
    std::uint32_t sequence = 0;
    while (true) {
      {
        std::unique_lock lock(mutex);
        // A live input is not held up: its oldest picture is replaced.
        wake.wait(lock, [this] { return stopping || live || decoded.size() < kDecodedMax; });
        if (stopping) return;
      }
      std::optional<DurationNs> time_ns;
      const auto step = input->next(picture, time_ns, kInputWaitNs);
      if (!step && (step.error().code == ErrorCode::kTimeout || step.error().code == ErrorCode::kIo)) {
        std::unique_lock lock(mutex);
        error = step.error().message;
        ++errors;
        ready.signal();
        wake.wait_for(lock, std::chrono::seconds(1), [this] { return stopping; });
        continue;
      }
      if (!step && step.error().code == ErrorCode::kProtocol) {
        const std::lock_guard lock(mutex);
        ++unreadable;
        if (unreadable == 1) {
          notes.push_back(
              {NoticeLevel::kWarning, "vrsl-no-grid", "a picture gives no levels: " + step.error().message});
        }
        ready.signal();
        continue;
      }
      if (!step || *step == PictureStep::kEnd) {
        const std::lock_guard lock(mutex);
        ended = true;
        if (!step) {
          error = step.error().message;
          ++errors;
        }
        ready.signal();
        return;
      }
      if (*step == PictureStep::kPicture) decode(picture, time_ns, ++sequence);
    }
  }

  void decode(const Picture& picture, std::optional<DurationNs> time_ns, std::uint32_t sequence) {
    const bool usable = reader.read(picture.view());
    const std::lock_guard lock(mutex);
    error.clear();
    live = !time_ns;
    counters = reader.counters();
    if (reader.codec() && !(reader.codec()->format() == noted_format)) {
      noted_format = reader.codec()->format();
      notes.push_back({NoticeLevel::kInfo, "vrsl-grid",
                       fmt::format("the grid is {}.{}{}", text_of(*reader.codec()), reader.open().empty() ? "" : " ",
                                   fmt::join(reader.open(), " "))});
      noted_refusal = false;
    }
    if (!usable && !noted_refusal && counters.used + counters.repeated == 0) {
      notes.push_back({NoticeLevel::kWarning, "vrsl-no-grid", "a picture gives no levels: " + reader.refusal()});
      noted_refusal = true;
    }
    // A refused picture of a file takes its time as well; else the thread would run through the file.
    if (!usable && live) {
      ready.signal();
      return;
    }
    if (live && decoded.size() == kDecodedMax) {
      decoded.pop_front();
      ++dropped;
    }
    DecodedPicture& one = decoded.emplace_back();
    one.time_ns = time_ns;
    one.sequence = sequence;
    if (usable) {
      std::copy(reader.levels().begin(), reader.levels().end(), one.levels.begin());
      for (int universe = 1; universe <= kGridUniversesMax; ++universe) {
        one.slot_counts[static_cast<std::size_t>(universe - 1)] =
            static_cast<std::uint16_t>(reader.codec()->slot_count(universe));
      }
    }
    ready.signal();
  }

  [[nodiscard]] TimeNs due_ns(const DecodedPicture& one) const { return one.time_ns ? start_ns + *one.time_ns : 0; }

  const VrslOptions options;
  const std::unique_ptr<PictureInput> input;  // used by the thread, as is the reader
  VrslReader reader;
  std::vector<Universe> shows;
  SenderId sender = 0;
  DurationNs silence_max_ns = 0;
  EventFd ready;

  // Used by the pump's thread.
  bool started = false;
  TimeNs start_ns = 0;
  std::uint64_t frames = 0;

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable wake;
  std::deque<DecodedPicture> decoded;
  VrslReaderCounters counters;
  std::vector<PortNotice> notes;
  GridFormat noted_format{.width = 0};
  bool noted_refusal = false;
  bool live = false;
  bool ended = false;
  bool stopping = false;
  std::string error;
  std::uint64_t errors = 0;
  std::uint64_t unreadable = 0;  // pictures
  std::uint64_t dropped = 0;

  std::thread thread;
};

VrslSource::VrslSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VrslSource::~VrslSource() = default;

Result<std::unique_ptr<VrslSource>> VrslSource::open(const VrslOptions& options, std::unique_ptr<PictureInput> input) {
  return std::unique_ptr<VrslSource>(new VrslSource(std::make_unique<Impl>(options, std::move(input))));
}

std::string VrslSource::name() const { return impl_->options.target.endpoint; }
int VrslSource::poll_fd() const { return impl_->ready.get(); }

TimeNs VrslSource::next_deadline_ns() const {
  if (!impl_->started) return 0;
  const std::lock_guard lock(impl_->mutex);
  return impl_->decoded.empty() ? kTimeNever : impl_->due_ns(impl_->decoded.front());
}

PortState VrslSource::state() const {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->decoded.empty() && !impl_->error.empty()) return PortState::kGone;
  if (impl_->decoded.empty() && impl_->ended) return PortState::kEnded;
  return impl_->counters.used == 0 ? PortState::kWaiting : PortState::kWorking;
}

std::string VrslSource::trouble() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->error;
}

PortCounters VrslSource::counters() const {
  const std::lock_guard lock(impl_->mutex);
  PortCounters counters;
  counters.frames = impl_->frames;
  counters.rejected = impl_->unreadable + impl_->counters.no_grid + impl_->counters.uncertain + impl_->counters.damaged;
  counters.dropped = impl_->dropped;
  counters.errors = impl_->errors;
  return counters;
}

void VrslSource::take_figures(std::vector<PortFigure>& into) const {
  into.clear();
  const std::lock_guard lock(impl_->mutex);
  const VrslReaderCounters& counters = impl_->counters;
  into.push_back({"pictures", static_cast<double>(counters.used)});
  into.push_back({"pictures_uncertain", static_cast<double>(counters.no_grid + counters.uncertain)});
  into.push_back({"pictures_damaged", static_cast<double>(counters.damaged)});
  into.push_back({"pictures_repeated", static_cast<double>(counters.repeated)});
  into.push_back({"pictures_lost", static_cast<double>(counters.lost)});
}

std::optional<PortNotice> VrslSource::take_notice() {
  const std::lock_guard lock(impl_->mutex);
  if (impl_->notes.empty()) return std::nullopt;
  PortNotice note = std::move(impl_->notes.front());
  impl_->notes.erase(impl_->notes.begin());
  return note;
}

Status VrslSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  Impl& impl = *impl_;
  if (!impl.started) {
    impl.started = true;
    impl.start_ns = now_ns;
  }
  impl.ready.clear();
  while (true) {
    DecodedPicture one;
    {
      const std::lock_guard lock(impl.mutex);
      if (impl.decoded.empty() || impl.due_ns(impl.decoded.front()) > now_ns) return {};
      one = impl.decoded.front();
      impl.decoded.pop_front();
    }
    impl.wake.notify_one();
    FrameView frame;
    frame.sender = impl.sender;
    frame.sequence = one.sequence;
    frame.stamp_ns = one.time_ns ? impl.due_ns(one) : now_ns;
    // Pictures may be further apart than the merge waits.
    frame.silence_max_ns = impl.silence_max_ns;
    for (const WireUniverse& universe : impl.options.universes) {
      const auto at = static_cast<std::size_t>(universe.wire - 1);
      if (one.slot_counts[at] == 0) continue;
      frame.universe = universe.show;
      frame.slots = std::span(one.levels).subspan(at * kSlotCountMax, one.slot_counts[at]);
      receiver.receive(frame);
      ++impl.frames;
    }
  }
}

std::span<const Universe> VrslSource::universes() const { return impl_->shows; }

}  // namespace footlight::drivers
