// footlight mvr: rigs from consoles and drawing programs over the network, by MVR-xchange.
#include <algorithm>
#include <array>
#include <cstdio>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <poll.h>
#include <unistd.h>

#include "drivers/net/mvr_xchange_group.h"
#include "drivers/net/mvr_xchange_names.h"
#include "drivers/net/net.h"
#include "sim/file_kind.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/mvr/mvr_exchange.h"
#include "tools/footlight/mvr/mvr_lines.h"
#include "tools/footlight/mvr/received_file.h"
#include "tools/footlight/mvr/shared_file.h"
#include "tools/footlight/status/printable.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

using drivers::MvrAddress;
using drivers::MvrClient;
using drivers::MvrCommit;
using drivers::MvrGroup;
using drivers::MvrStation;

constexpr DurationNs kTickNs = 200 * kNsPerMs;  // for timeouts, and for files that change
constexpr DurationNs kLeaveNs = 2 * kNsPerS;    // for the answers when this program leaves

struct Options {
  std::vector<std::string> stations;  // addresses
  std::string station;                // get: name, UUID or address
  std::string path;                   // share
  std::string out;
  std::string file;
  std::string group;
  std::string name;
  std::string comment;
  int port = 0;
  DurationNs search_ns = 3 * kNsPerS;
  std::optional<DurationNs> share_ns;
  bool json = false;
  bool overwrite = false;
};

Result<std::vector<MvrAddress>> addresses_of(const Options& options) {
  std::vector<MvrAddress> addresses;
  for (const std::string& text : options.stations) {
    FL_ASSIGN(addresses.emplace_back(), drivers::find_mvr_address(text));
  }
  return addresses;
}

// Null if stations are named: then none is searched for.
Result<std::unique_ptr<drivers::MvrDiscovery>> open_discovery(const Options& options) {
  if (!options.stations.empty()) return nullptr;
  return drivers::open_mvr_discovery();
}

// Waits for the descriptors, at most a tick.
void wait_for(std::vector<pollfd>& waiting) {
  (void)::poll(waiting.data(), waiting.size(), static_cast<int>(kTickNs / kNsPerMs));
  waiting.clear();
}

// Sends the leave to all, and waits for the answers.
void leave(MvrGroup& group, drivers::MvrServer* server, Clock& clock) {
  const TimeNs end_ns = clock.now_ns() + kLeaveNs;
  group.leave(clock.now_ns());
  std::vector<pollfd> waiting;
  while (group.busy() && clock.now_ns() < end_ns) {
    group.add_descriptors(waiting);
    if (server != nullptr) server->add_descriptors(waiting);
    wait_for(waiting);
    group.step(clock.now_ns());
    if (server != nullptr) server->step(clock.now_ns());
  }
}

bool names_station(const MvrGroup::Member& member, const std::string& text) {
  return drivers::same_ascii(member.station.name, text) || drivers::same_uuid(member.station.uuid, text) ||
         text_of(member.station.address) == text;
}

bool offers(const MvrGroup::Member& member, const std::string& file_uuid) {
  const auto& commits = member.peer.commits;
  return std::any_of(commits.begin(), commits.end(),
                     [&](const MvrCommit& one) { return drivers::same_uuid(one.file_uuid, file_uuid); });
}

// True: no station that may be found yet changes which one is chosen. Others may have the same name.
bool is_sure(const Options& options, const MvrGroup::Member& member) {
  if (!member.joined) return false;
  const std::string& text = options.station;
  if (!options.file.empty()) return (text.empty() || names_station(member, text)) && offers(member, options.file);
  return !text.empty() && (drivers::same_uuid(member.station.uuid, text) || text_of(member.station.address) == text);
}

// Joins what is there until the time is over. Returns at once when the one that is searched for has answered, or when
// all named stations have.
void search(const Options& options, MvrGroup& group, bool discovers, StopSignal& signal, Clock& clock) {
  const TimeNs end_ns = clock.now_ns() + options.search_ns;
  std::vector<pollfd> waiting;
  while (!signal.came()) {
    group.step(clock.now_ns());
    const auto& members = group.members();
    const bool found =
        std::any_of(members.begin(), members.end(), [&](const auto& one) { return is_sure(options, one); });
    // A station that was found in time has its own timeout for the answer.
    const bool over = !discovers || clock.now_ns() >= end_ns;
    if (over) group.stop_joining();
    if (found || (over && !group.busy())) return;
    group.add_descriptors(waiting);
    wait_for(waiting);
  }
}

