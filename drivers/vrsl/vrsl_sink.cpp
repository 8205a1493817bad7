#include "drivers/vrsl/vrsl_sink.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

#include "sim/core/no_signals.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kWaitingMax = 8;  // pictures that wait for the target

using GridLevels = std::array<std::uint8_t, static_cast<std::size_t>(kGridUniversesMax) * kSlotCountMax>;

struct WaitingLevels {
  GridLevels levels{};
  DurationNs time_ns = 0;
};

}  // namespace

struct VrslSink::Impl {
  Impl(const VrslOptions& options_in, GridCodec codec_in, std::unique_ptr<PictureOutput> output_in)
      : options(options_in), codec(std::move(codec_in)), output(std::move(output_in)) {
    for (const WireUniverse& universe : options.universes) shows.push_back(universe.show);
    waiting.reserve(kWaitingMax);
    const NoSignals for_the_thread;
    thread = std::thread([this] { run(); });
  }
  Impl(const Impl&) = delete;
  Impl& operator=(const Impl&) = delete;
  ~Impl() { stop(); }

  void stop() {
    if (!thread.joinable()) return;
    {
      const std::lock_guard lock(mutex);
      stopping = true;
    }
    wake.notify_one();
    thread.join();
  }

  void run() {
    Picture picture;
    std::uint16_t sequence = 0;
    std::vector<WaitingLevels> taken;
    taken.reserve(kWaitingMax);
    bool usable = true;
    while (true) {
      bool last = false;
      {
        std::unique_lock lock(mutex);
        wake.wait(lock, [this] { return stopping || !waiting.empty(); });
        last = stopping;
        std::swap(taken, waiting);
      }
      for (const WaitingLevels& one : taken) {
        if (!usable) break;
        codec.encode(one.levels, picture, sequence++);
        const Status shown = output->show(picture, one.time_ns);
        usable = shown || shown.error().code != ErrorCode::kDisconnected;
        keep(shown, true);
      }
      taken.clear();
      if (!last) continue;
      if (usable) keep(output->finish(), false);
      return;
    }
  }

  void keep(const Status& status, bool is_picture) {
    const std::lock_guard lock(mutex);
    if (is_picture && status) {
      ++counted.frames;
      error.clear();
    }
    if (!status) {
      ++counted.errors;
      error = status.error().message;
    }
  }

  [[nodiscard]] TimeNs due_ns(std::int64_t index) const {
    return start_ns + std::llround(static_cast<double>(index) * 1e9 / options.target.pictures_hz);
  }

  const VrslOptions options;
  const GridCodec codec;
  const std::unique_ptr<PictureOutput> output;  // used by the thread
  std::vector<Universe> shows;

  // Used by the pump's thread.
  GridLevels levels{};
  bool started = false;
  bool closed = false;
  bool resting = false;
  TimeNs start_ns = 0;
  std::int64_t next_index = 0;
  std::uint64_t dropped = 0;

  mutable std::mutex mutex;  // guards what follows
  std::condition_variable wake;
  std::vector<WaitingLevels> waiting;
  PortCounters counted;
  std::string error;
  bool stopping = false;

  std::thread thread;
};

VrslSink::VrslSink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
VrslSink::~VrslSink() = default;

Result<std::unique_ptr<VrslSink>> VrslSink::open(const VrslOptions& options, std::unique_ptr<PictureOutput> output) {
  auto codec = GridCodec::make(options.format);
  if (!codec) return fail(codec.error().code, "{}: {}", options.target.endpoint, codec.error().message);
  return std::unique_ptr<VrslSink>(new VrslSink(std::make_unique<Impl>(options, std::move(*codec), std::move(output))));
}

std::string VrslSink::name() const { return impl_->options.target.endpoint; }

TimeNs VrslSink::next_deadline_ns() const {
  if (impl_->closed) return kTimeNever;
  return impl_->started ? impl_->due_ns(impl_->next_index) : 0;
}

PortState VrslSink::state() const {
  const std::lock_guard lock(impl_->mutex);
  if (!impl_->error.empty()) return PortState::kGone;  // also after the end: a video may fail there
  return impl_->closed ? PortState::kEnded : PortState::kWorking;
}

std::string VrslSink::trouble() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->error;
}

PortCounters VrslSink::counters() const {
  const std::lock_guard lock(impl_->mutex);
  PortCounters counters = impl_->counted;
  counters.dropped = impl_->dropped;
  return counters;
}

void VrslSink::take_figures(std::vector<PortFigure>& into) const {
  into.clear();
  const std::lock_guard lock(impl_->mutex);
  into.push_back({"pictures", static_cast<double>(impl_->counted.frames)});
}

void VrslSink::rest(TimeNs /*now_ns*/) { impl_->resting = true; }

Status VrslSink::send(TimeNs /*now_ns*/, std::span<const FrameView> frames) {
  impl_->resting = false;
  for (const FrameView& frame : frames) {
    if (frame.start_code != kStartCodeLevels) continue;
    for (const WireUniverse& universe : impl_->options.universes) {
      if (universe.show != frame.universe) continue;
      const auto first = static_cast<std::ptrdiff_t>(universe.wire - 1) * kSlotCountMax;
      std::copy(frame.slots.begin(), frame.slots.end(), impl_->levels.begin() + first);
    }
  }
  return {};
}

Status VrslSink::poll(TimeNs now_ns) {
  Impl& impl = *impl_;
  if (impl.closed) return {};
  if (!impl.started) {
    impl.started = true;
    impl.start_ns = now_ns;
  }
  if (now_ns < impl.due_ns(impl.next_index)) return {};
  // The newest picture that is due; those before it were not made in time.
  while (now_ns >= impl.due_ns(impl.next_index + 1)) {
    ++impl.next_index;
    impl.dropped += impl.resting ? 0 : 1;
  }
  const DurationNs time_ns = impl.due_ns(impl.next_index++) - impl.start_ns;
  if (impl.resting) return {};
  {
    const std::lock_guard lock(impl.mutex);
    if (impl.waiting.size() == kWaitingMax) {
      ++impl.dropped;
      return {};
    }
    impl.waiting.push_back({impl.levels, time_ns});
  }
  impl.wake.notify_one();
  return {};
}

std::span<const Universe> VrslSink::universes() const { return impl_->shows; }

void VrslSink::close(TimeNs /*now_ns*/) {
  impl_->stop();
  impl_->closed = true;
}

}  // namespace footlight::drivers
