#include "tools/footlight/mvr/mvr_exchange.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <filesystem>
#include <string_view>
#include <system_error>
#include <utility>

#include <poll.h>
#include <unistd.h>

#include <fmt/format.h>

#include "drivers/net/mvr_xchange_names.h"
#include "drivers/net/net.h"
#include "fixtures/files/export/mvr.h"
#include "sim/core/counted.h"
#include "sim/core/no_signals.h"
#include "sim/system_clock.h"
#include "tools/footlight/mvr/mvr_lines.h"
#include "tools/footlight/mvr/shared_file.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

using drivers::MvrClient;
using drivers::MvrCommit;
using drivers::MvrGroup;

constexpr int kTickMs = 100;                  // for requests, timeouts and the view
constexpr DurationNs kLeaveNs = kNsPerS / 2;  // for the answers when this program leaves
constexpr std::size_t kFileNameBytesMax = 100;
constexpr int kNumberMax = 1000;

std::string host_name() {
  std::array<char, 256> name = {};
  if (::gethostname(name.data(), name.size() - 1) != 0 || name[0] == '\0') return "this machine";
  return name.data();
}

// The next step in a window, in place of the option of the command line.
std::string window_words(std::string message) {
  constexpr std::string_view kOption = "name a station with --station ADDRESS:PORT";
  if (message.ends_with(kOption)) {
    message.replace(message.size() - kOption.size(), kOption.size(), "add a station by its address");
  }
  return message;
}

// The file while it is made; gone with the object.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::error_code trouble;
    std::string pattern = (fs::temp_directory_path(trouble) / "footlight-XXXXXX").string();
    if (!trouble && ::mkdtemp(pattern.data()) != nullptr) path_ = pattern;
  }
  ~TemporaryFolder() {
    std::error_code trouble;
    if (!path_.empty()) fs::remove_all(path_, trouble);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  [[nodiscard]] const std::string& path() const { return path_; }  // empty: it could not be made

 private:
  std::string path_;
};

Result<SharedFile::Revision> revision_of(const fixtures::ImportedRig& rig, const std::string& file_name) {
  const TemporaryFolder folder;
  if (folder.path().empty()) {
    return fail(ErrorCode::kIo, "{}: no temporary file can be made; is the disk full?", file_name);
  }
  const std::string path = (fs::path(folder.path()) / file_name).string();
  FL_TRY(fixtures::export_mvr(rig, path));
  FL_ASSIGN(const SharedFile file, SharedFile::open(path, ""));
  return file.first();
}

}  // namespace

drivers::MvrStation own_mvr_station(const std::string& name, const char* part) {
  const std::string own = fmt::format("Footlight{}{} on {}", *part == '\0' ? "" : " ", part, host_name());
  const std::string shown = name.empty() ? own : name;
  drivers::SacnSinkOptions digest;
  digest.source_name = shown;
  digest.name = std::string("mvr-xchange ") + part;
  return {shown, uuid_text(drivers::sacn_cid_of(digest))};
}

std::string received_path(const std::string& folder, const std::string& proposed, const std::string& station) {
  const auto plain = [](const std::string& text) {
    std::string name = printable_line(text.substr(text.find_last_of("/\\") + 1));  // npos + 1 is 0
    if (name.size() > 4 && drivers::same_ascii(name.substr(name.size() - 4), ".mvr")) name.resize(name.size() - 4);
    std::erase_if(name, [](char c) { return c == '/' || c == '\\' || static_cast<unsigned char>(c) < 0x20; });
    name.erase(0, std::min(name.find_first_not_of(". "), name.size()));
    if (name.size() > kFileNameBytesMax) name = drivers::dns_label(name);  // at most 63 bytes of whole characters
    return name;
  };
  std::string name = plain(proposed);
  if (name.empty()) name = plain(station);
  if (name.empty()) name = "received";
  std::error_code trouble;
  for (int number = 1; number <= kNumberMax; ++number) {
    const std::string counted_name = number == 1 ? name : fmt::format("{} {}", name, number);
    std::string path = (fs::path(folder) / (counted_name + ".mvr")).string();
    if (!fs::exists(fs::symlink_status(path, trouble))) return path;
  }
  return (fs::path(folder) / (name + ".mvr")).string();  // exists: then it is refused
}

