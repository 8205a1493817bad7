// footlight mvr: rigs from consoles and drawing programs over the network, by MVR-xchange.
#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
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
#include "fixtures/files/export/write_file.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/file_kind.h"
#include "sim/system_clock.h"
#include "tools/footlight/command.h"
#include "tools/footlight/mvr/mvr_lines.h"
#include "tools/footlight/mvr/shared_file.h"
#include "tools/footlight/status/status_text.h"
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

std::string host_name() {
  std::array<char, 256> name = {};
  if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "this machine";
  return name.data();
}

// `part`: empty where a file is shared. The UUID is the same after every start. The parts of one machine have different
// ones: a list that ends must not end the membership of a file that is shared.
MvrStation own_station(const Options& options, const char* part) {
  const std::string own = fmt::format("Footlight{}{} on {}", *part == '\0' ? "" : " ", part, host_name());
  const std::string name = options.name.empty() ? own : options.name;
  drivers::SacnSinkOptions digest;
  digest.source_name = name;
  digest.name = std::string("mvr-xchange ") + part;
  return {name, uuid_text(drivers::sacn_cid_of(digest))};
}

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

// Joins what is there until the time is over. Returns at once when the one that is searched for has answered, or when
// all named stations have.
void search(const Options& options, MvrGroup& group, bool discovers, StopSignal& signal, Clock& clock) {
  const TimeNs end_ns = clock.now_ns() + options.search_ns;
  std::vector<pollfd> waiting;
  while (!signal.came()) {
    group.step(clock.now_ns());
    const auto& members = group.members();
    const bool found = !options.station.empty() && std::any_of(members.begin(), members.end(), [&](const auto& one) {
      return one.joined && names_station(one, options.station);
    });
    // A station that was found in time has its own timeout for the answer.
    const bool over = !discovers || clock.now_ns() >= end_ns;
    if (found || (over && !group.busy())) return;
    group.add_descriptors(waiting);
    wait_for(waiting);
  }
}

Result<int> list_stations(const Options& options) {
  FL_ASSIGN(const auto addresses, addresses_of(options));
  FL_ASSIGN(const auto discovery, open_discovery(options));
  MvrStation self = own_station(options, "list");
  MvrGroup group(self, discovery.get(), options.group, addresses);
  SystemClock clock;
  StopSignal signal;
  search(options, group, discovery != nullptr, signal, clock);
  bool any = false;
  for (const auto& member : group.members()) {
    fmt::print("{}", options.json ? station_json(member) : station_text(member));
    any = any || member.joined;
  }
  leave(group, nullptr, clock);
  if (any) return kExitOk;
  if (group.members().empty()) {
    fmt::print(stderr,
               "footlight: no station of MVR-xchange was found; switch it on there, in the same network, or name the "
               "station with --station ADDRESS:PORT\n");
  }
  return kExitNotFound;
}

// The file beside its target, until it is whole and is a rig. Its name ends in ".mvr", so that the reader expects one.
class PartFile final : public drivers::MvrFileSink {
 public:
  explicit PartFile(std::string path)
      : path_(std::move(path)), part_(fixtures::part_name(path_) + ".mvr"), shows_(::isatty(STDERR_FILENO) != 0) {}
  ~PartFile() override {
    if (file_ == nullptr && !closed_) return;
    if (file_ != nullptr) std::fclose(file_);
    std::remove(part_.c_str());
  }
  PartFile(const PartFile&) = delete;
  PartFile& operator=(const PartFile&) = delete;

  Status open() {
    file_ = std::fopen(part_.c_str(), "wbx");
    if (file_ != nullptr) return {};
    return fail(ErrorCode::kIo, "{}: cannot be written ({}); choose a folder that exists and is yours", path_,
                std::strerror(errno));
  }

  Status write(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) override {
    if (std::fwrite(bytes.data(), 1, bytes.size(), file_) != bytes.size()) return failed();
    bytes_ += bytes.size();
    const int percent = static_cast<int>(bytes_ * 100 / std::max<std::uint64_t>(total_bytes, 1));
    if (shows_ && percent != percent_) fmt::print(stderr, "\rfootlight: {} %\033[K", percent);
    if (shows_ && percent == 100) fmt::print(stderr, "\r\033[K");
    percent_ = percent;
    return {};
  }

