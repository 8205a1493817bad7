#include "tools/footlight/preview/live_outputs.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "drivers/wait/epoll_waiter.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kOutputNoticesMax = 64;
static_assert(OutputFeed::kSilenceMaxNs == 2'500 * kNsPerMs);  // as messages, here and of blackout_words(), say

bool has(std::span<const Universe> ascending, Universe universe) {
  return std::binary_search(ascending.begin(), ascending.end(), universe);
}

std::vector<Universe> without(std::span<const Universe> universes, std::span<const Universe> ascending) {
  std::vector<Universe> rest;
  std::copy_if(universes.begin(), universes.end(), std::back_inserter(rest),
               [&](Universe universe) { return !has(ascending, universe); });
  return rest;
}

template <class T>
bool ready(const std::future<T>& future) {
  return future.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
}

// What a change of darkness is told with; empty: nothing. Those of the dead man's switch are in the band.
std::string words_of(Darkness now, Darkness before) {
  switch (now) {
    case Darkness::kAsked: return "blackout of outputs: all that are armed send zeros";
    case Darkness::kSilence: return "blackout of outputs: the window gave no levels for 2.5 s; Shift+B ends it";
    case Darkness::kNotHeld: return "";
    case Darkness::kNone: return before == Darkness::kNotHeld ? "" : "the blackout of outputs has ended";
  }
  return "";
}

Status check_kind(const Endpoint& endpoint) {
  const bool input = endpoint.kind == EndpointKind::kGpio || endpoint.kind == EndpointKind::kControl ||
                     endpoint.scheme == "audio" || plays_pattern(endpoint);
  if (input) {
    return fail(ErrorCode::kBadInput, "--output {}: this is an input; use --in, or 'footlight run --in'",
                endpoint.text);
  }
  if (endpoint.kind == EndpointKind::kPicture && endpoint.target == "window") {
    return fail(ErrorCode::kBadInput, "--output {}: a window of its own is for 'footlight run --out {}'", endpoint.text,
                endpoint.text);
  }
  return {};
}

}  // namespace

Status check_outputs(std::span<const std::string> texts) {
  for (std::size_t i = 0; i < texts.size(); ++i) {
    FL_ASSIGN(const Endpoint endpoint, parse_port(texts[i]));
    FL_TRY(check_kind(endpoint));
    if (std::find(texts.begin(), texts.begin() + static_cast<std::ptrdiff_t>(i), texts[i]) !=
        texts.begin() + static_cast<std::ptrdiff_t>(i)) {
      return fail(ErrorCode::kBadInput, "--output {}: named twice; expected it once", texts[i]);
    }
  }
  return {};
}

std::optional<std::string> moved_endpoint(const Endpoint& endpoint, Universe to) {
  if (endpoint.kind != EndpointKind::kDevice || endpoint.universes.size() != 1) return std::nullopt;
  const std::string text = endpoint.text.substr(0, endpoint.text.rfind('='));
  return fmt::format("{}={}", text, to);
}

Result<OutputPlan> plan_outputs(std::span<const std::string> texts, const PreviewScene& scene) {
  FL_TRY(check_outputs(texts));
  OutputPlan plan;
  plan.universes = scene.own_universes;
  const auto& own = scene.own_universes;
  for (const std::string& text : texts) {
    FL_ASSIGN(Endpoint endpoint, parse_port(text));
    if (scene.written) {
      return fail(
          ErrorCode::kBadInput,
          "--output {}: this rig shows what VR Stage Lighting makes of its levels, which real lamps do not get; "
          "use 'footlight run --out {}'",
          text, text);
    }
    if (own.empty()) {
      return fail(
          ErrorCode::kBadInput,
          "--output {}: no fixture of this rig has an address, and the made-up ones of its faders are not sent; "
          "give the fixtures addresses (key F3, or 'footlight rig edit')",
          text);
    }
    std::vector<Universe> universes = endpoint.show_universes();
    if (universes.empty()) universes = own;  // a log
    std::sort(universes.begin(), universes.end());
    const std::vector<Universe> left_out = without(universes, own);
    if (left_out.size() == universes.size()) {
      return fail(ErrorCode::kBadInput,
                  "--output {}: the fixtures of this rig have addresses in universe {}, and this output carries {}",
                  text, show_universes(own), show_universes(universes));
    }
    if (!left_out.empty()) {
      const bool made_up = std::any_of(left_out.begin(), left_out.end(),
                                       [&](Universe universe) { return has(scene.compiled.universes, universe); });
      plan.warnings.push_back(
          fmt::format("--output {}: universe {} is not sent: no fixture of this rig has an address "
                      "there{}",
                      text, show_universes(left_out), made_up ? ", but the made-up ones of the faders" : ""));
    }
    plan.outputs.push_back({std::move(endpoint), std::move(universes)});
  }
  return plan;
}

