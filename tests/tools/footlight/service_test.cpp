// The command as a service: started, watched, stopped.
#include <csignal>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>
#include <thread>

#include <linux/capability.h>
#include <poll.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::testing {
namespace {

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("SIGTERM and SIGINT stop a bridge cleanly, with a summary and exit code 0") {
  for (const int number : {SIGTERM, SIGINT}) {
    Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json"});
    bridge.wait_for(R"("event":"ready")");
    bridge.signal(number);
    const Outcome outcome = bridge.wait();
    CAPTURE(outcome.err);
    CHECK(outcome.exit_code == 0);
    CHECK(contains(outcome.out, R"("event":"summary")"));
  }
}

TEST_CASE("a signal to stop that comes twice within a second stops a bridge as cleanly as one") {
  Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json"});
  bridge.wait_for(R"("event":"ready")");
  for (int i = 0; i < 20; ++i) bridge.signal(i % 2 == 0 ? SIGTERM : SIGINT);
  const Outcome outcome = bridge.wait();
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.out, R"("event":"summary")"));
}

TEST_CASE("only the main thread of a bridge receives signals") {
  const TempFolder folder;
  Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "log:" + folder.file("a.dmxlog"), "--json"});
  bridge.wait_for(R"("event":"ready")");
  bridge.wait_for(
      R"("event":"status")");  // by then all threads have started, so the main one has unblocked its signals
  int others = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/" + std::to_string(bridge.pid()) + "/task")) {
    const bool is_main = task.path().filename() == std::to_string(bridge.pid());
    std::ifstream status(task.path() / "status");
    std::string line;
    while (std::getline(status, line) && !line.starts_with("SigBlk:")) {
    }
    REQUIRE(line.starts_with("SigBlk:"));
    const std::uint64_t blocked = std::stoull(line.substr(7), nullptr, 16);
    for (const int number : {SIGINT, SIGTERM, SIGHUP}) {
      CAPTURE(number);
      CHECK(((blocked >> (number - 1)) & 1) == (is_main ? 0 : 1));
    }
    others += is_main ? 0 : 1;
  }
  CHECK(others >= 2);  // the device's and the log's
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

TEST_CASE("a bridge continues when the reader of its JSON has gone, and still stops cleanly") {
  const TempFolder folder;
  Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "log:" + folder.file("a.dmxlog"), "--json"});
  bridge.wait_for(R"("event":"ready")");
  bridge.stop_reading();
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
  CHECK(footlight({"log", "info", folder.file("a.dmxlog")}).exit_code == 0);  // finished, not left as a .part file
}