// Joins the stations, calls then(group, signal, clock), and leaves them.
template <class Then>
Result<int> among_stations(const Options& options, const char* role, Then then) {
  FL_ASSIGN(const auto addresses, addresses_of(options));
  FL_ASSIGN(const auto discovery, open_discovery(options));
  MvrStation self = own_mvr_station(options.name, role);
  MvrGroup group(self, discovery.get(), options.group, addresses);
  SystemClock clock;
  StopSignal signal;
  search(options, group, discovery != nullptr, signal, clock);
  const Result<int> done = then(group, signal, clock);
  leave(group, nullptr, clock);
  return done;
}

Result<int> list_stations(const Options& options) {
  return among_stations(options, "list", [&](const MvrGroup& group, const StopSignal& signal, Clock&) -> Result<int> {
    bool any = false;
    for (const auto& member : group.members()) {
      fmt::print("{}", options.json ? station_json(member) : station_text(member));
      any = any || member.joined;
    }
    if (any) return kExitOk;
    if (signal.came()) {
      fmt::print(stderr, "footlight: stopped before a station had answered\n");
    } else if (group.members().empty()) {
      fmt::print(stderr,
                 "footlight: no station of MVR-xchange was found; switch it on there, in the same network, or name the "
                 "station with --station ADDRESS:PORT\n");
    }
    return kExitNotFound;
  });
}

// The station that the command line means. Stations that offer the file of --file are alike: the first is chosen.
Result<const MvrGroup::Member*> choose_station(const Options& options, const MvrGroup& group) {
  std::vector<const MvrGroup::Member*> fitting;
  std::string joined;
  std::string troubles;
  for (const auto& member : group.members()) {
    if (!member.joined) {
      if (!member.trouble.empty()) troubles += "\n  " + printable_line(member.trouble);
      continue;
    }
    joined += "\n  " + station_words(member);
    if (!options.station.empty() && !names_station(member, options.station)) continue;
    const bool has_file = options.file.empty() ? !member.peer.commits.empty() : offers(member, options.file);
    if (has_file || (options.file.empty() && !options.station.empty())) fitting.push_back(&member);
  }
  if (fitting.size() == 1 || (!fitting.empty() && !options.file.empty())) return fitting.front();
  if (!fitting.empty()) {
    std::string names;
    for (const auto* const member : fitting) names += "\n  " + station_words(*member);
    return fail(ErrorCode::kBadInput, "several stations fit; name one by its UUID or address:{}{}", names, troubles);
  }
  std::string what = "no station of MVR-xchange was found";
  if (!options.file.empty()) {
    what = fmt::format("--file {}: no station offers it", printable_line(options.file));
  } else if (!options.station.empty()) {
    what = fmt::format("{}: no such station", printable_line(options.station));
  } else if (!joined.empty()) {
    what = "no station offers a file";
  }
  if (!joined.empty()) return fail(ErrorCode::kNotFound, "{}; found:{}{}", what, joined, troubles);
  if (!troubles.empty()) return fail(ErrorCode::kNotFound, "{}:{}", what, troubles);
  return fail(ErrorCode::kNotFound,
              "{}; switch it on there, in the same network, or name the station with --station ADDRESS:PORT", what);
}

// The newest is the last of the list; a station without a list makes one.
MvrCommit choose_commit(const Options& options, const MvrGroup::Member& member) {
  const auto& commits = member.peer.commits;
  if (options.file.empty()) return commits.empty() ? MvrCommit{} : commits.back();
  return *std::find_if(commits.begin(), commits.end(),
                       [&](const MvrCommit& one) { return drivers::same_uuid(one.file_uuid, options.file); });
}