std::vector<PluggedDevice> plugged_devices(const drivers::DeviceList& list) {
  std::vector<PluggedDevice> plugged;
  for (const drivers::FoundDevice& device : list.devices) {
    PluggedDevice& one = plugged.emplace_back();
    one.endpoint = device.endpoint;
    one.model = printable_line(device.model_name);
    one.state = drivers::name_of(device.readiness);
    const bool ready = device.readiness == drivers::Readiness::kReady;
    one.can_send = ready && !device.endpoint.empty() && (device.capabilities & drivers::kCanOutput) != 0;
    if (!ready) one.fix = device.remedy.empty() ? device.reason : fmt::format("{}: {}", device.reason, device.remedy);
  }
  return plugged;
}

Result<std::unique_ptr<LiveOutputs>> LiveOutputs::start(OutputPlan plan, Open open, Clock& clock) {
  std::unique_ptr<LiveOutputs> live(new LiveOutputs());
  live->clock_ = &clock;
  live->open_ = std::move(open);
  std::vector<Universe> universes = plan.universes;
  for (PlannedOutput& planned : plan.outputs) {
    universes.insert(universes.end(), planned.universes.begin(), planned.universes.end());
    live->keep(std::move(planned));
  }
  FL_ASSIGN(live->universes_, Universes::make(universes));
  FL_ASSIGN(live->waiter_, drivers::EpollWaiter::make());
  live->feed_ = std::make_unique<OutputFeed>(live->universes_->numbers());
  PumpOptions options;
  options.on_notice = [self = live.get()](const Notice& notice) { self->note(std::string(notice.text)); };
  live->pump_ = std::make_unique<Pump>(*live->universes_, clock, *live->waiter_, options);
  live->pump_->add_source(*live->feed_);
  const NoSignals for_the_thread;
  live->thread_ = std::jthread([self = live.get()](const std::stop_token& stop) {
    const std::stop_callback stop_pump(stop, [self] { self->pump_->request_stop(); });
    self->pump_->run();
  });
  return live;
}

// The pump closes its sinks first: an output that takes long to open does not keep lamps lit.
LiveOutputs::~LiveOutputs() {
  if (!thread_.joinable()) return;
  thread_.request_stop();
  thread_.join();
}

Status LiveOutputs::check(const PlannedOutput& planned) const {
  const std::string& text = planned.endpoint.text;
  for (const Output& other : outputs_) {
    if (other.plan.endpoint.text == text) return fail(ErrorCode::kBadInput, "{}: it is in the list already", text);
  }
  const std::vector<Universe> unknown = without(planned.universes, universes_->numbers());
  if (!unknown.empty()) {
    return fail(
        ErrorCode::kBadInput,
        "{}: the rig did not use universe {} when its first output was added; start the window with --output {}", text,
        show_universes(unknown), text);
  }
  return {};
}

Status LiveOutputs::add(PlannedOutput planned) {
  FL_TRY(check(planned));
  keep(std::move(planned));
  return {};
}

void LiveOutputs::keep(PlannedOutput planned) {
  Output& output = outputs_.emplace_back();
  output.id = next_id_++;
  output.plan = std::move(planned);
}

LiveOutputs::Output* LiveOutputs::find(OutputId id) {
  const auto at = std::find_if(outputs_.begin(), outputs_.end(), [&](const Output& one) { return one.id == id; });
  return at == outputs_.end() ? nullptr : &*at;
}

Status LiveOutputs::replace(OutputId id, PlannedOutput planned) {
  Output* const output = find(id);
  if (output == nullptr) {
    return fail(ErrorCode::kNotFound, "{}: the output was removed meanwhile; add it again", planned.endpoint.text);
  }
  if (output->state != ArmState::kOff) {
    return fail(ErrorCode::kBadInput, "{}: disarm it before it gets another universe", output->plan.endpoint.text);
  }
  FL_TRY(check(planned));
  output->plan = std::move(planned);
  output->trouble.clear();
  return {};
}

void LiveOutputs::give(std::span<const Universe> universes, std::span<const std::uint8_t> levels,
                       std::span<const Universe> sendable) {
  sendable_.assign(sendable.begin(), sendable.end());
  feed_->give(clock_->now_ns(), universes, levels, sendable);
}

void LiveOutputs::arm(OutputId id) {
  Output* const output = find(id);
  if (output == nullptr || output->state != ArmState::kOff || output->removing) return;
  output->state = ArmState::kOpening;
  output->cancelled = false;
  output->trouble.clear();
  const NoSignals for_the_thread;
  output->opening = std::async(std::launch::async, [this, plan = output->plan] { return open_(plan); });
}