// All that the thread has.
class MvrExchange::Work {
 public:
  Work(MvrExchange& of, const Options& options)
      : of_(of), options_(options), self_(own_mvr_station(options.station_name, "window")) {}

  void run(const std::stop_token& stop) {
    open_discovery();
    group_ = std::make_unique<MvrGroup>(*self_, discovery_.get(), "", std::vector<drivers::MvrAddress>());
    std::vector<pollfd> waiting;
    while (!stop.stop_requested()) {
      turn();
      add_descriptors(waiting);
      (void)::poll(waiting.data(), waiting.size(), kTickMs);
      waiting.clear();
    }
    receiving_.reset();
    leave();
  }

 private:
  // Without one, stations are named; the window shows why.
  void open_discovery() {
    trouble_.clear();
    if (!options_.finds) return;
    auto opened = options_.open_discovery ? options_.open_discovery() : drivers::open_mvr_discovery();
    if (!opened) {
      trouble_ = window_words(opened.error().message);
      return;
    }
    discovery_ = std::move(*opened);
  }

  struct Receiving {
    ReceivedFile part;
    std::unique_ptr<MvrClient> client;
    std::string station;
    std::string path;
    std::uint64_t announced_bytes = 0;
  };

  void add_descriptors(std::vector<pollfd>& waiting) const {
    group_->add_descriptors(waiting);
    if (server_) server_->add_descriptors(waiting);
    if (receiving_) receiving_->client->add_descriptors(waiting);
  }

  void turn() {
    std::deque<Request> requests;
    {
      const std::scoped_lock lock(of_.mutex_);
      requests.swap(of_.requests_);
    }
    for (Request& request : requests) {
      std::visit([this](auto& one) { act(one); }, request);
    }
    const TimeNs now_ns = clock_.now_ns();
    group_->step(now_ns);
    if (server_) server_->step(now_ns);
    if (discovery_) discovery_->step(now_ns);
    step_receiving(now_ns);
    for (const drivers::MvrEvent& event : self_->take_events()) {
      if (event.kind != drivers::MvrEvent::Kind::kSent) continue;
      std::string line = event_text(event);
      while (!line.empty() && line.back() == '\n') line.pop_back();
      tell(Event::Kind::kNews, std::move(line));
    }
    show();
  }

  void act(const Add& request) {
    const auto address = drivers::find_mvr_address(request.address);
    if (!address) return tell(Event::Kind::kError, address.error().message);
    group_->add_named(*address);
  }

  void act(const Receive& request) {
    if (receiving_) return tell(Event::Kind::kError, "another file is being received; wait, or stop it");
    const auto& members = group_->members();
    const auto member = std::find_if(members.begin(), members.end(), [&](const MvrGroup::Member& one) {
      return text_of(one.station.address) == request.wanted.address;
    });
    if (member == members.end() || !member->joined) {
      return tell(Event::Kind::kError, fmt::format("the station at {} is gone", request.wanted.address));
    }
    if (const Status begun = begin_receiving(*member, request); !begun) {
      receiving_.reset();
      tell(Event::Kind::kError, begun.error().message);
    }
  }

  Status begin_receiving(const MvrGroup::Member& member, const Receive& request) {
    const std::string path = received_path(request.folder, request.wanted.name, member.station.name);
    receiving_.reset(new Receiving{ReceivedFile(path, {.overwrite = false, .shows = false}), nullptr,
                                   printable_line(member.station.name), path});
    FL_TRY(receiving_->part.open());
    drivers::MvrMessage message;
    message.type = drivers::MvrMessageType::kRequest;
    message.file_uuid = request.wanted.uuid;
    if (!member.station.uuid.empty()) message.from_stations = {member.station.uuid};
    for (const MvrCommit& commit : member.peer.commits) {
      if (drivers::same_uuid(commit.file_uuid, request.wanted.uuid)) receiving_->announced_bytes = commit.file_bytes;
    }
    FL_ASSIGN(receiving_->client, MvrClient::open(member.station.name, member.station.address, message, clock_.now_ns(),
                                                  &receiving_->part));
    return {};
  }

