// MVR-xchange beside a window: with stations of the test, on 127.0.0.1.
#include <algorithm>
#include <atomic>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include <doctest/doctest.h>
#include <fmt/format.h>
#include <poll.h>

#include "drivers/net/mvr_xchange_tcp.h"
#include "fixtures/files/export/mvr.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/system_clock.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/desk_thread.h"
#include "tools/footlight/mvr/exchange_follower.h"
#include "tools/footlight/mvr/mvr_exchange.h"

namespace footlight::testing {
namespace {

namespace fs = std::filesystem;
using tools::ExchangeView;
using tools::MvrExchange;
using Kind = MvrExchange::Event::Kind;

constexpr std::uint32_t kHere = 0x7F000001;
constexpr const char* kRig = R"([rig]
name = "Club"
[[fixture]]
name = "Par {}"
type = "generic/par"
universe = 1
address = 1
count = 3
position = [0, 0, 4]
)";

std::string read_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

fixtures::ImportedRig some_rig() { return fixtures::as_imported(must(fixtures::parse_rig(kRig, "rig.toml")), "toml"); }

// Of a station whose file has a path for a name.
drivers::MvrCommit path_commit() {
  drivers::MvrCommit commit;
  commit.file_name = "../../tour.mvr";
  return commit;
}

// Looks until a condition holds.
class Looking {
 public:
  explicit Looking(MvrExchange& exchange) : exchange_(exchange) {}
  template <class Condition>
  bool until(Condition condition) {
    SystemClock clock;
    for (const TimeNs end_ns = clock.now_ns() + 60 * kNsPerS; clock.now_ns() < end_ns;) {
      (void)exchange_.look(view);
      for (auto& event : exchange_.take_events()) events.push_back(std::move(event));
      if (condition()) return true;
      exchange_.wait_for_news(kNsPerS / 4);
    }
    return false;
  }
  [[nodiscard]] const MvrExchange::Event* event(Kind kind) const {
    const auto at = std::find_if(events.begin(), events.end(), [&](const auto& one) { return one.kind == kind; });
    return at == events.end() ? nullptr : &*at;
  }
  ExchangeView view;
  std::vector<MvrExchange::Event> events;