void LiveOutputs::take_opened(Output& output) {
  Result<std::unique_ptr<Sink>> opened = output.opening.get();
  output.state = ArmState::kOff;
  const std::string& name = output.plan.endpoint.text;
  if (!opened) {
    output.trouble = opened.error().message;
    note(fmt::format("not armed: {}", output.trouble));
    return;
  }
  if (output.cancelled) return;  // it ends without having sent anything
  output.sink = ending_dark(std::move(*opened), name);
  output.state = ArmState::kArmed;
  (void)pump_->latest_status();  // requests the first one
  pump_->call([this, sink = output.sink.get()] {
    feed_->count_armed(1);
    pump_->add_sink(*sink);
  });
  note(fmt::format("{}: armed: it sends {}the levels of the picture {}", name,
                   needs_hold_ ? "zeros until End is held, then " : "",
                   is_made_up(output.plan.endpoint) ? "to no lamp, since it is made up" : "to real lamps"));
}

void LiveOutputs::disarm(OutputId id) {
  Output* const output = find(id);
  if (output == nullptr) return;
  if (output->state == ArmState::kOpening) output->cancelled = true;
  if (output->state != ArmState::kArmed) return;
  output->state = ArmState::kClosing;
  const auto closed = std::make_shared<std::promise<void>>();
  output->closing = closed->get_future();
  pump_->call([this, sink = std::move(output->sink), closed]() mutable {
    pump_->remove_sink(*sink);
    sink.reset();
    feed_->count_armed(-1);
    closed->set_value();
  });
  note(fmt::format("{}: disarmed: it ends with zeros", output->plan.endpoint.text));
}

void LiveOutputs::remove(OutputId id) {
  Output* const output = find(id);
  if (output == nullptr) return;
  output->removing = true;
  disarm(id);
}

void LiveOutputs::black_out() {
  feed_->black_out();
  pump_->call([this] { feed_->hurry(); });
}

void LiveOutputs::lift() {
  feed_->lift(clock_->now_ns());
  pump_->call([this] { feed_->hurry(); });
}

void LiveOutputs::need_hold(bool on) {
  const Darkness before = darkness();
  needs_hold_ = on;
  feed_->need_hold(on);
  if (darkness() != before) pump_->call([this] { feed_->hurry(); });
}

void LiveOutputs::hold(bool held) {
  const Darkness before = darkness();
  feed_->hold(clock_->now_ns(), held);
  if (darkness() != before) pump_->call([this] { feed_->hurry(); });
}

void LiveOutputs::follow(OutputsView& view) {
  for (const OutputId id : std::exchange(view.arm, {})) arm(id);
  for (const OutputId id : std::exchange(view.disarm, {})) disarm(id);
  for (const OutputId id : std::exchange(view.remove, {})) remove(id);
  if (const auto blackout = std::exchange(view.blackout, std::nullopt)) *blackout ? black_out() : lift();
  need_hold(view.needs_hold);

  const bool any_armed =
      std::any_of(outputs_.begin(), outputs_.end(), [](const Output& one) { return one.state == ArmState::kArmed; });
  const PumpStatus status = any_armed ? pump_->latest_status() : PumpStatus{};
  for (Output& output : outputs_) {
    if (output.state == ArmState::kOpening && ready(output.opening)) take_opened(output);
    if (output.state == ArmState::kClosing && ready(output.closing)) output.state = ArmState::kOff;
  }
  std::erase_if(outputs_, [](const Output& one) { return one.removing && one.state == ArmState::kOff; });
  view.rows.resize(outputs_.size());
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    Output& output = outputs_[i];
    OutputRow& row = view.rows[i];
    row.id = output.id;
    row.leaves = output.removing;
    row.endpoint = output.plan.endpoint.text;
    row.universes = output.plan.universes;
    row.can_move = output.state == ArmState::kOff && moved_endpoint(output.plan.endpoint, 1).has_value();
    row.made_up = is_made_up(output.plan.endpoint);
    row.left_out = without(output.plan.universes, sendable_);
    row.state = output.state;
    row.trouble = output.trouble;
    row.status.reset();
    if (output.state != ArmState::kArmed) continue;
    const auto port = std::find_if(status.ports.begin(), status.ports.end(),
                                   [&](const PortStatus& one) { return one.is_sink && one.name == row.endpoint; });
    if (port != status.ports.end()) row.status = *port;
  }
  view.darkness = darkness();
  if (const Darkness before = std::exchange(noted_, view.darkness); view.darkness != before) {
    if (std::string words = words_of(noted_, before); !words.empty()) note(std::move(words));
  }
}

void LiveOutputs::note(std::string text) {
  const std::lock_guard lock(mutex_);
  if (notices_.size() == kOutputNoticesMax) notices_.erase(notices_.begin());
  notices_.push_back(std::move(text));
}

std::vector<std::string> LiveOutputs::notices() {
  const std::lock_guard lock(mutex_);
  return std::exchange(notices_, {});
}

bool end_without_outputs(std::unique_ptr<LiveOutputs>& outputs, OutputsView& view) {
  if (!outputs || !outputs->empty()) return false;
  outputs.reset();
  view.rows.clear();
  view.darkness = Darkness::kNone;
  view.notice.clear();
  view.blackout.reset();
  return true;
}

}  // namespace footlight::tools