  void act(const StopReceiving&) {
    if (!receiving_) return;
    std::string news = fmt::format("{}: stopped; nothing is written", receiving_->path);
    receiving_.reset();
    tell(Event::Kind::kNews, std::move(news));
  }

  void step_receiving(TimeNs now_ns) {
    if (!receiving_) return;
    const auto done = receiving_->client->step(now_ns);
    if (done && !*done) return;
    std::unique_ptr<Receiving> one = std::move(receiving_);
    // What has come of a file that is refused is removed before anybody is told.
    const auto refuse = [&](std::string why) {
      one.reset();
      tell(Event::Kind::kError, std::move(why));
    };
    if (!done) return refuse(printable_line(done.error().message));
    if (!one->client->asking().has_file()) {
      return refuse(fmt::format("'{}' does not send the file: {}", one->station,
                                printable_line(one->client->asking().answer().message)));
    }
    if (one->announced_bytes != 0 && one->announced_bytes != one->part.bytes()) {
      tell(Event::Kind::kNews,
           fmt::format("'{}' announced {} bytes and sent {}", one->station, one->announced_bytes, one->part.bytes()));
    }
    const auto rig = one->part.finish();
    if (!rig) return refuse(printable_line(rig.error().message));
    tell(Event::Kind::kReceived, fmt::format("received {} from '{}': {}", one->path, one->station, *rig), one->path);
  }

  void act(const Share& request) {
    if (request.rig == nullptr) {
      if (shared_.empty()) return;
      leave();  // the stations forget what was offered
      server_.reset();
      shared_.clear();
      start_anew();
      return;
    }
    show(true);
    if (const Status done = share(request); !done) tell(Event::Kind::kError, "not shared: " + done.error().message);
  }

  Status share(const Share& request) {
    FL_ASSIGN(const SharedFile::Revision revision, revision_of(*request.rig, request.file_name));
    if (!server_) {
      FL_ASSIGN(server_, drivers::MvrServer::open({options_.listen_ipv4, 0}, *self_));
      if (discovery_) {
        discovery_->announce({self_->name(), self_->uuid(), std::string(drivers::kMvrGroupDefault), server_->port()});
      }
    }
    self_->offer(revision.commit, revision.bytes);
    shared_ = fmt::format("{}, {}", printable_line(request.file_name), size_text(revision.commit.file_bytes));
    tell(Event::Kind::kNews,
         fmt::format("shared as '{}': {}; TCP port {}", printable_line(self_->name()), shared_, server_->port()));
    return {};
  }

  // A station that offers nothing, and knows the same others. The announcement ends with its discovery.
  void start_anew() {
    std::vector<drivers::MvrAddress> named;
    for (const MvrGroup::Member& member : group_->members()) {
      if (member.named) named.push_back(member.station.address);
    }
    group_.reset();
    discovery_.reset();
    self_.emplace(own_mvr_station(options_.station_name, "window"));
    open_discovery();
    group_ = std::make_unique<MvrGroup>(*self_, discovery_.get(), "", named);
  }

  void leave() {
    group_->leave(clock_.now_ns());
    const TimeNs end_ns = clock_.now_ns() + kLeaveNs;
    std::vector<pollfd> waiting;
    while (group_->busy() && clock_.now_ns() < end_ns) {
      group_->add_descriptors(waiting);
      (void)::poll(waiting.data(), waiting.size(), kTickMs);
      waiting.clear();
      group_->step(clock_.now_ns());
    }
  }

  // What is, for the window.
  void show(bool makes = false) {
    ExchangeView view;
    view.on = true;
    view.makes = makes;
    view.trouble = trouble_;
    if (view.trouble.empty() && discovery_) view.trouble = printable_line(discovery_->trouble());
    std::size_t joined = 0;
    for (const MvrGroup::Member& member : group_->members()) {
      ExchangeView::Station& one = view.stations.emplace_back();
      one.address = text_of(member.station.address);
      one.name = printable_line(member.station.name);
      one.program = printable_line(member.peer.provider);
      one.group = printable_line(member.station.group);
      one.joined = member.joined;
      one.trouble = printable_line(member.trouble);
      joined += member.joined ? 1 : 0;
      for (const MvrCommit& commit : member.peer.commits) {
        one.files.push_back(
            {commit.file_uuid, printable_line(commit.file_name), printable_line(commit.comment), commit.file_bytes});
      }
    }
    if (receiving_) view.receiving = receiving_words();
    if (!shared_.empty()) {
      view.sharing = fmt::format("{}, to {}", shared_, counted(static_cast<long long>(joined), "station"));
    }
    publish(std::move(view));
  }

