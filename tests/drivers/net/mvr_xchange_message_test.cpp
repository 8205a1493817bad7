#include "drivers/net/mvr_xchange_message.h"

#include <doctest/doctest.h>

#include <string>

#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using footlight::testing::must;

constexpr const char* kStation = "4aa291a1-1a62-45fe-aabc-e90e5e2399a8";
constexpr const char* kFile = "a7669ff9-bd61-4486-aea6-c190f8ba6b8c";

MvrCommit some_commit() {
  MvrCommit commit;
  commit.file_uuid = kFile;
  commit.station_uuid = kStation;
  commit.version_major = 1;
  commit.version_minor = 6;
  commit.file_bytes = 12'345'678'901;
  commit.comment = "truss 2 \"up\" \xC3\xA4";
  commit.file_name = "show.mvr";
  return commit;
}

MvrMessage some_message(MvrMessageType type) {
  MvrMessage message;
  message.type = type;
  switch (type) {
    case MvrMessageType::kJoin:
    case MvrMessageType::kJoinAnswer:
      message.provider = "Desk";
      message.station_name = "FOH";
      message.station_uuid = kStation;
      message.version_major = 1;
      message.version_minor = 6;
      message.has_commits = true;
      message.commits = {some_commit(), some_commit()};
      break;
    case MvrMessageType::kCommit:
      message.has_commits = true;
      message.commits = {some_commit()};
      message.station_uuid = kStation;
      break;
    case MvrMessageType::kLeave: message.station_uuid = kStation; break;
    case MvrMessageType::kRequest:
      message.file_uuid = kFile;
      message.from_stations = {kStation};
      break;
    case MvrMessageType::kNewSessionHost:
      message.service_name = "B";
      message.service_url = "ws://b";
      break;
    default:
      message.ok = false;
      message.message = "no";
      break;
  }
  return message;
}

bool refused(const std::string& json) {
  const auto parsed = parse_mvr_message(json);
  return !parsed && parsed.error().code == ErrorCode::kProtocol && !parsed.error().message.empty();
}

TEST_CASE("every message is read as it was written, and no prefix of it is read") {
  for (int type = 0; type <= static_cast<int>(MvrMessageType::kNewSessionHostAnswer); ++type) {
    const MvrMessage message = some_message(static_cast<MvrMessageType>(type));
    const std::string json = build_mvr_message(message);
    CAPTURE(json);
    CHECK(must(parse_mvr_message(json)) == message);
    CHECK(json.find(name_of(message.type)) != std::string::npos);
    for (std::size_t size = 0; size < json.size(); ++size) REQUIRE(refused(json.substr(0, size)));
  }
}

TEST_CASE("the messages of the specification's examples are read, with their numbers and truth values as text") {
  const auto join = must(parse_mvr_message(R"({"Type": "MVR_JOIN_RET", "OK": "true", "Message": "", "verMajor":"1",
    "verMinor":"6", "StationUUID":"a7669ff9-bd61-4486-aea6-c190f8ba6b8c", "StationName":"A at B", "Files": [
      {"Type": "MVR_COMMIT", "verMajor":1, "verMinor":6, "FileUUID":"4AA291A1-1A62-45FE-AABC-E90E5E2399A8",
       "ForStationsUUID":[], "FileSize":"256", "Comment":"all of it"}]})"));
  CHECK(join.type == MvrMessageType::kJoinAnswer);
  CHECK(join.ok);
  CHECK(join.version_minor == 6);
  REQUIRE(join.commits.size() == 1);
  CHECK(join.commits[0].file_bytes == 256);
  CHECK(join.commits[0].file_uuid == "4AA291A1-1A62-45FE-AABC-E90E5E2399A8");     // as it is spelled there
  CHECK(join.commits[0].station_uuid == "a7669ff9-bd61-4486-aea6-c190f8ba6b8c");  // the station of the list
  CHECK(must(parse_mvr_message(R"({"Type":"MVR_LEAVE","StationUUID":"x"})")).station_uuid == "x");
  CHECK(must(parse_mvr_message(R"({"Type":"MVR_REQUEST","FromStationUUID":"","FileUUID":""})")).from_stations.empty());
  CHECK(must(parse_mvr_message(R"({"Type":"MVR_REQUEST","FromStationUUID":["x",""]})")).from_stations ==
        std::vector<std::string>{"x"});
}

TEST_CASE("an answer with the type of its request, as of drafts, is an answer") {
  const auto answer = must(parse_mvr_message(R"({"Type":"MVR_REQUEST","OK":"False","Message":"not here"})"));
  CHECK(answer.type == MvrMessageType::kRequestAnswer);
  CHECK(!answer.ok);
  CHECK(answer.message == "not here");
}

