#include "tools/footlight/preview/hand_layer.h"

#include <algorithm>
#include <future>
#include <utility>

#include <unistd.h>

#include <fmt/format.h>

#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kHandNoticesMax = 64;
constexpr DurationNs kBaseSilenceNs = 365LL * 24 * 3'600 * kNsPerS;  // levels are sent only when they change

}  // namespace

// --- The levels below ------------------------------------------------------------------------------------------------

bool BaseFeed::give(TimeNs now_ns, std::span<const std::uint8_t> levels) {
  const auto numbers = given_.numbers();
  bool changed = false;
  for (std::size_t i = 0; i < numbers.size() && (i + 1) * kSlotCountMax <= levels.size(); ++i) {
    const auto now = levels.subspan(i * kSlotCountMax, kSlotCountMax);
    Slots before;
    FrameStamp stamp;
    given_.snapshot(static_cast<int>(i), before, stamp);
    if (stamp.revision != 0 && std::equal(now.begin(), now.end(), before.begin())) continue;
    FrameView frame;
    frame.universe = numbers[i];
    frame.stamp_ns = now_ns;
    frame.slots = now;
    given_.write(static_cast<int>(i), frame);
    changed = true;
  }
  return changed;
}

Status BaseFeed::poll(TimeNs now_ns, FrameReceiver& receiver) {
  due_ns_ = kTimeNever;
  const auto numbers = given_.numbers();
  sent_.resize(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    Slots slots;
    FrameStamp stamp;
    given_.snapshot(static_cast<int>(i), slots, stamp);
    if (stamp.revision == sent_[i]) continue;
    sent_[i] = stamp.revision;
    FrameView frame;
    frame.universe = numbers[i];
    frame.stamp_ns = now_ns;
    frame.sender = 1;
    frame.sequence = ++sequence_;
    frame.silence_max_ns = kBaseSilenceNs;
    frame.slots = slots;
    receiver.receive(frame);
  }
  return {};
}

// --- The layer -------------------------------------------------------------------------------------------------------

HandLayer::HandLayer(std::string rig, Clock& clock)
    : clock_(clock),
      rig_(std::move(rig)),
      desk_(
          clock, [this](const Notice& notice) { note(std::string(notice.text)); }, &shown_),
      link_(std::make_shared<HandLink>()) {
  link_->taker = &desk_;
}

Result<std::unique_ptr<HandLayer>> HandLayer::open(const Options& options, Clock& clock) {
  std::unique_ptr<HandLayer> layer(new HandLayer(options.rig, clock));
  layer->desk_.share_tempo(options.tempo);
  FL_TRY(layer->listen(options.socket));
  return layer;
}

HandLayer::~HandLayer() {
  server_.reset();
  leave();
  link_->taker = nullptr;
}

Status HandLayer::listen(const std::string& socket) {
  if (socket == "none" || socket.empty()) return {};
  const auto handler = [this](const HttpRequest& request) { return answer(request); };
  const auto open_at = [&](const std::string& path) -> Status {
    FL_ASSIGN(server_, HttpServer::listen("--socket", "unix:" + path, handler));
    socket_ = path;
    return {};
  };
  if (socket != "auto") return open_at(socket);
  const std::string folder = make_socket_folder();
  if (folder.empty()) return {};
  // Several windows on one machine: the first has the plain name.
  if (open_at(fmt::format("{}/{}", folder, kPreviewSocketName))) return {};
  if (const Status opened = open_at(fmt::format("{}/preview-{}.sock", folder, getpid())); !opened) {
    note(fmt::format("no socket for 'footlight set': {}; name one with --socket FILE", opened.error().message));
  }
  return {};
}

HttpAnswer HandLayer::answer(const HttpRequest& request) {
  const std::lock_guard lock(pages_mutex_);
  if (pages_) return pages_->answer(request);
  return {.status = 503,
          .body = "nothing drives levels now: inputs are being opened, or no fixture has an address; try again, or "
                  "patch one\n"};
}

void HandLayer::show_pages(Pump& pump) {
  const std::lock_guard lock(pages_mutex_);
  pages_ = std::make_unique<StatusPages>(pump, clock_);
  pages_->hand = &desk_;
  pages_->rig = rig_;
}

std::vector<Source*> HandLayer::ports() const {
  std::vector<Source*> ports;
  for (const auto& control : controls_) ports.push_back(control.get());
  return ports;
}