Result<int> receive(const MvrGroup::Member& member, const MvrCommit& commit, const Options& options, StopSignal& signal,
                    Clock& clock) {
  drivers::MvrMessage request;
  request.type = drivers::MvrMessageType::kRequest;
  request.file_uuid = commit.file_uuid;
  if (!member.station.uuid.empty()) request.from_stations = {member.station.uuid};
  ReceivedFile part(options.out, {.overwrite = options.overwrite, .shows = true});
  FL_TRY(part.open());
  FL_ASSIGN(const auto client,
            MvrClient::open(member.station.name, member.station.address, request, clock.now_ns(), &part));
  std::vector<pollfd> waiting;
  while (true) {
    FL_ASSIGN(const bool done, client->step(clock.now_ns()));
    if (done) break;
    if (signal.came()) return fail(ErrorCode::kIo, "{}: stopped; nothing is written", options.out);
    client->add_descriptors(waiting);
    wait_for(waiting);
  }
  if (!client->asking().has_file()) {
    return fail(ErrorCode::kNotFound, "'{}' does not send the file: {}", printable_line(member.station.name),
                printable_line(client->asking().answer().message));
  }
  if (commit.file_bytes != 0 && commit.file_bytes != part.bytes()) {
    fmt::print(stderr, "footlight: the station announced {} bytes and sent {}\n", commit.file_bytes, part.bytes());
  }
  FL_ASSIGN(const std::string rig, part.finish());
  fmt::print("{}  {}  {}\n", printable_line(options.out), size_text(part.bytes()), rig);
  return kExitOk;
}

Result<int> get(Options options) {
  if (options.out.empty()) {
    return fail(ErrorCode::kBadInput, "mvr get: expected -o FILE, for example 'footlight mvr get -o show.mvr'");
  }
  FL_TRY(refuse_pipe_output(options.out));
  FL_TRY(refuse_existing(options.out, options.overwrite));
  // An address needs no search.
  if (options.stations.empty() && options.station.find(':') != std::string::npos) {
    const auto address = drivers::find_mvr_address(options.station);
    if (address) {
      options.stations.push_back(options.station);
      options.station = text_of(*address);
    } else if (address.error().code == ErrorCode::kNotFound) {
      return tl::unexpected(address.error());
    }
  }
  return among_stations(options, "get", [&](const MvrGroup& group, StopSignal& signal, Clock& clock) -> Result<int> {
    if (signal.came()) return fail(ErrorCode::kIo, "{}: stopped; nothing is written", options.out);
    FL_ASSIGN(const auto* member, choose_station(options, group));
    return receive(*member, choose_commit(options, *member), options, signal, clock);
  });
}

// Prints stations when they are joined, and why others are not; each once.
class StationNews {
 public:
  explicit StationNews(bool json) : json_(json) {}
  // True: something was printed.
  bool print(const MvrGroup& group) {
    bool printed = false;
    for (const auto& member : group.members()) {
      std::string& last = last_[text_of(member.station.address)];
      const std::string news = member.joined ? "joined" : member.trouble;
      if (news.empty() || news == last) continue;
      last = news;
      printed = true;
      if (json_) {
        fmt::print("{}", station_json(member, "station"));
      } else if (member.joined) {
        fmt::print("{}", station_text(member));
      } else {
        fmt::print(stderr, "footlight: {}\n", printable_line(member.trouble));
      }
    }
    return printed;
  }

 private:
  const bool json_;
  std::map<std::string, std::string> last_;  // by address
};

// This station in its group, until stopped.
class Part {
 public:
  static Result<std::unique_ptr<Part>> open(const Options& options, const char* name, std::optional<SharedFile> file) {
    FL_ASSIGN(const auto addresses, addresses_of(options));
    std::unique_ptr<Part> part(new Part(options, name, std::move(file)));
    FL_ASSIGN(part->server_, drivers::MvrServer::open({0, static_cast<std::uint16_t>(options.port)}, part->self_));
    if (auto opened = drivers::open_mvr_discovery()) {
      part->discovery_ = std::move(*opened);
      part->discovery_->announce({part->self_.name(), part->self_.uuid(), part->group_name_, part->server_->port()});
    } else {
      part->print_trouble(opened.error().message);
    }
    // Where stations are named, others find this one, and it searches for none.
    drivers::MvrDiscovery* const searches = addresses.empty() ? part->discovery_.get() : nullptr;
    part->group_ = std::make_unique<MvrGroup>(part->self_, searches, part->group_name_, addresses);
    return part;
  }

