// footlight discover: who sends what on the network, as the senders themselves tell.
//
// Each protocol is a Finder; discover() turns all of them until the time is up and prints what they found.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include <poll.h>

#include "drivers/net/sacn_discovery.h"
#include "drivers/net/sender_names.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/json_lines.h"
#include "tools/footlight/status_text.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

// Listens for one protocol.
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
  DurationNs listen_ns = 12 * kNsPerS;  // sACN senders tell every 10 s
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
    drivers::SacnDiscoveryOptions wanted;
    wanted.interface_names = options.interface_names;
    FL_ASSIGN(auto source, drivers::SacnDiscoverySource::create(wanted));
    std::unique_ptr<Finder> finder(new SacnFinder(std::move(source)));
    return finder;
  }
  [[nodiscard]] int poll_fd() const override { return source_->poll_fd(); }
  Status poll(TimeNs now_ns) override {
    class Nobody final : public FrameReceiver {
      void receive(const FrameView&) override {}
    } nobody;
    FL_TRY(source_->poll(now_ns, nobody));
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

void print(const NetworkFinding& found) {
  fmt::print("{:<7} {:<15}  {}\n", found.protocol, found.address, found.name.empty() ? "(no name)" : found.name);
  if (!found.sends.empty()) {
    fmt::print("  sends: {}{}\n", show_universes(found.sends), found.complete ? "" : ", and more that did not come");
    fmt::print("  hear:  footlight run --in {}:{} --out mock:enttec-pro\n", found.protocol,
               show_universes(std::span(found.sends).first(1)));
  } else if (found.receives.empty()) {
    fmt::print("  sends: nothing at the moment\n");
  }
  if (!found.receives.empty()) fmt::print("  takes: {}\n", show_universes(found.receives));
}

Result<int> discover(const Options& options) {
  std::vector<std::unique_ptr<Finder>> finders;
  FL_ASSIGN(auto sacn, SacnFinder::make(options));
  finders.push_back(std::move(sacn));

  StopSignal signal;
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + options.listen_ns;
  if (!options.json) {
    fmt::print(stderr, "footlight: listening for {:.0f} s\n", static_cast<double>(options.listen_ns) / kNsPerS);
  }
  std::vector<pollfd> waiting;
  for (const auto& finder : finders) waiting.push_back({finder->poll_fd(), POLLIN, 0});
  for (TimeNs now_ns = clock.now_ns(); now_ns < end_ns && !signal.came(); now_ns = clock.now_ns()) {
    const DurationNs left_ms = (end_ns - now_ns) / kNsPerMs + 1;
    (void)::poll(waiting.data(), waiting.size(), static_cast<int>(std::min<DurationNs>(left_ms, 100)));
    for (const auto& finder : finders) FL_TRY(finder->poll(clock.now_ns()));
  }
  bool any = false;
  for (const auto& finder : finders) {
    for (const NetworkFinding& found : finder->findings()) {
      any = true;
      if (options.json) {
        fmt::print("{}\n", json_of_finding(found));
      } else {
        print(found);
      }
    }
  }
  if (any) return kExitOk;
  fmt::print(stderr,
             "footlight: nobody has told what they send; a sender that does not announce itself is heard all the same: "
             "'footlight run --in sacn:1 --out mock:enttec-pro'\n");
  return kExitNotFound;
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.duration("--for", options->listen_ns, "how long to listen; senders of sACN tell every 10 s");
  arguments.list("--interface", options->interface_names, "NAME", "listen on this one only; may be given many times");
  arguments.flag("--json", options->json, "one JSON object a sender and line");
  arguments.job([options]() -> Result<int> { return discover(*options); });
}

}  // namespace

extern const CommandInfo discover_command{
    .name = "discover",
    .help = "List who sends what on the network, as the senders tell",
    .examples =
        "  footlight discover\n"
        "  footlight discover --for 25s --interface eth1\n"
        "  footlight discover --json | jq -r '[.name, .address] | @tsv'\n"
        "Sends nothing and takes nothing away from other programs. Exit code 3 where nobody was heard.",
    .add = add,
};

}  // namespace footlight::tools