  // Reads it as a rig and gives it its name. Returns a line about the rig.
  Result<std::string> finish() {
    const bool written = std::fflush(file_) == 0 && ::fsync(::fileno(file_)) == 0;
    closed_ = true;
    if (std::fclose(std::exchange(file_, nullptr)) != 0 || !written) return failed();
    FL_ASSIGN(std::string line, check_mvr(part_, path_));
    std::error_code trouble;
    std::filesystem::rename(part_, path_, trouble);
    if (trouble) return fail(ErrorCode::kIo, "{}: cannot be written: {}", path_, trouble.message());
    closed_ = false;
    return line;
  }
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  tl::unexpected<Error> failed() const {
    return fail(ErrorCode::kIo, "{}: writing failed ({}); is the disk full?", path_, std::strerror(errno));
  }

  const std::string path_;
  const std::string part_;
  const bool shows_;
  std::FILE* file_ = nullptr;
  bool closed_ = false;  // the part is there, whole
  std::uint64_t bytes_ = 0;
  int percent_ = -1;
};

// The station that the command line means.
Result<const MvrGroup::Member*> choose_station(const Options& options, const MvrGroup& group) {
  const MvrGroup::Member* chosen = nullptr;
  std::string names;
  for (const auto& member : group.members()) {
    const bool fits = options.station.empty() || names_station(member, options.station);
    if (fits && !member.joined && !member.trouble.empty() && group.members().size() == 1) {
      return fail(ErrorCode::kNotFound, "{}", member.trouble);
    }
    if (!member.joined) continue;
    names += fmt::format("{}'{}'", names.empty() ? "" : ", ", printable_line(member.station.name));
    if (!fits || (options.station.empty() && member.peer.commits.empty())) continue;
    if (chosen != nullptr) {
      return fail(ErrorCode::kBadInput, "several stations have files; name one by its name, UUID or address: {}",
                  names);
    }
    chosen = &member;
  }
  if (chosen != nullptr) return chosen;
  if (names.empty()) {
    return fail(
        ErrorCode::kNotFound,
        "no station of MVR-xchange was found; switch it on there, in the same network, or name the station with "
        "--station ADDRESS:PORT");
  }
  if (options.station.empty()) return fail(ErrorCode::kNotFound, "no station offers a file; found: {}", names);
  return fail(ErrorCode::kNotFound, "{}: no such station; found: {}", printable_line(options.station), names);
}

// The newest is the last of the list; a station without a list makes one.
Result<MvrCommit> choose_commit(const Options& options, const MvrGroup::Member& member) {
  const auto& commits = member.peer.commits;
  if (options.file.empty()) return commits.empty() ? MvrCommit{} : commits.back();
  for (const MvrCommit& commit : commits) {
    if (drivers::same_uuid(commit.file_uuid, options.file)) return commit;
  }
  return fail(ErrorCode::kNotFound, "--file {}: '{}' does not offer it; 'footlight mvr stations' lists its files",
              printable_line(options.file), printable_line(member.station.name));
}

Result<int> receive(const MvrGroup::Member& member, const MvrCommit& commit, const Options& options, StopSignal& signal,
                    Clock& clock) {
  drivers::MvrMessage request;
  request.type = drivers::MvrMessageType::kRequest;
  request.file_uuid = commit.file_uuid;
  if (!member.station.uuid.empty()) request.from_stations = {member.station.uuid};
  PartFile part(options.out);
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
    if (const auto address = drivers::find_mvr_address(options.station)) {
      options.stations.push_back(options.station);
      options.station = text_of(*address);
    }
  }
  FL_ASSIGN(const auto addresses, addresses_of(options));
  FL_ASSIGN(const auto discovery, open_discovery(options));
  MvrStation self = own_station(options, "get");
  MvrGroup group(self, discovery.get(), options.group, addresses);
  SystemClock clock;
  StopSignal signal;
  search(options, group, discovery != nullptr, signal, clock);
  const auto received = [&]() -> Result<int> {
    FL_ASSIGN(const auto* member, choose_station(options, group));
    FL_ASSIGN(const MvrCommit commit, choose_commit(options, *member));
    return receive(*member, commit, options, signal, clock);
  }();
  leave(group, nullptr, clock);
  return received;
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
      fmt::print(stderr, "footlight: other stations do not find this one by themselves: {}\n", opened.error().message);
    }
    part->group_ = std::make_unique<MvrGroup>(part->self_, part->discovery_.get(), part->group_name_, addresses);
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
        self_(own_station(options, name)),
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

  // Events, faults, and a file that was changed meanwhile. True: something was printed.
  bool turn(TimeNs now_ns) {
    server_->step(now_ns);
    group_->step(now_ns);
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
  arguments.option("--file", options->file, "UUID", "the file of the station [the last of its list]");
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