 private:
  MvrExchange& exchange_;
};

MvrExchange::Options quiet() {
  MvrExchange::Options options;
  options.finds = false;
  options.listen_ipv4 = kHere;
  options.station_name = "Window";
  return options;
}

std::string exported(const TempFolder& folder) {
  must(fixtures::export_mvr(some_rig(), folder.file("made.mvr")));
  return read_file(folder.file("made.mvr"));
}

TEST_CASE("a rig of another station is received beside the present one, and is a rig") {
  const TempFolder folder;
  const std::string content = exported(folder);
  const DeskThread desk(content, path_commit());
  MvrExchange exchange(quiet());
  Looking looking(exchange);
  exchange.add(desk.address());
  REQUIRE(looking.until([&] { return !looking.view.stations.empty() && looking.view.stations[0].joined; }));
  const ExchangeView::Station& station = looking.view.stations[0];
  CHECK(station.name == "Desk");
  REQUIRE(station.files.size() == 1);
  CHECK(station.files[0].bytes == content.size());
  std::ofstream(folder.file("tour.mvr")) << "another one";
  exchange.receive({station.address, station.files[0].uuid, station.files[0].name}, folder.file(""));
  REQUIRE(looking.until([&] { return looking.event(Kind::kReceived) != nullptr; }));
  const MvrExchange::Event& event = *looking.event(Kind::kReceived);
  CHECK(fs::path(event.path).filename() == "tour 2.mvr");  // nothing is replaced, and no other folder is written
  CHECK(fs::equivalent(fs::path(event.path).parent_path(), folder.file("")));
  CHECK(read_file(event.path) == content);
  CHECK(event.text.find("3 fixtures") != std::string::npos);
  CHECK(looking.event(Kind::kError) == nullptr);
}

TEST_CASE("what a station sends and is no rig leaves nothing but a message") {
  const TempFolder folder;
  const DeskThread desk("no rig", path_commit());
  MvrExchange exchange(quiet());
  Looking looking(exchange);
  exchange.add(desk.address());
  REQUIRE(looking.until([&] { return !looking.view.stations.empty() && looking.view.stations[0].joined; }));
  exchange.receive({desk.address(), "", ""}, folder.file(""));
  REQUIRE(looking.until([&] { return looking.event(Kind::kError) != nullptr; }));
  CHECK(fs::is_empty(folder.file("")));
  CHECK(looking.event(Kind::kReceived) == nullptr);
  // A station that is not there, and an address that is none.
  looking.events.clear();
  exchange.receive({"127.0.0.1:9", "", ""}, folder.file(""));
  exchange.add("nonsense");
  REQUIRE(looking.until([&] { return looking.events.size() >= 2; }));
  CHECK(looking.events[0].text.find("127.0.0.1:9 is gone") != std::string::npos);
  CHECK(looking.events[1].text.find("expected the address of a station") != std::string::npos);
}

TEST_CASE("the present rig is shared, is received by others, and no longer after that") {
  const TempFolder folder;
  MvrExchange exchange(quiet());
  Looking looking(exchange);
  exchange.share(std::make_shared<const fixtures::ImportedRig>(some_rig()), "club.mvr");
  REQUIRE(looking.until([&] { return !looking.view.sharing.empty(); }));
  REQUIRE(looking.event(Kind::kNews) != nullptr);
  const std::string& news = looking.event(Kind::kNews)->text;
  CHECK(news.find("'Window'") != std::string::npos);
  const std::string address = "127.0.0.1:" + news.substr(news.rfind(' ') + 1);
  MvrExchange other(quiet());
  Looking other_looking(other);
  other.add(address);
  REQUIRE(other_looking.until(
      [&] { return !other_looking.view.stations.empty() && !other_looking.view.stations[0].files.empty(); }));
  CHECK(other_looking.view.stations[0].files[0].name == "club.mvr");
  other.receive({address, other_looking.view.stations[0].files[0].uuid, "club.mvr"}, folder.file(""));
  REQUIRE(other_looking.until([&] { return other_looking.event(Kind::kReceived) != nullptr; }));
  CHECK(must(fixtures::import_rig(folder.file("club.mvr"))).rig.fixtures.size() == 3);
  exchange.stop_sharing();
  REQUIRE(looking.until([&] { return looking.view.sharing.empty(); }));
  MvrExchange late(quiet());
  Looking late_looking(late);
  late.add(address);
  REQUIRE(late_looking.until(
      [&] { return !late_looking.view.stations.empty() && !late_looking.view.stations[0].trouble.empty(); }));
  CHECK(!late_looking.view.stations[0].joined);
}

TEST_CASE("an exchange that is stopped ends by itself") {
  MvrExchange exchange(quiet());
  Looking looking(exchange);
  REQUIRE(looking.until([&] { return looking.view.on; }));
  exchange.stop();
  CHECK(looking.until([&] { return exchange.ended(); }));
}

// A window that calls its exchange, at times of the test.
class Following {
 public:
  explicit Following(TimeNs start_ns) : now_ns(start_ns) {}
  void turn() {
    for (auto& event : follower_.turn(now_ns, view, ".", [this] {
           ++exported;
           return tools::ExchangeFollower::Rig{std::make_shared<const fixtures::ImportedRig>(some_rig()), "club.mvr"};
         })) {
      events.push_back(std::move(event));
    }
  }
  template <class Condition>
  bool until(Condition condition) {
    SystemClock clock;
    for (const TimeNs end_ns = clock.now_ns() + 60 * kNsPerS; clock.now_ns() < end_ns;) {
      turn();
      if (condition()) return true;
      follower_.wait_for_news(kNsPerS / 4);
    }
    return false;
  }
  [[nodiscard]] bool runs() const { return follower_.runs(); }
  ExchangeView view;
  std::vector<MvrExchange::Event> events;
  TimeNs now_ns;
  int exported = 0;

