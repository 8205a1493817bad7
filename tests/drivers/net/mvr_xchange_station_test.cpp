// Two stations that exchange bytes, without sockets.
#include "drivers/net/mvr_xchange_station.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <string>

#include "tests/drivers/net/mvr_xchange_helpers.h"

namespace footlight::drivers {
namespace {

using namespace footlight::testing;
using Kind = MvrEvent::Kind;

// Carries the bytes of both sides in pieces, until neither has any. The error of the side that asks comes first.
Status carry(MvrAsking& asking, MvrAnswering& answering, std::size_t piece = 1000) {
  while (!asking.to_send().empty() || !answering.to_send().empty()) {
    if (const auto bytes = asking.to_send(); !bytes.empty()) {
      const auto part = bytes.first(std::min(piece, bytes.size()));
      FL_TRY(answering.receive(part));
      asking.sent(part.size());
    }
    if (const auto bytes = answering.to_send(); !bytes.empty()) {
      const auto part = bytes.first(std::min(piece, bytes.size()));
      FL_TRY(asking.receive(part));
      FL_TRY(answering.sent(part.size()));
    }
  }
  return {};
}

MvrMessage asked(MvrStation& other, const MvrMessage& message) {
  MvrAsking asking(message);
  MvrAnswering answering(other);
  must(carry(asking, answering));
  REQUIRE(asking.done());
  REQUIRE(!asking.has_file());
  return asking.answer();
}

struct Pair {
  MvrStation desk{"Desk", kDeskUuid};
  MvrStation view{"View", kViewUuid};
};

TEST_CASE("a join brings the files of both stations to the other") {
  Pair pair;
  pair.desk.offer(commit_of(kOldFile, "before lunch"), some_file(10));
  pair.desk.offer(commit_of(kNewFile, "after lunch"), some_file(20));
  pair.view.offer(commit_of(kOldFile, "my own"), some_file(30));
  const MvrPeer desk = must(pair.view.joined(asked(pair.desk, pair.view.join())));
  CHECK(desk.name == "Desk");
  CHECK(desk.provider == "Footlight");
  REQUIRE(desk.commits.size() == 2);
  CHECK(desk.commits[1].comment == "after lunch");
  CHECK(desk.commits[1].file_bytes == 20);
  CHECK(desk.commits[1].station_uuid == kDeskUuid);
  REQUIRE(pair.desk.peers().size() == 1);
  CHECK(pair.desk.peers()[0].name == "View");
  CHECK(pair.desk.peers()[0].commits.at(0).comment == "my own");
  const auto events = pair.desk.take_events();
  REQUIRE(events.size() == 1);
  CHECK(events[0].kind == Kind::kJoined);
  CHECK(events[0].station_name == "View");
}

TEST_CASE("a commit adds a file to what is known of a station, and replaces the one with its UUID") {
  Pair pair;
  pair.view.offer(commit_of(kOldFile, "one"), some_file(1));
  (void)asked(pair.desk, pair.view.join());
  pair.view.offer(commit_of(kNewFile, "two"), some_file(2));
  CHECK(asked(pair.desk, pair.view.commit()).ok);
  pair.view.offer(commit_of(kNewFile, "three"), some_file(3));
  CHECK(asked(pair.desk, pair.view.commit()).ok);
  const auto& commits = pair.desk.peers().at(0).commits;
  REQUIRE(commits.size() == 2);
  CHECK(commits[0].comment == "one");
  CHECK(commits[1].comment == "three");
  CHECK(pair.desk.take_events().back().station_name == "View");
}

TEST_CASE("a station that leaves is known as left until it joins again") {
  Pair pair;
  (void)asked(pair.desk, pair.view.join());
  CHECK(asked(pair.desk, pair.view.leave()).type == MvrMessageType::kLeaveAnswer);
  CHECK(!pair.desk.peers().at(0).joined);
  CHECK(pair.desk.take_events().back().kind == Kind::kLeft);
  (void)asked(pair.desk, pair.view.join());
  CHECK(pair.desk.peers().size() == 1);
  CHECK(pair.desk.peers()[0].joined);
}

TEST_CASE("a file is sent by its UUID in any case, and the newest without a UUID") {
  Pair pair;
  const auto old_file = some_file(5'000);
  const auto new_file = some_file(70'001);
  pair.desk.offer(commit_of("ABCDEF00-0000-4000-8000-000000000001"), old_file);
  pair.desk.offer(commit_of(kNewFile), new_file);
  for (const auto& [uuid, expected] :
       {std::pair(std::string("abcdef00-0000-4000-8000-000000000001"), old_file), std::pair(std::string(), new_file)}) {
    MemorySink sink;
    MvrAsking asking(request_of(uuid, {kViewUuid, kDeskUuid}), &sink);
    MvrAnswering answering(pair.desk);
    must(carry(asking, answering, 777));
    CHECK(asking.has_file());
    CHECK(sink.bytes == *expected);
    CHECK(sink.total == expected->size());
    CHECK(answering.idle());
    CHECK(pair.desk.take_events().back().kind == Kind::kSent);
  }
}

TEST_CASE("a file that is not there, or of another station, is refused with the reason") {
  Pair pair;
  const auto refused = [&](const MvrMessage& request) {
    MemorySink sink;
    MvrAsking asking(request, &sink);
    MvrAnswering answering(pair.desk);
    must(carry(asking, answering));
    REQUIRE(asking.done());
    REQUIRE(!asking.has_file());
    CHECK(!asking.answer().ok);
    CHECK(pair.desk.take_events().back().text == asking.answer().message);
    return asking.answer().message;
  };
  CHECK(refused(request_of("")) == "This station offers no file");
  pair.desk.offer(commit_of(kOldFile), some_file(5));
  CHECK(refused(request_of(kNewFile)).find(kNewFile) != std::string::npos);
  CHECK(refused(request_of(kOldFile, {kViewUuid})).find("another station") != std::string::npos);
  MvrMessage host;
  host.type = MvrMessageType::kNewSessionHost;
  host.service_url = "ws://elsewhere";
  CHECK(!asked(pair.desk, host).ok);
}

TEST_CASE("two requests on one connection are answered in their order") {
  Pair pair;
  const auto file = some_file(3'000);
  pair.desk.offer(commit_of(kOldFile), file);
  MvrAnswering answering(pair.desk);
  const std::string first = build_mvr_json(build_mvr_message(request_of(kOldFile)));
  const std::string both = first + build_mvr_json(build_mvr_message(pair.view.leave()));
  must(answering.receive({reinterpret_cast<const std::uint8_t*>(both.data()), both.size()}));
  MemorySink sink;
  MvrAsking asking(request_of(kOldFile), &sink);
  MvrAsking leaving(pair.view.leave());
  bool file_came_first = false;
  while (!answering.to_send().empty()) {
    const auto part = answering.to_send();
    if (!asking.done()) {
      must(asking.receive(part));
    } else {
      file_came_first = !leaving.done();
      must(leaving.receive(part));
    }
    must(answering.sent(part.size()));
  }
  CHECK(file_came_first);
  CHECK(sink.bytes == *file);
  CHECK(leaving.done());
}

TEST_CASE("messages that came in one piece are answered one by one, so that answers do not fill the memory") {
  Pair pair;
  const std::string join = build_mvr_json(build_mvr_message(pair.view.join()));
  std::string all;
  for (int i = 0; i < 500; ++i) all += join;
  all += "no packet, and more than the twenty-eight octets of a header";
  MvrAnswering answering(pair.desk);
  must(answering.receive({reinterpret_cast<const std::uint8_t*>(all.data()), all.size()}));
  CHECK(pair.desk.take_events().size() == 1);
  CHECK(!answering.idle());
  for (int i = 0; i < 499; ++i) must(answering.sent(answering.to_send().size()));
  CHECK(pair.desk.take_events().size() == 499);
  const Status last = answering.sent(answering.to_send().size());
  REQUIRE(!last);
  CHECK(last.error().code == ErrorCode::kProtocol);
}

TEST_CASE("a file is whole although bytes that are no packet follow it in the same piece") {
  MemorySink sink;
  MvrAsking asking(request_of(kOldFile), &sink);
  const auto head = build_mvr_header({0, 1, MvrPayload::kFile, 4});
  const std::string stream = std::string(head.begin(), head.end()) + "PK\3\4" + std::string(100, '\n');
  must(asking.receive({reinterpret_cast<const std::uint8_t*>(stream.data()), stream.size()}));
  CHECK(asking.has_file());
  CHECK(sink.bytes.size() == 4);
}

TEST_CASE("a file in many packets, with a commit in front of it, is received whole") {
  MemorySink sink;
  MvrAsking asking(request_of(kOldFile), &sink);
  const auto file = some_file(1'000'003);
  Pair pair;
  pair.desk.offer(commit_of(kNewFile), some_file(1));
  std::string stream = build_mvr_json(build_mvr_message(pair.desk.commit()));
  constexpr std::uint32_t kPackets = 10;
  for (std::uint32_t number = 0; number < kPackets; ++number) {
    const std::size_t from = file->size() * number / kPackets;
    const std::size_t to = file->size() * (number + 1) / kPackets;
    const auto head = build_mvr_header({number, kPackets, MvrPayload::kFile, to - from});
    stream.append(head.begin(), head.end());
    stream.append(file->begin() + static_cast<std::ptrdiff_t>(from), file->begin() + static_cast<std::ptrdiff_t>(to));
  }
  for (std::size_t at = 0; at < stream.size(); at += 4'099) {
    const std::string_view part = std::string_view(stream).substr(at, 4'099);
    CHECK(!asking.done());
    must(asking.receive({reinterpret_cast<const std::uint8_t*>(part.data()), part.size()}));
  }
  CHECK(asking.has_file());
  CHECK(sink.bytes == *file);
}

TEST_CASE("a connection that closes before the answer is whole is an error that says how far it came") {
  Pair pair;
  pair.desk.offer(commit_of(kOldFile), some_file(100));
  MemorySink sink;
  MvrAsking asking(request_of(kOldFile), &sink);
  CHECK(asking.closed().error().code == ErrorCode::kDisconnected);
  MvrAnswering answering(pair.desk);
  must(answering.receive(asking.to_send()));
  asking.sent(asking.to_send().size());
  while (sink.bytes.size() < 60) {
    const auto part = answering.to_send();
    const auto piece = part.first(std::min<std::size_t>(part.size(), 30));
    must(asking.receive(piece));
    must(answering.sent(piece.size()));
  }
  const Status closed = asking.closed();
  REQUIRE(!closed);
  CHECK(closed.error().message == "the station closed the connection after 60 bytes of the file");
}

TEST_CASE("the error of a sink ends the request") {
  Pair pair;
  pair.desk.offer(commit_of(kOldFile), some_file(10'000));
  MemorySink sink;
  sink.bytes_max = 5'000;
  MvrAsking asking(request_of(kOldFile), &sink);
  MvrAnswering answering(pair.desk);
  const Status carried = carry(asking, answering);
  REQUIRE(!carried);
  CHECK(carried.error().message == "the disk is full");
  CHECK(!asking.done());
}

TEST_CASE("answers and files that nobody requested end the connection") {
  Pair pair;
  const auto end = [](auto& side, const std::string& bytes) {
    const Status received = side.receive({reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size()});
    return !received && received.error().code == ErrorCode::kProtocol;
  };
  const auto head = build_mvr_header({0, 1, MvrPayload::kFile, 0});
  const std::string empty_file(head.begin(), head.end());
  const std::string answer = build_mvr_json(build_mvr_message(mvr_answer(MvrMessageType::kLeave, true)));
  MvrAnswering first(pair.desk), second(pair.desk), third(pair.desk);
  CHECK(end(first, empty_file));
  CHECK(end(second, answer));
  CHECK(end(third, "GET / HTTP/1.1\r\nHost: desk\r\n\r\n"));
  MvrAsking join(pair.view.join()), commit(pair.view.join());
  CHECK(end(join, empty_file));
  CHECK(end(commit, answer));
}

TEST_CASE("a station that refuses to be joined is an error with its reason") {
  Pair pair;
  const auto joined = pair.view.joined(mvr_answer(MvrMessageType::kJoin, false, "show is locked"));
  REQUIRE(!joined);
  CHECK(joined.error().message.find("show is locked") != std::string::npos);
}

TEST_CASE("what is kept of other stations and of own files has limits") {
  Pair pair;
  for (std::size_t i = 0; i < kMvrOffersMax + 3; ++i) {
    pair.desk.offer(commit_of(fmt::format("file {}", i).c_str()), some_file(1));
  }
  CHECK(pair.desk.offers().size() == kMvrOffersMax);
  CHECK(pair.desk.offers().front().file_uuid == "file 3");
  // The same bytes under two UUIDs, so that the test needs little memory.
  const auto large = std::make_shared<std::vector<std::uint8_t>>(kMvrOffersBytesMax / 2 + 1);
  pair.desk.offer(commit_of("large 1"), large);
  CHECK(pair.desk.offers().size() == kMvrOffersMax);
  pair.desk.offer(commit_of("large 2"), large);
  REQUIRE(pair.desk.offers().size() == 1);
  CHECK(pair.desk.newest_uuid() == "large 2");
  MvrMessage join = pair.view.join();
  for (std::size_t i = 0; i < kMvrPeersMax + 10; ++i) {
    join.station_uuid = fmt::format("station {}", i);
    CHECK(pair.desk.answer(join).message.ok);
  }
  CHECK(pair.desk.peers().size() == kMvrPeersMax);
  MvrMessage leave = pair.view.leave();
  leave.station_uuid = "station 5";
  (void)pair.desk.answer(leave);
  (void)pair.desk.answer(join);  // takes the place of the one that left
  CHECK(pair.desk.peers().back().uuid == join.station_uuid);
  MvrMessage commit = pair.desk.commit();
  commit.station_uuid = join.station_uuid;
  for (std::size_t i = 0; i < kMvrCommitsMax + 5; ++i) {
    commit.commits[0].file_uuid = fmt::format("{}", i);
    (void)pair.desk.answer(commit);
  }
  CHECK(pair.desk.peers().back().commits.size() == kMvrCommitsMax);
  CHECK(pair.desk.peers().back().commits.front().file_uuid == "5");
}

}  // namespace
}  // namespace footlight::drivers