void HandLayer::join(LiveLevels& live) {
  leave();
  enter(live.pump());
}

void HandLayer::enter(Pump& pump) {
  joined_ = &pump;
  desk_.join(pump, ports());
  show_pages(pump);
}

// Returns when the pump's thread has begun another turn, and ended the one before.
void HandLayer::finish_turn(Pump& pump) {
  const auto done = std::make_shared<std::promise<void>>();  // set_value() may still run after the wait
  pump.call([done] { done->set_value(); });
  done->get_future().wait();
}

Status HandLayer::rest_on(std::string name, std::span<const Universe> universes, std::span<const std::uint8_t> levels) {
  const bool same = own_ != nullptr && feed_->name() == name &&
                    std::equal(universes.begin(), universes.end(), fed_.begin(), fed_.end());
  if (same) return {};
  leave();
  if (universes.empty()) return {};
  auto feed = std::make_unique<BaseFeed>(std::move(name), universes);
  feed_ = feed.get();
  fed_.assign(universes.begin(), universes.end());
  const bool known = levels.size() == universes.size() * kSlotCountMax;
  if (known && feed->give(clock_.now_ns(), levels)) feed->hurry();
  std::vector<std::unique_ptr<Source>> sources;
  sources.push_back(std::move(feed));
  FL_ASSIGN(own_, LiveLevels::start(universes, std::move(sources), clock_));
  // A job of a turn comes before its frames: after the second one those of the first turn are merged.
  for (int turn = 0; known && turn < 2; ++turn) finish_turn(own_->pump());
  enter(own_->pump());
  return {};
}

void HandLayer::leave() {
  if (joined_ == nullptr) return;
  {
    const std::lock_guard lock(pages_mutex_);  // waits for an answer that needs the pump
    pages_.reset();
  }
  desk_.leave(ports());
  joined_ = nullptr;
  feed_ = nullptr;
  own_.reset();
}

void HandLayer::add_control(std::unique_ptr<Source> port) {
  if (joined_ != nullptr) {
    joined_->call([pump = joined_, added = port.get()] { pump->add_source(*added); });
  }
  controls_.push_back(std::move(port));
}

void HandLayer::remove_control(const std::string& name) {
  const auto at =
      std::find_if(controls_.begin(), controls_.end(), [&](const auto& one) { return one->name() == name; });
  if (at == controls_.end()) return;
  if (joined_ != nullptr) {
    const auto done = std::make_shared<std::promise<void>>();  // set_value() may still run after the wait
    joined_->call([pump = joined_, gone = at->get(), done] {
      pump->remove_source(*gone);
      done->set_value();
    });
    done->get_future().wait();
  }
  controls_.erase(at);
}

void HandLayer::follow(std::span<const Universe> universes, std::span<const std::uint8_t> levels) {
  shown_.take();
  if (own_ == nullptr) return;
  own_->take();
  const bool fits = std::equal(universes.begin(), universes.end(), fed_.begin(), fed_.end());
  if (fits && feed_->give(clock_.now_ns(), levels)) joined_->call([feed = feed_] { feed->hurry(); });
}

void HandLayer::overlay(std::span<const Universe> universes, std::span<std::uint8_t> levels) const {
  if (own_ != nullptr) shown_.overlay(universes, levels, kPriorityDefault);
}

void HandLayer::darken(std::span<const Universe> universes, std::span<std::uint8_t> levels) const {
  shown_.darken(universes, levels);
}

void HandLayer::note(std::string text) {
  const std::lock_guard lock(mutex_);
  if (notices_.size() == kHandNoticesMax) notices_.erase(notices_.begin());
  notices_.push_back(std::move(text));
}

std::vector<std::string> HandLayer::notices() {
  std::vector<std::string> news;
  {
    const std::lock_guard lock(mutex_);
    news.swap(notices_);
  }
  if (own_ == nullptr) return news;
  for (std::string& notice : own_->notices()) news.push_back(std::move(notice));
  return news;
}

void HandLayer::command(HandAction action) {
  if (joined_ == nullptr) return note("nothing drives levels now; patch a fixture first");
  joined_->call([this, action] {
    if (const Status done = desk_.take({.action = action, .levels = {}}, clock_.now_ns()); !done) {
      note(done.error().message);
    }
  });
}

}  // namespace footlight::tools
