// footlight discover: lists senders and receivers that announce themselves on the network.
//
// Each protocol is a Finder; discover() polls all of them until the time is over and prints what they found.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <poll.h>
#include <unistd.h>

#include "drivers/net/artnet_nodes.h"
#include "drivers/net/artnet_sink.h"
#include "drivers/net/port_holders.h"
#include "drivers/net/sacn_discovery.h"
#include "drivers/net/sender_names.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/duration.h"
#include "tools/footlight/status/json_lines.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/status/status_text.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

// Searches with one protocol.
class Finder {
 public:
  virtual ~Finder() = default;
  // Readable when poll() has something to do.
  [[nodiscard]] virtual int poll_fd() const = 0;
  // Called when the descriptor is readable, and every 100 ms.
  virtual Status poll(TimeNs now_ns) = 0;
  [[nodiscard]] virtual std::vector<NetworkFinding> findings() = 0;
};

struct Options {
  DurationNs listen_ns = 12 * kNsPerS;  // sACN senders announce themselves every 10 s
  std::vector<std::string> interface_names;
  bool json = false;
};

std::string text_of_cid(const drivers::Cid& cid) {
  std::string text;
  for (std::size_t i = 0; i < cid.size(); ++i) {
    text += fmt::format("{}{:02x}", i == 4 || i == 6 || i == 8 || i == 10 ? "-" : "", cid[i]);
  }
  return text;
}

class SacnFinder final : public Finder {
 public:
  static Result<std::unique_ptr<Finder>> make(const Options& options) {
    drivers::SacnDiscoveryOptions sacn;
    sacn.interface_names = options.interface_names;
    FL_ASSIGN(auto source, drivers::SacnDiscoverySource::create(sacn));
    std::unique_ptr<Finder> finder(new SacnFinder(std::move(source)));
    return finder;
  }
  [[nodiscard]] int poll_fd() const override { return source_->poll_fd(); }
  Status poll(TimeNs now_ns) override {
    class NoReceiver final : public FrameReceiver {
      void receive(const FrameView&) override {}
    } no_receiver;
    FL_TRY(source_->poll(now_ns, no_receiver));
    source_->directory().expire(now_ns);
    return {};
  }
  [[nodiscard]] std::vector<NetworkFinding> findings() override {
    std::vector<NetworkFinding> found;
    for (const auto& sender : source_->directory().list()) {
      NetworkFinding one;
      one.protocol = "sacn";
      one.name = drivers::SenderNames::printable(sender.name);
      one.address = drivers::text_of_ipv4(sender.ipv4);
      one.id = text_of_cid(sender.cid);
      one.sends = sender.universes;
      one.complete = sender.pages == sender.pages_wanted;
      found.push_back(std::move(one));
    }
    return found;
  }

 private:
  explicit SacnFinder(std::unique_ptr<drivers::SacnDiscoverySource> source) : source_(std::move(source)) {}
  std::unique_ptr<drivers::SacnDiscoverySource> source_;
};

// Sends polls as an Art-Net output does, and nothing else.
class ArtnetFinder final : public Finder {
 public:
  static Result<std::unique_ptr<Finder>> make(const Options& options) {
    drivers::ArtnetSinkOptions artnet;
    artnet.name = "artnet discovery";
    artnet.universes = {{1, 1}};
    artnet.interface_names = options.interface_names;
    artnet.unsubscribed = drivers::ArtnetUnsubscribed::kSilent;
    artnet.own_senders = std::make_shared<drivers::OwnSenders>();
    FL_ASSIGN(auto sink, drivers::ArtnetSink::create(artnet));
    return std::unique_ptr<Finder>(new ArtnetFinder(std::move(sink), artnet.own_senders));
  }
  [[nodiscard]] int poll_fd() const override { return sink_->poll_fd(); }
  Status poll(TimeNs now_ns) override { return sink_->poll(now_ns); }
  [[nodiscard]] std::vector<NetworkFinding> findings() override {
    std::vector<NetworkFinding> found;
    for (const auto& node : program_->artnet().nodes.list()) {
      NetworkFinding one;
      one.protocol = "artnet";
      one.name = node.long_name.empty() ? node.short_name : node.long_name;
      one.address = drivers::text_of_ipv4(node.ipv4);
      for (const std::uint8_t octet : node.mac) one.id += fmt::format("{}{:02x}", one.id.empty() ? "" : ":", octet);
      for (const int port_address : node.inputs) one.sends.push_back(drivers::artnet_wire_universe(port_address));
      for (const int port_address : node.outputs) one.receives.push_back(drivers::artnet_wire_universe(port_address));
      found.push_back(std::move(one));
    }
    return found;
  }