TEST_CASE("a bridge without JSON ends with a summary on standard error and nothing on standard output") {
  const Outcome outcome = footlight({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--for", "300ms"});
  CHECK(outcome.exit_code == 0);
  CHECK(outcome.out.empty());
  CHECK(contains(outcome.err, "ran "));
  CHECK(contains(outcome.err, "  in  mock:enttec-pro"));
  CHECK(contains(outcome.err, "  out mock:enttec-pro"));
}

TEST_CASE("the JSON of a bridge has the figures that docs/hardware.md lists for a line timed by this machine") {
  const Outcome outcome =
      footlight({"run", "--in", "mock:enttec-pro", "--out", "mock:open-dmx", "--for", "2500ms", "--json"});
  CHECK(outcome.exit_code == 0);
  std::istringstream lines(outcome.out);
  bool summed_up = false;
  for (std::string line; std::getline(lines, line);) {
    const auto object = nlohmann::json::parse(line);
    if (object["event"] != "summary") continue;
    summed_up = true;
    for (const auto& port : object["ports"]) {
      if (port["direction"] != "out") continue;
      for (const char* name : {"requested_hz", "rate_hz", "break_us_min", "break_us_p50", "break_us_max", "mab_us_p50",
                               "period_us_p50", "waits_for_transmitter"}) {
        CAPTURE(name);
        CHECK(port["figures"].contains(name));
      }
      CHECK(port["figures"]["requested_hz"] == 40.0);
    }
  }
  CHECK(summed_up);
}

TEST_CASE("a universe that no input receives is reported once at the start") {
  const Outcome outcome = footlight({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro=2", "--for", "0s"});
  CHECK(outcome.exit_code == 0);
  CHECK(contains(outcome.err, "mock:enttec-pro=2: no input receives universe 2"));
}

TEST_CASE("a bridge without real-time priority reports this once, and carries frames") {
  rlimit allowed = {};
  REQUIRE(::getrlimit(RLIMIT_RTPRIO, &allowed) == 0);
  const TempFolder folder;
  std::ofstream(folder.file("show.toml")) << "[[in]]\nendpoint = \"mock:enttec-pro\"\n[[out]]\nendpoint = "
                                             "\"mock:enttec-pro\"\n";
  std::unique_ptr<Footlight> bridge;
  // Capabilities belong to a thread, and a program gets those of the thread that starts it.
  std::thread([&] {
    const rlimit none = {0, allowed.rlim_max};
    REQUIRE(::setrlimit(RLIMIT_RTPRIO, &none) == 0);
    (void)::prctl(PR_CAPBSET_DROP, CAP_SYS_NICE);  // refused if the thread does not have it
    bridge = std::make_unique<Footlight>(
        std::vector<std::string>{"run", folder.file("show.toml"), "--json", "--socket", "none"});
    REQUIRE(::setrlimit(RLIMIT_RTPRIO, &allowed) == 0);
  }).join();
  bridge->wait_for(R"("id":"realtime-refused")");
  bridge->signal(SIGHUP);
  bridge->wait_for(R"("id":"reloaded")");
  CHECK_FALSE(bridge->has_printed(R"("id":"realtime-refused")", 2));
  bridge->signal(SIGTERM);
  CHECK(bridge->wait().exit_code == 0);
}

// The service manager's end of sd_notify().
class NotifySocket {
 public:
  explicit NotifySocket(const std::string& path) : fd_(socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    sockaddr_un address = {};
    address.sun_family = AF_UNIX;
    REQUIRE(path.size() < sizeof address.sun_path);
    std::memcpy(address.sun_path, path.c_str(), path.size());
    REQUIRE(bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~NotifySocket() { close(fd_); }
  NotifySocket(const NotifySocket&) = delete;
  NotifySocket& operator=(const NotifySocket&) = delete;

  // Messages up to the first that contains `text`; empty if none arrives within a minute.
  std::string wait_for(const std::string& text) {
    std::string all;
    while (!contains(all, text)) {
      pollfd ready = {fd_, POLLIN, 0};
      if (poll(&ready, 1, 60'000) != 1) return {};
      char buffer[2048];
      const ssize_t size = recv(fd_, buffer, sizeof buffer, 0);
      if (size > 0) all.append(buffer, static_cast<std::size_t>(size)).push_back('\n');
    }
    return all;
  }

 private:
  int fd_;
};

TEST_CASE("the service manager is notified when a bridge is ready, alive and stopping") {
  const TempFolder folder;
  NotifySocket manager(folder.file("notify"));
  Footlight bridge({"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json"},
                   {{"NOTIFY_SOCKET", folder.file("notify")}, {"WATCHDOG_USEC", "200000"}});
  const std::string start = manager.wait_for("READY=1");
  if (start.empty()) {
    MESSAGE("built without libsystemd");
    return;
  }
  CHECK_FALSE(manager.wait_for("WATCHDOG=1").empty());
  CHECK_FALSE(manager.wait_for("WATCHDOG=1").empty());
  CHECK_FALSE(manager.wait_for("STATUS=").empty());
  bridge.signal(SIGTERM);
  CHECK_FALSE(manager.wait_for("STOPPING=1").empty());
  CHECK(bridge.wait().exit_code == 0);
}

TEST_CASE("the service manager is notified when a reload starts, and when the bridge is ready again") {
  const TempFolder folder;
  NotifySocket manager(folder.file("notify"));
  std::ofstream(folder.file("show.toml"))
      << "[[in]]\nendpoint = \"mock:enttec-pro\"\n[[out]]\nendpoint = \"mock:enttec-pro\"\n";
  Footlight bridge({"run", folder.file("show.toml"), "--json"}, {{"NOTIFY_SOCKET", folder.file("notify")}});
  if (manager.wait_for("READY=1").empty()) {
    MESSAGE("built without libsystemd");
    return;
  }
  bridge.signal(SIGHUP);
  CHECK(contains(manager.wait_for("RELOADING=1"), "MONOTONIC_USEC="));
  CHECK_FALSE(manager.wait_for("READY=1").empty());
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

}  // namespace
}  // namespace footlight::testing