  [[nodiscard]] std::string receiving_words() const {
    const std::string name = fs::path(receiving_->path).filename().string();
    if (receiving_->announced_bytes == 0) return fmt::format("{}, {}", name, size_text(receiving_->part.bytes()));
    const double share =
        static_cast<double>(receiving_->part.bytes()) / static_cast<double>(receiving_->announced_bytes);
    return fmt::format("{}, {:.0f} %", name, 100 * std::min(share, 1.0));
  }

  void publish(ExchangeView view) {
    const std::scoped_lock lock(of_.mutex_);
    if (view == of_.view_) return;
    of_.view_ = std::move(view);
    ++of_.revision_;
    of_.news_.notify_all();
  }

  void tell(Event::Kind kind, std::string text, std::string path = {}) {
    const std::scoped_lock lock(of_.mutex_);
    of_.events_.push_back({kind, std::move(text), std::move(path)});
    ++of_.revision_;
    of_.news_.notify_all();
  }

  MvrExchange& of_;
  const Options options_;
  SystemClock clock_;
  std::optional<drivers::MvrStation> self_;
  std::string trouble_;
  std::string shared_;  // "tour.mvr, 1.2 MB"; empty: nothing is
  std::unique_ptr<drivers::MvrDiscovery> discovery_;
  std::unique_ptr<drivers::MvrServer> server_;
  std::unique_ptr<MvrGroup> group_;
  std::unique_ptr<Receiving> receiving_;
};

MvrExchange::MvrExchange(const Options& options) {
  const NoSignals for_the_thread;
  thread_ = std::jthread([this, options](const std::stop_token& stop) {
    Work(*this, options).run(stop);
    const std::scoped_lock lock(mutex_);
    ended_ = true;
    news_.notify_all();
  });
}

MvrExchange::~MvrExchange() = default;

void MvrExchange::ask(Request request) {
  const std::scoped_lock lock(mutex_);
  requests_.push_back(std::move(request));
}

void MvrExchange::add(std::string address) { ask(Add{std::move(address)}); }
void MvrExchange::receive(ExchangeView::Wanted wanted, std::string folder) {
  ask(Receive{std::move(wanted), std::move(folder)});
}
void MvrExchange::stop_receiving() { ask(StopReceiving{}); }
void MvrExchange::share(std::shared_ptr<const fixtures::ImportedRig> rig, std::string file_name) {
  ask(Share{std::move(rig), std::move(file_name)});
}
void MvrExchange::stop_sharing() { ask(Share{nullptr, {}}); }
void MvrExchange::stop() { thread_.request_stop(); }

bool MvrExchange::ended() const {
  const std::scoped_lock lock(mutex_);
  return ended_;
}

bool MvrExchange::look(ExchangeView& view) {
  const std::scoped_lock lock(mutex_);
  if (looked_ == revision_) return false;
  looked_ = revision_;
  view.on = view_.on;
  view.trouble = view_.trouble;
  view.stations = view_.stations;
  view.receiving = view_.receiving;
  view.sharing = view_.sharing;
  view.makes = view_.makes;
  return true;
}

std::vector<MvrExchange::Event> MvrExchange::take_events() {
  const std::scoped_lock lock(mutex_);
  return std::exchange(events_, {});
}

void MvrExchange::wait_for_news(DurationNs most_ns) {
  std::unique_lock lock(mutex_);
  (void)news_.wait_for(lock, std::chrono::nanoseconds(most_ns), [&] { return waited_ != revision_ || ended_; });
  waited_ = revision_;
}

}  // namespace footlight::tools