 private:
  ArtnetFinder(std::unique_ptr<drivers::ArtnetSink> sink, std::shared_ptr<drivers::OwnSenders> program)
      : sink_(std::move(sink)), program_(std::move(program)) {}
  std::unique_ptr<drivers::ArtnetSink> sink_;
  std::shared_ptr<drivers::OwnSenders> program_;
};

// `interface_names`: those of the command line. Without them `run` uses the same interfaces as this command.
void print(const NetworkFinding& found, std::span<const std::string> interface_names) {
  fmt::print("{:<7} {:<15}  {}\n", found.protocol, found.address, found.name.empty() ? "(no name)" : found.name);
  if (!found.sends.empty()) {
    fmt::print("  sends:    {}{}\n", show_universes(found.sends), found.complete ? "" : ", and more (list incomplete)");
    std::string interfaces;
    for (const std::string& name : interface_names) interfaces += (interfaces.empty() ? "%" : ",") + name;
    fmt::print("  try:      footlight run --in {}:{}{} --out mock:enttec-pro\n", found.protocol,
               show_universes(found.sends), printable_line(interfaces));
  } else if (found.receives.empty()) {
    fmt::print("  sends:    nothing at the moment\n");
  }
  if (!found.receives.empty()) fmt::print("  receives: {}\n", show_universes(found.receives));
}

// The interfaces that are used, and those that are not, with the reason.
struct Reach {
  std::string on;
  std::string not_on;
};

Reach reach_of(const Options& options) {
  Reach reach;
  std::vector<std::string> known;
  for (const drivers::Interface& one : drivers::list_interfaces()) {
    if (std::find(known.begin(), known.end(), one.name) != known.end()) continue;  // its second address
    known.push_back(one.name);
    const auto& names = options.interface_names;
    const bool named = std::find(names.begin(), names.end(), one.name) != names.end();
    const char* const why = named                            ? ""
                            : !names.empty()                 ? "not selected"
                            : !one.up                        ? "down"
                            : one.loopback || !one.multicast ? "no multicast"
                                                             : "";
    if (*why == '\0') {
      reach.on += (reach.on.empty() ? "" : ", ") + one.name;
    } else {
      reach.not_on += fmt::format("{}{} ({})", reach.not_on.empty() ? "" : ", ", one.name, why);
    }
  }
  return reach;
}

std::size_t count_findings(const std::vector<std::unique_ptr<Finder>>& finders) {
  std::size_t count = 0;
  for (const auto& finder : finders) count += finder->findings().size();
  return count;
}

// One line that is rewritten on a terminal: the remaining time and the number of findings.
class Countdown {
 public:
  explicit Countdown(bool shown) : rewrites_(shown && isatty(STDERR_FILENO) != 0) {}
  ~Countdown() {
    if (shown_s_ >= 0) fmt::print(stderr, "\r\033[K");
  }
  Countdown(const Countdown&) = delete;
  Countdown& operator=(const Countdown&) = delete;