TEST_CASE("a list that is missing is told from an empty one") {
  CHECK(!must(parse_mvr_message(R"({"Type":"MVR_JOIN","StationUUID":"x"})")).has_commits);
  CHECK(must(parse_mvr_message(R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":[]})")).has_commits);
}

TEST_CASE("values of a wrong type, unknown types and missing texts are refused with the name of the value") {
  for (const char* json : {
           "",
           "null",
           "[]",
           "7",
           "{}",
           R"({"Type":7})",
           R"({"Type":"MVR_DANCE"})",
           R"({"Type":"MVR_JOIN"})",
           R"({"Type":"MVR_JOIN","StationUUID":5})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","StationName":[]})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","verMajor":-1})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","verMajor":"one"})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","verMajor":1.5})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":{}})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":[7]})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":[{}]})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":[{"FileUUID":"y","FileSize":-3}]})",
           R"({"Type":"MVR_JOIN","StationUUID":"x","Commits":[{"FileUUID":"y","FileSize":99999999999999999999}]})",
           R"({"Type":"MVR_LEAVE"})",
           R"({"Type":"MVR_COMMIT"})",
           R"({"Type":"MVR_COMMIT","FileUUID":""})",
           R"({"Type":"MVR_COMMIT_RET","OK":"maybe"})",
           R"({"Type":"MVR_COMMIT_RET","OK":1})",
           R"({"Type":"MVR_REQUEST","FromStationUUID":{}})",
           R"({"Type":"MVR_REQUEST","FromStationUUID":[7]})",
           "{\"Type\":\"MVR_LEAVE\",\"StationUUID\":\"\xFF\"}",
       }) {
    CAPTURE(json);
    CHECK(refused(json));
  }
  CHECK(refused(R"({"Type":"MVR_LEAVE","StationUUID":")" + std::string(65, 'a') + "\"}"));
  const auto parsed = parse_mvr_message(R"({"Type":"MVR_JOIN","StationUUID":"x","verMinor":"six"})");
  REQUIRE(!parsed);
  CHECK(parsed.error().message == R"(MVR_JOIN: "verMinor" is "six"; expected a number from 0 to 1000)");
}

TEST_CASE("values within values, a million deep, are refused without a crash") {
  const std::string deep = std::string(500'000, '[') + std::string(500'000, ']');
  CHECK(refused(deep));
  CHECK(refused(R"({"Type":"MVR_JOIN","StationUUID":)" + deep + "}"));
}

TEST_CASE("of the list of a join the last commits are kept, and of a commit not whom it is for") {
  const std::string many = R"("x")" + [] {
    std::string more;
    for (int i = 0; i < 200'000; ++i) more += R"(,"x")";
    return more;
  }();
  const auto commit =
      must(parse_mvr_message(R"({"Type":"MVR_COMMIT","FileUUID":"y","ForStationsUUID":[)" + many + "]}"));
  CHECK(build_mvr_message(commit).size() < 1'000);
  MvrMessage join = some_message(MvrMessageType::kJoin);
  join.commits.assign(kMvrCommitsMax + 5, some_commit());
  for (std::size_t i = 0; i < join.commits.size(); ++i) join.commits[i].file_uuid = fmt::format("{}", i);
  const auto read = must(parse_mvr_message(build_mvr_message(join)));
  CHECK(read.commits.size() == kMvrCommitsMax);
  CHECK(read.commits.capacity() == kMvrCommitsMax);
  CHECK(read.commits.front().file_uuid == "5");
}

TEST_CASE("own texts are sent as long as other stations' texts are read") {
  MvrMessage commit = some_message(MvrMessageType::kCommit);
  commit.commits[0].comment.assign(100'000, 'c');
  commit.commits[0].file_name.assign(100'000, 'n');
  CHECK(build_mvr_message(commit).size() < 6'000);
}

TEST_CASE("UUIDs are compared without case and braces") {
  CHECK(same_uuid("{4AA291A1-1A62-45FE-AABC-E90E5E2399A8}", kStation));
  CHECK(!same_uuid(kFile, kStation));
  CHECK(!same_uuid("", kStation));
}

TEST_CASE("a name that is no UTF-8 is sent with replaced bytes") {
  MvrMessage message = some_message(MvrMessageType::kJoin);
  message.station_name = "F\xFFH";
  CHECK(must(parse_mvr_message(build_mvr_message(message))).station_name == "F\xEF\xBF\xBDH");
}

}  // namespace
}  // namespace footlight::drivers
