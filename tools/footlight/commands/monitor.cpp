// footlight monitor: displays live levels and senders, or the state of a running bridge.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <optional>
#include <thread>

#include <unistd.h>

#include "drivers/wait/epoll_waiter.h"
#include "sim/core/no_signals.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/bridge.h"
#include "tools/footlight/bridge/bridge_sockets.h"
#include "tools/footlight/bridge/event_log.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"
#include "tools/footlight/monitor/monitor_state.h"
#include "tools/footlight/monitor/monitor_view.h"
#include "tools/footlight/monitor/slot_meanings.h"
#include "tools/footlight/monitor/terminal.h"
#include "tools/footlight/status/status_pages.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

struct Options {
  std::vector<std::string> words;  // endpoints
  std::vector<std::string> ins;    // more of them
  std::string socket;
  std::string filter;
  std::string rig;  // that explains slots; empty: none
  std::optional<int> slot;  // an address of it; nothing: the first one
  int columns = 0;
  int rows = 0;
  DurationNs period_ns = 0;
  DurationNs run_for_ns = kTimeNever;
  bool wait_for_device = false;
  bool json = false;
  bool once = false;
};

constexpr DurationNs kPeriodDrawnNs = 100 * kNsPerMs;
constexpr DurationNs kPeriodJsonNs = kNsPerS;
constexpr DurationNs kStatusPeriodNs = kNsPerS / 2;

// A source of status pages.
class Feed {
 public:
  virtual ~Feed() = default;
  [[nodiscard]] virtual Result<std::string> page(const std::string& path, const std::string& universes) = 0;
  [[nodiscard]] virtual std::string title() const = 0;
  // Why some traffic does not arrive here; empty: all of it does.
  [[nodiscard]] virtual std::string note() const { return {}; }
};

// Another program on this machine that runs a bridge.
class SocketFeed final : public Feed {
 public:
  explicit SocketFeed(std::string socket) : socket_(std::move(socket)) {}
  Result<std::string> page(const std::string& path, const std::string& universes) override {
    FL_ASSIGN(HttpAnswer answer,
              http_request(socket_, "GET", universes.empty() ? path : path + "?universes=" + universes));
    if (answer.status != 200) return fail(ErrorCode::kProtocol, "{}: {}: {}", socket_, answer.status, answer.body);
    return std::move(answer.body);
  }
  [[nodiscard]] std::string title() const override { return socket_; }

 private:
  std::string socket_;
};

// The monitor's own pump, with inputs and no outputs.
class OwnFeed final : public Feed {
 public:
  static Result<std::unique_ptr<OwnFeed>> start(const Options& options, Clock& clock) {
    std::unique_ptr<OwnFeed> feed(new OwnFeed);
    PortOpener opener(clock);
    InOptions in;
    in.wait_for_device = options.wait_for_device;
    in.hear_preview = true;
    in.yields = true;  // a bridge keeps its unicast frames
    std::vector<Universe> universes;
    for (const std::string& word : options.words) {
      FL_ASSIGN(const Endpoint endpoint, parse_port(word));
      FL_ASSIGN(std::unique_ptr<Source> source, opener.open_source(endpoint, in));
      universes.insert(universes.end(), source->universes().begin(), source->universes().end());
      feed->title_ += (feed->title_.empty() ? "" : "  ") + source->name();
      while (const auto notice = source->take_notice()) {
        feed->note_ += fmt::format("{}{}: {}", feed->note_.empty() ? "" : "  ", source->name(), notice->text);
      }
      feed->sources_.push_back(std::move(source));
    }
    FL_ASSIGN(std::shared_ptr<Universes> buffer, Universes::make(sorted_once(std::move(universes))));
    FL_ASSIGN(feed->waiter_, drivers::EpollWaiter::make());
    PumpOptions pump_options;
    pump_options.status_period_ns = kStatusPeriodNs;
    feed->pump_ = std::make_unique<Pump>(std::move(buffer), clock, *feed->waiter_, pump_options);
    for (const auto& source : feed->sources_) feed->pump_->add_source(*source);
    feed->pages_ = std::make_unique<StatusPages>(*feed->pump_, clock);
    (void)feed->pump_->latest_status();  // requests the first one
    const NoSignals for_the_thread;
    feed->thread_ = std::jthread([self = feed.get()](const std::stop_token& stop) {
      const std::stop_callback stop_pump(stop, [self] { self->pump_->request_stop(); });
      self->pump_->run();
    });
    return feed;
  }
  Result<std::string> page(const std::string& path, const std::string& universes) override {
    return pages_->answer({.method = "GET", .path = path, .universes = universes}).body;
  }
  [[nodiscard]] std::string title() const override { return title_; }
  [[nodiscard]] std::string note() const override { return note_; }