  Result<int> run() {
    SystemClock clock;
    StopSignal signal;
    print_start();
    FL_ASSIGN(bool reader, flush_output());
    const TimeNs end_ns = options_.share_ns ? clock.now_ns() + *options_.share_ns : kTimeNever;
    std::vector<pollfd> waiting;
    while (reader && !signal.came() && clock.now_ns() < end_ns) {
      server_->add_descriptors(waiting);
      group_->add_descriptors(waiting);
      if (discovery_ != nullptr) discovery_->add_descriptors(waiting);
      wait_for(waiting);
      if (turn(clock.now_ns())) {
        FL_ASSIGN(reader, flush_output());
      }
    }
    leave(*group_, server_.get(), clock);
    return kExitOk;
  }

 private:
  Part(const Options& options, const char* name, std::optional<SharedFile> file)
      : options_(options),
        group_name_(options.group.empty() ? std::string(drivers::kMvrGroupDefault) : options.group),
        self_(own_mvr_station(options.name, name)),
        file_(std::move(file)),
        news_(options.json) {
    if (file_) self_.offer(file_->first().commit, file_->first().bytes);
  }

  void print_start() const {
    if (options_.json) {
      fmt::print("{}", start_json(self_, group_name_, server_->port()));
      return;
    }
    fmt::print("station '{}' in group {}, TCP port {}\n", printable_line(self_.name()), printable_line(group_name_),
               server_->port());
    if (file_) fmt::print("sharing: {}\n", commit_text(self_.offers().back()));
  }

  static void print_trouble(const std::string& trouble) {
    fmt::print(stderr, "footlight: other stations do not find this one by themselves: {}\n", printable_line(trouble));
  }

  // Each trouble, and each other name than the one of the command line, once.
  void follow_announcement(TimeNs now_ns) {
    if (discovery_ == nullptr) return;
    discovery_->step(now_ns);
    const std::string trouble = discovery_->trouble();
    if (trouble != trouble_ && !trouble.empty()) print_trouble(trouble);
    trouble_ = trouble;
    const std::string name = discovery_->announced_name();
    if (name.empty() || name == announced_) return;
    announced_ = name;
    if (name == drivers::dns_label(self_.name())) return;
    fmt::print(stderr, "footlight: another station has this name; announced as '{}'\n", printable_line(name));
  }

  // Events, faults, and a file that was changed meanwhile. True: something was printed.
  bool turn(TimeNs now_ns) {
    server_->step(now_ns);
    group_->step(now_ns);
    follow_announcement(now_ns);
    bool printed = news_.print(*group_);
    for (const auto& event : self_.take_events()) {
      fmt::print("{}", options_.json ? event_json(event) : event_text(event));
      printed = true;
    }
    for (const std::string& fault : server_->take_faults()) {
      fmt::print(stderr, "footlight: {}\n", printable_line(fault));
    }
    if (!file_) return printed;
    const auto changed = file_->poll(now_ns);
    if (!changed) {
      fmt::print(stderr, "footlight: not shared again: {}\n", printable_line(changed.error().message));
    } else if (*changed) {
      self_.offer((*changed)->commit, (*changed)->bytes);
      if (!options_.json) fmt::print("sharing: {}\n", commit_text(self_.offers().back()));
      printed = true;
    }
    return printed;
  }

  const Options options_;
  const std::string group_name_;
  MvrStation self_;
  std::optional<SharedFile> file_;
  StationNews news_;
  std::string trouble_;    // of the announcement, as printed
  std::string announced_;  // the name
  std::unique_ptr<drivers::MvrServer> server_;
  std::unique_ptr<drivers::MvrDiscovery> discovery_;
  std::unique_ptr<MvrGroup> group_;
};

Result<int> share(const Options& options) {
  if (options.path.empty()) {
    return fail(ErrorCode::kBadInput, "mvr share: expected a file, for example 'footlight mvr share show.mvr'");
  }
  FL_ASSIGN(SharedFile file, SharedFile::open(options.path, options.comment));
  FL_ASSIGN(const auto part, Part::open(options, "", std::move(file)));
  return part->run();
}

