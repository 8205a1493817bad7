// Stations on 127.0.0.1, with ports that the system selects and with injected time.
#include "drivers/net/mvr_xchange_tcp.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <netinet/in.h>
#include <sys/socket.h>

#include "drivers/net/mvr_xchange_group.h"
#include "tests/drivers/net/mvr_xchange_helpers.h"

namespace footlight::drivers {
namespace {

using namespace footlight::testing;

constexpr std::uint32_t kHere = 0x7F000001;
constexpr TimeNs kStartNs = 1'000 * kNsPerS;

struct Desk {
  MvrStation station{"Desk", kDeskUuid};
  std::unique_ptr<MvrServer> server = must(MvrServer::open({kHere, 0}, station));
  [[nodiscard]] MvrAddress address() const { return {kHere, server->port()}; }
};

// Until the client is done; its error, if it fails.
Status run(MvrClient& client, MvrServer& server) {
  std::vector<pollfd> waiting;
  for (int i = 0; i < 10'000; ++i) {
    FL_ASSIGN(const bool done, client.step(kStartNs));
    if (done) return {};
    server.step(kStartNs);
    client.add_descriptors(waiting);
    server.add_descriptors(waiting);
    poll_some(waiting);
  }
  return fail(ErrorCode::kTimeout, "the test waited in vain");
}

// Steps the server until a condition holds; false: it never does.
template <class Condition>
bool steps_until(MvrServer& server, TimeNs now_ns, const Condition& condition) {
  std::vector<pollfd> waiting;
  for (int i = 0; i < 200; ++i) {
    server.step(now_ns);
    if (condition()) return true;
    server.add_descriptors(waiting);
    poll_some(waiting);
  }
  return false;
}

Fd plain_connection(const MvrAddress& to) {
  Fd socket(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0));
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(to.port);
  address.sin_addr.s_addr = htonl(to.ipv4);
  REQUIRE(::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  return socket;
}

void send_text(const Fd& socket, const std::string& text) {
  REQUIRE(::send(socket.get(), text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size()));
}

// A station that accepts one connection, for behaviour that our own server does not have.
struct OddStation {
  OddStation() : listener(::socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(kHere);
    socklen_t size = sizeof address;
    REQUIRE(::bind(listener.get(), reinterpret_cast<const sockaddr*>(&address), size) == 0);
    REQUIRE(::listen(listener.get(), 1) == 0);
    REQUIRE(::getsockname(listener.get(), reinterpret_cast<sockaddr*>(&address), &size) == 0);
    port = ntohs(address.sin_port);
  }
  Fd accept() { return Fd(::accept(listener.get(), nullptr, nullptr)); }
  Fd listener;
  std::uint16_t port = 0;
};

TEST_CASE("a file of 24 MB arrives whole over a socket") {
  Desk desk;
  const auto file = some_file(24'000'001);
  desk.station.offer(commit_of(kOldFile), file);
  MemorySink sink;
  const auto client = must(MvrClient::open("Desk", desk.address(), request_of(kOldFile), kStartNs, &sink));
  must(run(*client, *desk.server));
  CHECK(client->asking().has_file());
  CHECK(sink.bytes == *file);
  CHECK(steps_until(*desk.server, kStartNs, [&] { return desk.server->connection_count() == 0; }));
  CHECK(desk.server->take_faults().empty());
}

TEST_CASE("two stations receive different files at the same time") {
  Desk desk;
  const auto one = some_file(6'000'000);
  const auto two = some_file(5'000'000);
  desk.station.offer(commit_of(kOldFile), one);
  desk.station.offer(commit_of(kNewFile), two);
  MemorySink first_sink, second_sink;
  const auto first = must(MvrClient::open("Desk", desk.address(), request_of(kOldFile), kStartNs, &first_sink));
  const auto second = must(MvrClient::open("Desk", desk.address(), request_of(kNewFile), kStartNs, &second_sink));
  std::vector<pollfd> waiting;
  std::size_t both = 0;
  bool first_done = false, second_done = false;
  for (int i = 0; i < 10'000 && !(first_done && second_done); ++i) {
    first_done = must(first->step(kStartNs));
    second_done = must(second->step(kStartNs));
    desk.server->step(kStartNs);
    both = std::max(both, desk.server->connection_count());
    first->add_descriptors(waiting);
    second->add_descriptors(waiting);
    desk.server->add_descriptors(waiting);
    poll_some(waiting);
  }
  CHECK(both == 2);
  CHECK(first_sink.bytes == *one);
  CHECK(second_sink.bytes == *two);
}

TEST_CASE("a station that vanishes within a file is an error, and the server of one that vanishes goes on") {
  OddStation odd;
  MemorySink sink;
  const auto client = must(MvrClient::open("Odd", {kHere, odd.port}, request_of(""), kStartNs, &sink));
  REQUIRE(!must(client->step(kStartNs)));
  {
    const Fd socket = odd.accept();
    const auto head = build_mvr_header({0, 1, MvrPayload::kFile, 100});
    std::string start(head.begin(), head.end());
    send_text(socket, start + "0123456789");
  }
  Result<bool> done = false;
  std::vector<pollfd> waiting;
  for (int i = 0; i < 200 && done && !*done; ++i) {
    client->add_descriptors(waiting);
    poll_some(waiting);
    done = client->step(kStartNs);
  }
  REQUIRE(!done);
  CHECK(done.error().code == ErrorCode::kDisconnected);
  CHECK(done.error().message.starts_with("Odd (127.0.0.1:"));

  Desk desk;
  desk.station.offer(commit_of(kOldFile), some_file(30'000'000));
  {
    const Fd gone = plain_connection(desk.address());
    send_text(gone, build_mvr_json(build_mvr_message(request_of(kOldFile))));
    REQUIRE(steps_until(*desk.server, kStartNs, [&] { return !desk.station.take_events().empty(); }));
  }
  CHECK(steps_until(*desk.server, kStartNs, [&] { return desk.server->connection_count() == 0; }));
  CHECK(desk.server->take_faults().size() == 1);
  MemorySink whole;
  const auto next = must(MvrClient::open("Desk", desk.address(), request_of(kOldFile), kStartNs, &whole));
  must(run(*next, *desk.server));
  CHECK(whole.bytes.size() == 30'000'000);
}

TEST_CASE("a station that accepts and is silent is a timeout, and so is a message that stops half way") {
  OddStation odd;
  const MvrStation view("View", kViewUuid);
  const auto client = must(MvrClient::open("Odd", {kHere, odd.port}, view.join(), kStartNs));
  const Fd kept = odd.accept();
  REQUIRE(!must(client->step(kStartNs)));
  CHECK(!must(client->step(kStartNs + kMvrSilenceNs - 1)));
  const auto late = client->step(kStartNs + kMvrSilenceNs);
  REQUIRE(!late);
  CHECK(late.error().code == ErrorCode::kTimeout);

  Desk desk;
  const Fd half = plain_connection(desk.address());
  send_text(half, std::string("\0\x0B\xE1", 3));
  const Fd idle = plain_connection(desk.address());
  REQUIRE(steps_until(*desk.server, kStartNs, [&] { return desk.server->connection_count() == 2; }));
  desk.server->step(kStartNs + kMvrSilenceNs - 1);
  CHECK(desk.server->connection_count() == 2);
  desk.server->step(kStartNs + kMvrSilenceNs);
  CHECK(desk.server->connection_count() == 1);  // the idle one may stay
}

TEST_CASE("bytes that drip and messages that are no answer do not prolong the time for an answer") {
  const MvrStation view("View", kViewUuid);
  const std::string other = build_mvr_json(build_mvr_message(view.leave()));
  for (const std::string& drip : {other, other.substr(0, 3)}) {
    OddStation odd;
    const auto client = must(MvrClient::open("Odd", {kHere, odd.port}, view.join(), kStartNs));
    const Fd kept = odd.accept();
    REQUIRE(!must(client->step(kStartNs)));
    send_text(kept, drip);
    std::vector<pollfd> waiting;
    client->add_descriptors(waiting);
    poll_some(waiting);
    REQUIRE(!must(client->step(kStartNs + kMvrSilenceNs - 1)));
    const auto late = client->step(kStartNs + kMvrSilenceNs);
    REQUIRE(!late);
    CHECK(late.error().code == ErrorCode::kTimeout);
  }
}

TEST_CASE("a message to this station that drips ends its connection as one that stops") {
  const MvrStation view("View", kViewUuid);
  const std::string other = build_mvr_json(build_mvr_message(view.leave()));
  Desk desk;
  const Fd half = plain_connection(desk.address());
  send_text(half, other.substr(0, 3));
  REQUIRE(steps_until(*desk.server, kStartNs, [&] { return desk.server->connection_count() == 1; }));
  send_text(half, other.substr(3, 5));
  desk.server->step(kStartNs + kMvrSilenceNs - 1);
  CHECK(desk.server->connection_count() == 1);
  desk.server->step(kStartNs + kMvrSilenceNs);
  CHECK(desk.server->connection_count() == 0);
}

// A station that sends pieces of a file of 100 MB, one before each step. Returns the first error.
Status receive_slowly(std::size_t piece_bytes, DurationNs every_ns, int pieces) {
  OddStation odd;
  MemorySink sink;
  const auto client = must(MvrClient::open("Odd", {kHere, odd.port}, request_of(""), kStartNs, &sink));
  const Fd kept = odd.accept();
  REQUIRE(!must(client->step(kStartNs)));
  const auto head = build_mvr_header({0, 1, MvrPayload::kFile, 100'000'000});
  send_text(kept, std::string(head.begin(), head.end()));
  std::vector<pollfd> waiting;
  for (int i = 1; i <= pieces; ++i) {
    send_text(kept, std::string(piece_bytes, '1'));
    while (sink.bytes.size() < static_cast<std::size_t>(i) * piece_bytes) {
      client->add_descriptors(waiting);
      poll_some(waiting);
      FL_TRY(client->step(kStartNs + i * every_ns));
    }
  }
  return {};
}

TEST_CASE("a file may take longer than an answer while its bytes come") {
  CHECK(receive_slowly(kMvrSlowestBytes, kMvrSilenceNs - 1, 5));
}

TEST_CASE("bytes of a file that drip do not prolong the time for it") {
  const Status late = receive_slowly(1, kMvrSilenceNs / 4, 10);
  REQUIRE(!late);
  CHECK(late.error().code == ErrorCode::kTimeout);
  CHECK(late.error().message.find("less than 64 KiB more of the file within 15 s") != std::string::npos);
}

TEST_CASE("a file that is not whole after half an hour is left") {
  const Status late = receive_slowly(kMvrSlowestBytes, 10 * kNsPerS, 200);
  REQUIRE(!late);
  CHECK(late.error().code == ErrorCode::kTimeout);
  CHECK(late.error().message.find("not whole after 1800 s") != std::string::npos);
}

TEST_CASE("a port without a station is an error that names it") {
  OddStation odd;
  const std::uint16_t port = odd.port;
  odd.listener.reset();
  const MvrStation view("View", kViewUuid);
  auto client = MvrClient::open("Desk", {kHere, port}, view.join(), kStartNs);
  std::string message = client ? "" : client.error().message;
  std::vector<pollfd> waiting;
  for (int i = 0; client && i < 200 && message.empty(); ++i) {
    (*client)->add_descriptors(waiting);
    poll_some(waiting);
    const auto done = (*client)->step(kStartNs);
    if (!done) message = done.error().message;
  }
  CHECK(message.find(fmt::format("127.0.0.1:{}", port)) != std::string::npos);
  CHECK(message.find("cannot connect") != std::string::npos);
}

TEST_CASE("bytes of another protocol end their connection and no other") {
  Desk desk;
  const Fd web = plain_connection(desk.address());
  const Fd quiet = plain_connection(desk.address());
  send_text(web, "GET / HTTP/1.1\r\nHost: desk.local\r\n\r\n");
  REQUIRE(steps_until(*desk.server, kStartNs, [&] {
    const auto faults = desk.server->take_faults();
    return !faults.empty() && faults[0].find("no MVR-xchange packet") != std::string::npos;
  }));
  CHECK(desk.server->connection_count() == 1);
}

TEST_CASE("the connection that is silent longest makes room for a new one") {
  Desk desk;
  std::vector<Fd> kept;
  for (std::size_t i = 0; i < kMvrConnectionsMax; ++i) {
    kept.push_back(plain_connection(desk.address()));
    REQUIRE(steps_until(*desk.server, kStartNs + static_cast<TimeNs>(i),
                        [&] { return desk.server->connection_count() == i + 1; }));
  }
  const MvrStation view("View", kViewUuid);
  const auto client = must(MvrClient::open("Desk", desk.address(), view.join(), kStartNs));
  must(run(*client, *desk.server));
  CHECK(client->asking().answer().station_name == "Desk");
  char byte = 0;
  CHECK(::recv(kept[0].get(), &byte, 1, 0) == 0);
  CHECK(::recv(kept[1].get(), &byte, 1, MSG_DONTWAIT) == -1);
}

TEST_CASE("a port that is taken is an error, and an address without a port is refused") {
  Desk desk;
  MvrStation other("Other", kViewUuid);
  const auto second = MvrServer::open(desk.address(), other);
  REQUIRE(!second);
  CHECK(second.error().message.find("is taken") != std::string::npos);
  CHECK(must(find_mvr_address("127.0.0.1:4711")) == MvrAddress{kHere, 4711});
  for (const char* text : {"", "10.0.0.7", ":4711", "10.0.0.7:", "10.0.0.7:0", "10.0.0.7:70000", "10.0.0.7:4x"}) {
    CAPTURE(text);
    const auto found = find_mvr_address(text);
    CHECK((!found && found.error().code == ErrorCode::kBadInput));
  }
}

// Discovery without a network: what a test says is found.
class FakeDiscovery final : public MvrDiscovery {
 public:
  void add_descriptors(std::vector<pollfd>&) const override {}
  void step(TimeNs) override {}
  [[nodiscard]] std::vector<MvrFound> found() const override { return stations; }
  void announce(const MvrAnnouncement&) override {}
  [[nodiscard]] std::string announced_name() const override { return ""; }
  [[nodiscard]] std::string trouble() const override { return ""; }
  std::vector<MvrFound> stations;
};

void step_all(MvrGroup& group, Desk& desk, TimeNs now_ns) {
  std::vector<pollfd> waiting;
  for (int i = 0; i < 500; ++i) {
    group.step(now_ns);
    desk.server->step(now_ns);
    if (!group.busy()) return;
    group.add_descriptors(waiting);
    desk.server->add_descriptors(waiting);
    poll_some(waiting);
  }
}

TEST_CASE("a group joins what is found in it, commits, leaves, and joins again what is back") {
  Desk desk;
  MvrStation view("View", kViewUuid);
  view.offer(commit_of(kOldFile, "one"), some_file(3));
  FakeDiscovery discovery;
  discovery.stations = {{"Desk", kDeskUuid, "Tour", desk.address()},
                        {"View", kViewUuid, "Tour", {kHere, 9}},    // ourselves
                        {"Other", "x", "Rehearsal", {kHere, 10}}};  // another group
  MvrGroup group(view, &discovery, "tour", {});
  step_all(group, desk, kStartNs);
  REQUIRE(group.members().size() == 1);
  CHECK(group.members()[0].joined);
  CHECK(group.members()[0].peer.provider == "Footlight");
  CHECK(desk.station.peers().at(0).commits.at(0).comment == "one");

  view.offer(commit_of(kNewFile, "two"), some_file(4));
  step_all(group, desk, kStartNs);
  CHECK(desk.station.peers()[0].commits.size() == 2);

  (void)desk.station.take_events();
  discovery.stations.clear();
  step_all(group, desk, kStartNs);
  CHECK(group.members().empty());
  discovery.stations = {{"Desk", kDeskUuid, "Tour", desk.address()}};
  step_all(group, desk, kStartNs);
  CHECK(desk.station.take_events().back().kind == MvrEvent::Kind::kJoined);

  group.leave(kStartNs);
  step_all(group, desk, kStartNs);
  CHECK(!desk.station.peers()[0].joined);
  CHECK(!group.members()[0].joined);
}

TEST_CASE("a join that is answered while the group leaves is followed by the leave") {
  Desk desk;
  MvrStation view("View", kViewUuid);
  MvrGroup group(view, nullptr, "", {desk.address()});
  group.step(kStartNs);
  REQUIRE(group.busy());
  group.leave(kStartNs);
  step_all(group, desk, kStartNs);
  REQUIRE(desk.station.peers().size() == 1);
  CHECK(!desk.station.peers()[0].joined);
  CHECK(!group.members()[0].joined);
}

TEST_CASE("a station that changes its group or its UUID at the same address is another one") {
  Desk desk;
  MvrStation view("View", kViewUuid);
  FakeDiscovery discovery;
  discovery.stations = {{"Desk", kDeskUuid, "Tour", desk.address()}};
  MvrGroup group(view, &discovery, "Tour", {});
  step_all(group, desk, kStartNs);
  REQUIRE(group.members().size() == 1);
  discovery.stations[0].group = "Rehearsal";
  step_all(group, desk, kStartNs);
  CHECK(group.members().empty());
  discovery.stations[0].group = "TOUR";
  step_all(group, desk, kStartNs);
  (void)desk.station.take_events();
  discovery.stations[0].uuid = kOldFile;
  step_all(group, desk, kStartNs);
  CHECK(group.members().size() == 1);
  CHECK(desk.station.take_events().size() == 1);  // a join
}

TEST_CASE("a station that refuses a file is not one that has it, and is joined again") {
  OddStation odd;
  MvrStation view("View", kViewUuid);
  MvrGroup group(view, nullptr, "", {{kHere, odd.port}});
  const auto answer = [&](const MvrMessage& message) {
    group.step(kStartNs);
    const Fd socket = odd.accept();
    send_text(socket, build_mvr_json(build_mvr_message(message)));
    std::vector<pollfd> waiting;
    for (int i = 0; i < 200 && group.busy(); ++i) {
      group.add_descriptors(waiting);
      poll_some(waiting);
      group.step(kStartNs);
    }
  };
  MvrMessage welcome = mvr_answer(MvrMessageType::kJoin, true);
  welcome.station_uuid = kDeskUuid;
  answer(welcome);
  REQUIRE(group.members()[0].joined);
  view.offer(commit_of(kNewFile), some_file(4));
  answer(mvr_answer(MvrMessageType::kCommit, false, "show is locked"));
  CHECK(!group.members()[0].joined);
  CHECK(group.members()[0].trouble.find("show is locked") != std::string::npos);
  group.step(kStartNs + kMvrRejoinNs);
  CHECK(group.busy());
}

TEST_CASE("a station is joined at its next address if the first fails, also when no other is joined any more") {
  OddStation odd;
  const MvrAddress dead = {kHere, odd.port};
  odd.listener.reset();
  Desk desk;
  MvrStation view("View", kViewUuid);
  FakeDiscovery discovery;
  discovery.stations = {{"Desk", kDeskUuid, "Tour", dead, {desk.address()}}};
  MvrGroup group(view, &discovery, "", {});
  group.step(kStartNs);
  REQUIRE(group.busy());
  group.stop_joining();
  discovery.stations.push_back({"Late", "x", "Tour", {kHere, 9}});
  step_all(group, desk, kStartNs);
  REQUIRE(group.members().size() == 2);
  CHECK(group.members()[0].joined);
  CHECK(group.members()[0].station.address == desk.address());
  CHECK(!group.members()[1].joined);
  CHECK(group.members()[1].trouble.empty());  // not tried
}

TEST_CASE("a station of which no address answers is asked again after half a minute") {
  OddStation first, second;
  const std::vector<MvrAddress> dead = {{kHere, first.port}, {kHere, second.port}};
  first.listener.reset();
  second.listener.reset();
  Desk unused;
  MvrStation view("View", kViewUuid);
  FakeDiscovery discovery;
  discovery.stations = {{"Desk", kDeskUuid, "Tour", dead[0], {dead[1]}}};
  MvrGroup group(view, &discovery, "", {});
  step_all(group, unused, kStartNs);
  CHECK(!group.busy());
  REQUIRE(group.members().size() == 1);
  CHECK(group.members()[0].trouble.find("cannot connect") != std::string::npos);
  CHECK(group.members()[0].retry_ns == kStartNs + kMvrRejoinNs);
  Desk desk;
  discovery.stations[0].others = {dead[1], desk.address()};  // found later
  step_all(group, desk, kStartNs + kMvrRejoinNs);
  REQUIRE(group.members().size() == 1);
  CHECK(group.members()[0].joined);
}

TEST_CASE("a station that cannot be joined is asked again after half a minute") {
  OddStation odd;
  const std::uint16_t port = odd.port;
  odd.listener.reset();
  Desk desk;
  MvrStation view("View", kViewUuid);
  MvrGroup group(view, nullptr, "", {{kHere, port}, {kHere, port}});
  REQUIRE(group.members().size() == 1);
  step_all(group, desk, kStartNs);
  CHECK(group.members()[0].trouble.find("cannot connect") != std::string::npos);
  group.step(kStartNs + kMvrRejoinNs - 1);
  CHECK(!group.busy());
  group.step(kStartNs + kMvrRejoinNs);
  CHECK((group.busy() || group.members()[0].retry_ns > kStartNs + kMvrRejoinNs));
}

TEST_CASE("a file that is offered while a join is under way is committed after it") {
  Desk desk;
  MvrStation view("View", kViewUuid);
  view.offer(commit_of(kOldFile), some_file(3));
  MvrGroup group(view, nullptr, "", {desk.address()});
  group.step(kStartNs);
  REQUIRE(group.busy());
  view.offer(commit_of(kNewFile), some_file(4));
  step_all(group, desk, kStartNs);
  step_all(group, desk, kStartNs);
  CHECK(desk.station.peers().at(0).commits.size() == 2);
  CHECK(desk.station.take_events().size() == 2);  // a join and one commit
  step_all(group, desk, kStartNs);
  CHECK(desk.station.take_events().empty());
}

TEST_CASE("a station that has died is not joined any more once it misses a file, and is asked again") {
  auto desk = std::make_unique<Desk>();
  MvrStation view("View", kViewUuid);
  MvrGroup group(view, nullptr, "", {desk->address()});
  step_all(group, *desk, kStartNs);
  REQUIRE(group.members()[0].joined);
  desk.reset();
  Desk unused;
  view.offer(commit_of(kNewFile), some_file(4));
  step_all(group, unused, kStartNs);
  (void)view.answer(MvrStation("Third", kOldFile).join());  // the message of another station changes nothing for it
  step_all(group, unused, kStartNs);
  CHECK(!group.members()[0].joined);
  CHECK(group.members()[0].trouble.find("cannot connect") != std::string::npos);
  group.step(kStartNs + kMvrRejoinNs);
  CHECK((group.busy() || group.members()[0].retry_ns > kStartNs + kMvrRejoinNs));
}

TEST_CASE("a station that has left by its own message is not asked again, and is back when it joins") {
  Desk desk;
  MvrStation view("View", kViewUuid);
  MvrGroup group(view, nullptr, "", {desk.address()});
  step_all(group, desk, kStartNs);
  REQUIRE(group.members()[0].joined);
  (void)view.answer(desk.station.leave());
  group.step(kStartNs + kMvrRejoinNs);
  CHECK(!group.members()[0].joined);
  CHECK(!group.busy());
  (void)view.answer(desk.station.join());
  group.step(kStartNs + kMvrRejoinNs);
  CHECK(group.members()[0].joined);
}

}  // namespace
}  // namespace footlight::drivers