 private:
  OwnFeed() = default;

  std::string title_;
  std::string note_;
  std::vector<std::unique_ptr<Source>> sources_;
  std::unique_ptr<drivers::EpollWaiter> waiter_;
  std::unique_ptr<Pump> pump_;
  std::unique_ptr<StatusPages> pages_;
  std::jthread thread_;  // last member: ends before the objects that it uses
};

Result<std::unique_ptr<Feed>> open_feed(const Options& options, Clock& clock) {
  if (!options.words.empty()) {
    if (!options.socket.empty()) {
      return fail(ErrorCode::kBadInput,
                  "monitor: expected endpoints to receive from or a --socket to connect to, not both");
    }
    FL_ASSIGN(std::unique_ptr<Feed> feed, OwnFeed::start(options, clock));
    return feed;
  }
  if (options.socket == "none") {
    return fail(ErrorCode::kBadInput,
                "monitor --socket none: a bridge without a socket cannot be watched; start it with --socket auto and "
                "leave out --socket here, or name an input, for example 'footlight monitor sacn:1-9'");
  }
  if (!options.socket.empty()) return std::make_unique<SocketFeed>(options.socket);
  FL_ASSIGN(std::string socket, find_bridge("monitor", ", or name an input, for example 'footlight monitor sacn:1-9'"));
  return std::make_unique<SocketFeed>(std::move(socket));
}

// Universes as a list for a page; empty: all.
std::string listed(const std::vector<Universe>& universes) {
  std::string list;
  for (const Universe universe : universes) list += fmt::format("{}{}", list.empty() ? "" : ",", universe);
  return list;
}

// Updates a state. Errors are part of the display, because a bridge that restarts comes back.
class Watcher {
 public:
  Watcher(Feed& feed, Clock& clock, MonitorState& state) : feed_(feed), clock_(clock), state_(state) {
    state_.title = feed.title();
    state_.note = feed.note();
  }

  void update(const std::string& filter) {
    const Status updated = try_update(filter);
    state_.trouble = updated ? "" : updated.error().message;
  }

 private:
  Status try_update(const std::string& filter) {
    const TimeNs now_ns = clock_.now_ns();
    if (now_ns >= status_ns_) {
      FL_ASSIGN(const std::string status, feed_.page("/status", ""));
      FL_TRY(take_status(state_, status));
      status_ns_ = now_ns + kStatusPeriodNs;
    }
    const auto universes = shown_universes(state_, filter);
    if (universes.empty()) return {};
    FL_ASSIGN(const std::string levels, feed_.page("/levels", filter.empty() ? "" : listed(universes)));
    return take_levels(state_, levels);
  }

  Feed& feed_;
  Clock& clock_;
  MonitorState& state_;
  TimeNs status_ns_ = 0;
};

void step_to(MonitorState& state, MonitorView& view, int by) {
  const auto shown = shown_universes(state, view.filter);
  if (shown.empty()) return;
  const auto at = std::find(shown.begin(), shown.end(), view.selected);
  const auto index = at == shown.end() ? 0 : at - shown.begin();
  const auto last = static_cast<std::ptrdiff_t>(shown.size()) - 1;
  view.selected = shown[static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(index + by, 0, last))];
}

// What the slot of the view is for, with its value.
void explain(const SlotMeanings& meanings, const MonitorState& state, MonitorView& view) {
  const MonitorUniverse* const universe = shown_universe(state, view);
  view.meaning.clear();
  if (!view.explains || universe == nullptr) return;
  LevelMoment now;
  for (const MonitorUniverse& one : state.universes) {
    now.universes.push_back(one.universe);
    now.levels.insert(now.levels.end(), one.levels.begin(), one.levels.end());
  }
  view.meaning = printable_utf8(meanings.words(universe->universe, static_cast<Address>(view.slot + 1), now));
}