Result<int> watch(const Options& options) {
  FL_ASSIGN(const auto part, Part::open(options, "watch", std::nullopt));
  return part->run();
}

void add_common(Arguments& arguments, const std::shared_ptr<Options>& options) {
  arguments.list("--station", options->stations, "ADDRESS:PORT",
                 "a station that need not be found; may be given several times");
  arguments.option("--name", options->name, "NAME", "the name of this station [Footlight ... on HOST]");
}

void add_stations(Arguments& mvr) {
  Arguments arguments = mvr.subcommand("stations", "List stations and the files that they offer",
                                       "  footlight mvr stations\n"
                                       "  footlight mvr stations --station 10.0.0.7:42424 --json\n");
  auto options = std::make_shared<Options>();
  add_common(arguments, options);
  arguments.option("--group", options->group, "GROUP", "only stations of this group [all]");
  arguments.duration("--for", options->search_ns, "how long to search [3s]");
  arguments.flag("--json", options->json, "one JSON object a line for each station");
  arguments.job([options]() -> Result<int> { return list_stations(*options); });
}

void add_get(Arguments& mvr) {
  Arguments arguments = mvr.subcommand("get", "Receive a file of a station",
                                       "  footlight mvr get -o show.mvr\n"
                                       "  footlight mvr get 'grandMA3 onPC' --file UUID -o show.mvr\n"
                                       "  footlight mvr get 10.0.0.7:42424 -o show.mvr\n");
  auto options = std::make_shared<Options>();
  arguments.word("STATION", options->station, "its name, UUID or address; not needed if only one has files");
  arguments.option("--out,-o", options->out, "FILE", "the file, written only if it is whole and a rig");
  arguments.option("--file", options->file, "UUID", "the file, of any station that offers it [the last of its list]");
  add_common(arguments, options);
  arguments.option("--group", options->group, "GROUP", "only stations of this group [all]");
  arguments.duration("--for", options->search_ns, "how long to search [3s]");
  arguments.flag("--overwrite", options->overwrite, "replace the file if it exists");
  arguments.job([options]() -> Result<int> { return get(*options); });
}

void add_part(Arguments& arguments, const std::shared_ptr<Options>& options, Result<int> (*run)(const Options&)) {
  arguments.option("--group", options->group, "GROUP", "the group to join [Default]");
  add_common(arguments, options);
  arguments.option("--port", options->port, 0, 65535, "the TCP port [0: the system selects one]");
  auto for_ns = std::make_shared<DurationNs>(-1);
  arguments.duration("--for", *for_ns, "end after this time [never]");
  arguments.flag("--json", options->json, "one JSON object a line for each event");
  arguments.job([options, for_ns, run]() -> Result<int> {
    if (*for_ns >= 0) options->share_ns = *for_ns;
    return run(*options);
  });
}

void add_share(Arguments& mvr) {
  Arguments arguments = mvr.subcommand("share", "Offer a file to other stations, until stopped",
                                       "  footlight mvr share show.mvr --comment 'truss 2 moved'\n"
                                       "A file that changes is offered again as a new revision.\n");
  auto options = std::make_shared<Options>();
  arguments.word("FILE", options->path, "an MVR file");
  arguments.option("--comment", options->comment, "TEXT", "what changed");
  add_part(arguments, options, share);
}

void add_watch(Arguments& mvr) {
  Arguments arguments = mvr.subcommand("watch", "Print the new files of other stations, until stopped",
                                       "  footlight mvr watch\n"
                                       "  footlight mvr watch --group Tour --json\n");
  add_part(arguments, std::make_shared<Options>(), watch);
}

void add(Arguments& arguments) {
  add_stations(arguments);
  add_get(arguments);
  add_share(arguments);
  add_watch(arguments);
}

}  // namespace

extern const CommandInfo mvr_command{
    .name = "mvr",
    .help = "Exchange rigs with consoles and drawing programs over the network (MVR-xchange)",
    .examples =
        "  footlight mvr stations\n"
        "  footlight mvr get -o show.mvr\n"
        "  footlight mvr share show.mvr\n"
        "  footlight mvr watch\n"
        "Stations trust the network: anybody in it can read what is shared, and send any file.\n",
    .add = add,
};

}  // namespace footlight::tools