 private:
  tools::ExchangeFollower follower_{quiet()};
};

TEST_CASE("a rig is shared by a window in which nobody has looked for stations") {
  Following window(1000 * kNsPerS);
  window.turn();
  CHECK(!window.runs());
  window.view.share = true;
  REQUIRE(window.until([&] { return !window.view.sharing.empty(); }));
  window.now_ns += 2 * tools::ExchangeFollower::kUnseenNs;
  for (int i = 0; i < 3; ++i) window.turn();
  CHECK(!window.view.share);
  CHECK(window.exported == 1);
  CHECK(window.runs());
  window.view.stop_sharing = true;
  CHECK(window.until([&] { return !window.runs(); }));
}

TEST_CASE("an exchange that ends leaves nothing in the window, and what is asked for meanwhile is done after it") {
  Following window(1000 * kNsPerS);
  window.view.looks = true;
  REQUIRE(window.until([&] { return window.view.on; }));
  window.view.address_text = "10.0.";
  window.now_ns += 2 * tools::ExchangeFollower::kUnseenNs;
  window.turn();  // tells it to end
  window.view.share = true;
  window.turn();
  CHECK((window.view.share || window.exported == 1));  // asked for, until the next exchange has it
  REQUIRE(window.until([&] { return !window.view.sharing.empty(); }));
  CHECK(window.exported == 1);
  CHECK(window.view.address_text == "10.0.");
  window.view.stop_sharing = true;
  window.now_ns += 2 * tools::ExchangeFollower::kUnseenNs;
  REQUIRE(window.until([&] { return window.view.sharing.empty(); }));  // and that turn tells it to end
  window.view.sharing = window.view.receiving = window.view.trouble = "left over";
  window.view.makes = true;
  REQUIRE(window.until([&] { return !window.runs(); }));
  CHECK(!window.view.on);
  CHECK(!window.view.makes);
  for (const auto& left : {window.view.sharing, window.view.receiving, window.view.trouble}) CHECK(left.empty());
}

TEST_CASE("why stations are not found is shown again after the end of sharing, and no longer once they are") {
  std::atomic<int> opened = 0;
  MvrExchange::Options options = quiet();
  options.finds = true;
  options.open_discovery = [&]() -> Result<std::unique_ptr<drivers::MvrDiscovery>> {
    if (opened++ == 1) return fail(ErrorCode::kNotFound, "the daemon is away");
    return std::unique_ptr<drivers::MvrDiscovery>();
  };
  MvrExchange exchange(options);
  Looking looking(exchange);
  for (const char* trouble : {"the daemon is away", ""}) {
    exchange.share(std::make_shared<const fixtures::ImportedRig>(some_rig()), "club.mvr");
    REQUIRE(looking.until([&] { return !looking.view.sharing.empty(); }));
    exchange.stop_sharing();
    REQUIRE(looking.until([&] { return looking.view.sharing.empty(); }));
    CHECK(looking.view.trouble == trouble);
  }
  CHECK(opened == 3);
}

TEST_CASE("the name of a received file has no folder, is new, and is one in any case") {
  const TempFolder folder;
  const std::string here = folder.file("");
  const auto name = [&](const std::string& proposed, const std::string& station = "Desk") {
    return fs::path(tools::received_path(here, proposed, station)).filename().string();
  };
  CHECK(name("tour.mvr") == "tour.mvr");
  CHECK(name("Tour.MVR") == "Tour.mvr");
  CHECK(name("..\\..\\boot.mvr") == "boot.mvr");
  CHECK(name("/etc/passwd") == "passwd.mvr");
  CHECK(name("...hidden") == "hidden.mvr");
  CHECK(name("") == "Desk.mvr");
  CHECK(name("", "../") == "received.mvr");
  CHECK(name(std::string(400, 'a')).size() < 110);
  std::ofstream(folder.file("tour.mvr")) << "x";
  CHECK(name("tour.mvr") == "tour 2.mvr");
}

}  // namespace
}  // namespace footlight::testing