// Handles a key. False: quit.
bool press(Key key, const std::string& typed, MonitorState& state, MonitorView& view) {
  if (view.typing) {
    if (key == Key::kText) view.filter += typed;
    if (key == Key::kBackspace && !view.filter.empty()) {
      while ((static_cast<unsigned char>(view.filter.back()) & 0xC0) == 0x80 && view.filter.size() > 1)
        view.filter.pop_back();
      view.filter.pop_back();
    }
    if (key == Key::kEscape) view.filter.clear();
    if (key == Key::kEscape || key == Key::kEnter) view.typing = false;
    return true;
  }
  switch (key) {
    case Key::kUp: step_to(state, view, -1); break;
    case Key::kDown: step_to(state, view, 1); break;
    case Key::kLeft: view.slot = std::max(view.slot - 1, 0); break;
    case Key::kRight: view.slot = std::min(view.slot + 1, kSlotCountMax - 1); break;
    case Key::kPageUp: step_to(state, view, -10); break;
    case Key::kPageDown: step_to(state, view, 10); break;
    case Key::kEscape: view.filter.clear(); break;
    case Key::kText:
      if (typed == "q") return false;
      if (typed == " " || typed == "p") view.paused = !view.paused;
      if (typed == "k") step_to(state, view, -1);
      if (typed == "j") step_to(state, view, 1);
      if (typed == "/") view.typing = true;
      if (typed == "a") view.a = keep_moment(state);
      if (typed == "b" && view.a) view.b = view.b ? std::nullopt : std::optional(keep_moment(state));
      if (typed == "x") view.a = view.b = std::nullopt;
      break;
    case Key::kNone:
    case Key::kEnter:
    case Key::kBackspace: break;
  }
  return true;
}

Result<int> draw(const Options& options, Clock& clock, Watcher& watcher, const SlotMeanings& meanings,
                 MonitorState& state, MonitorView& view) {
  FL_ASSIGN(const std::unique_ptr<Terminal> terminal, Terminal::take());
  const char* const no_colour = std::getenv("NO_COLOR");  // https://no-color.org
  view.colour = no_colour == nullptr || *no_colour == '\0';
  const DurationNs period_ns = options.period_ns != 0 ? options.period_ns : kPeriodDrawnNs;
  const TimeNs end_ns = options.run_for_ns == kTimeNever ? kTimeNever : clock.now_ns() + options.run_for_ns;
  TimeNs next_ns = clock.now_ns();
  while (!terminal->ended() && clock.now_ns() < end_ns) {
    if (clock.now_ns() >= next_ns) {
      if (!view.paused) watcher.update(view.typing ? "" : view.filter);
      next_ns = std::max(next_ns + period_ns, clock.now_ns() + period_ns / 4);
    }
    const TerminalSize size = terminal->size();
    view.columns = size.columns;
    view.rows = size.rows;
    explain(meanings, state, view);
    terminal->show(draw_monitor(state, view));
    const Key key = terminal->wait_for_key(std::max<DurationNs>(std::min(next_ns, end_ns) - clock.now_ns(), 0));
    if (!press(key, terminal->typed(), state, view)) break;
  }
  return kExitOk;
}

// Prints one object or one picture per period on standard output.
Result<int> print(const Options& options, Clock& clock, Watcher& watcher, const SlotMeanings& meanings,
                  MonitorState& state, MonitorView& view) {
  catch_end_signals();
  const DurationNs period_ns = options.period_ns != 0 ? options.period_ns : kPeriodJsonNs;
  TimeNs next_ns = clock.now_ns();
  const TimeNs end_ns = options.run_for_ns == kTimeNever ? kTimeNever : next_ns + options.run_for_ns;
  // The first status with rates is two periods of the pump old.
  if (options.once && !options.words.empty()) {
    watcher.update("");
    next_ns += options.run_for_ns == kTimeNever ? 2 * kStatusPeriodNs + kNsPerS / 10 : options.run_for_ns;
  }
  while (true) {
    while (!end_signal_came() && clock.now_ns() < next_ns) {
      clock.sleep_until_ns(std::min(next_ns, clock.now_ns() + 50 * kNsPerMs));
    }
    if (end_signal_came()) return kExitOk;
    watcher.update(options.filter);
    if (!state.trouble.empty() && options.once) return fail(ErrorCode::kDisconnected, "{}", state.trouble);
    if (options.json) {
      std::fputs((json_of_monitor(state, utc_text(wall_clock_unix_ns(), 6)) + "\n").c_str(), stdout);
    } else {
      explain(meanings, state, view);
      for (const std::string& line : draw_monitor(state, view)) std::fputs((line + "\n").c_str(), stdout);
    }
    if (std::fflush(stdout) != 0 || options.once || next_ns >= end_ns) return kExitOk;
    next_ns += period_ns;
  }
}