  void show(DurationNs left_ns, const std::vector<std::unique_ptr<Finder>>& finders) {
    const DurationNs left_s = (left_ns + kNsPerS - 1) / kNsPerS;
    if (!rewrites_ || left_s == shown_s_) return;
    shown_s_ = left_s;
    fmt::print(stderr, "\rfootlight: {} s left, {} found\033[K", left_s, count_findings(finders));
  }

 private:
  const bool rewrites_;
  DurationNs shown_s_ = -1;
};

// Reasons why an existing sender is not in the list.
void print_hints(const Reach& reach) {
  fmt::print(stderr,
             "footlight: no sender or node answered; a sender without announcements can still be received: "
             "'footlight run --in sacn:1 --out mock:enttec-pro'\n");
  if (!reach.not_on.empty()) {
    fmt::print(stderr, "footlight: not searched on {}; select an interface with --interface NAME\n", reach.not_on);
  }
}

void print_other_program() {
  const auto holders = drivers::other_holders(drivers::kArtnetPort);
  if (holders.empty()) return;
  fmt::print(stderr,
             "footlight: {} has UDP port {} open and gets the answers of Art-Net devices to this machine; stop it to "
             "see all devices\n",
             printable_line(holders.front().description), drivers::kArtnetPort);
}

Result<int> discover(const Options& options) {
  std::vector<std::unique_ptr<Finder>> finders;
  FL_ASSIGN(auto sacn, SacnFinder::make(options));
  finders.push_back(std::move(sacn));
  if (auto artnet = ArtnetFinder::make(options)) {
    finders.push_back(std::move(*artnet));
  } else {
    fmt::print(stderr, "footlight: Art-Net is not searched: {}\n", artnet.error().message);
  }

  StopSignal signal;
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + options.listen_ns;
  const Reach reach = reach_of(options);
  if (!options.json) {
    fmt::print(stderr, "footlight: searching for {} on {}\n", show_duration(options.listen_ns),
               reach.on.empty() ? "no interface" : reach.on);
    print_other_program();
  }
  std::vector<pollfd> waiting;
  for (const auto& finder : finders) waiting.push_back({finder->poll_fd(), POLLIN, 0});
  std::optional<Countdown> countdown(std::in_place, !options.json);
  for (TimeNs now_ns = clock.now_ns(); now_ns < end_ns && !signal.came(); now_ns = clock.now_ns()) {
    countdown->show(end_ns - now_ns, finders);
    const DurationNs left_ms = (end_ns - now_ns) / kNsPerMs + 1;
    (void)::poll(waiting.data(), waiting.size(), static_cast<int>(std::min<DurationNs>(left_ms, 100)));
    for (const auto& finder : finders) FL_TRY(finder->poll(clock.now_ns()));
  }
  countdown.reset();
  bool any = false;
  for (const auto& finder : finders) {
    for (const NetworkFinding& found : finder->findings()) {
      any = true;
      if (options.json) {
        fmt::print("{}\n", json_of_finding(found));
      } else {
        print(found, options.interface_names);
      }
    }
  }
  if (any) return kExitOk;
  print_hints(reach);
  return kExitNotFound;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.duration("--for", options->listen_ns,
                     "how long to search [12s]; sACN senders announce themselves every 10 s");
  arguments.list("--interface", options->interface_names, "NAME",
                 "search only on this interface; may be given several times");
  arguments.flag("--json", options->json, "one JSON object a line for each finding");
  arguments.job([options]() -> Result<int> { return discover(*options); });
}

}  // namespace

extern const CommandInfo discover_command{
    .name = "discover",
    .help = "List senders and receivers on the network and their universes",
    .examples =
        "  footlight discover\n"
        "  footlight discover --for 25s --interface eth1\n"
        "  footlight discover --json | jq -r '[.name, .address] | @tsv'\n"
        "Lists sACN senders by their announcements, and Art-Net devices by their answers to ArtPoll (sent every 3 s "
        "at\n"
        "most). Nothing else is sent, and other programs lose no packets. Exit code 3 if nothing was found.",
    .add = add,
};

}  // namespace footlight::tools