Result<int> monitor(const Options& options) {
  if (options.slot && options.rig.empty()) {
    return fail(ErrorCode::kBadInput, "monitor --slot {}: a rig says what it is for; add --rig FILE", *options.slot);
  }
  if (options.json && !options.rig.empty()) {
    return fail(ErrorCode::kBadInput, "monitor --rig {}: --json prints all levels and explains no slot; remove one",
                printable_line(options.rig));
  }
  SystemClock clock;
  FL_ASSIGN(const SlotMeanings meanings, SlotMeanings::of(options.rig));
  FL_ASSIGN(const std::unique_ptr<Feed> feed, open_feed(options, clock));
  MonitorState state;
  MonitorView view;
  view.filter = options.filter;
  view.columns = options.columns;
  view.rows = options.rows;
  view.explains = meanings.has_rig();
  view.slot = options.slot.value_or(1) - 1;
  Watcher watcher(*feed, clock, state);
  if (options.json && !state.note.empty()) fmt::print(stderr, "footlight: {}\n", printable_line(state.note));
  if (options.json || options.once) return print(options, clock, watcher, meanings, state, view);
  return draw(options, clock, watcher, meanings, state, view);
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  options->columns = 80;
  options->rows = 24;
  arguments.words("ENDPOINT", options->words, "inputs to receive from; default: connect to the running bridge");
  arguments.list("--in,-i", options->ins, "ENDPOINT", "the same, as for 'footlight run'");
  arguments.option("--socket", options->socket, "FILE", "the socket of the bridge, if several run");
  arguments.option("--filter", options->filter, "TEXT", "universes (1-9), or a part of a sender's name");
  arguments.option("--rig", options->rig, "FILE",
                   "a rig that says what a slot is for; left and right choose the slot; not with --json");
  arguments.option("--slot", options->slot, 1, kSlotCountMax,
                   "the slot that is explained at the start, with --rig; default: 1");
  arguments.duration("--period", options->period_ns, "update period; default: 100ms on a terminal, else 1s");
  arguments.duration("--for", options->run_for_ns, "end after this time");
  arguments.flag("--wait-for-device", options->wait_for_device, "start even if a device is not plugged in yet");
  arguments.flag("--once", options->once, "print one picture, or one object, and end");
  arguments.option("--columns", options->columns, 1, 1'000, "width of the picture of --once");
  arguments.option("--rows", options->rows, 1, 1'000, "height of the picture of --once");
  arguments.flag("--json", options->json, "one JSON object a line for each period, with all levels");
  arguments.job([options]() -> Result<int> {
    options->words.insert(options->words.end(), options->ins.begin(), options->ins.end());
    return monitor(*options);
  });
}

}  // namespace

extern const CommandInfo monitor_command{
    .name = "monitor",
    .help = "Show live levels, senders and ports, of the network or of the running bridge",
    .examples =
        "  footlight monitor sacn:1-9                 what is on the network\n"
        "  footlight monitor artnet:1-4 enttec-pro=5  several at once\n"
        "  footlight monitor                          the 'footlight run' of this machine, inputs and outputs\n"
        "  footlight monitor sacn:1-9 --json --period 200ms\n"
        "  footlight monitor --once --columns 120     one picture, as text\n"
        "  footlight monitor sacn:1-9 --rig rig.toml  with fixture, attribute and value of a slot\n"
        "Up and down select the universe that is shown in full, space pauses, / filters, q quits.\n"
        "a keeps this moment and marks what differs from it, b keeps the second one, x ends that.\n"
        "Changes of the last second are bright; NO_COLOR=1 turns colours off.",
    .add = add,
};

}  // namespace footlight::tools
