// footlight reload: has the running bridge read its show file anew, and waits for what comes of it.
#include <cstdio>
#include <memory>

#include <nlohmann/json.hpp>

#include "sim/system_clock.h"
#include "tools/footlight/bridge/bridge_sockets.h"
#include "tools/footlight/command.h"
#include "tools/footlight/status/http_server.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kSearchNs = 50 * kNsPerMs;

struct Options {
  std::string socket;
  DurationNs patience_ns = 60 * kNsPerS;
};

Result<nlohmann::json> snapshot(const std::string& socket) {
  FL_ASSIGN(const HttpAnswer answer, http_request(socket, "GET", "/reload"));
  nlohmann::json json = nlohmann::json::parse(answer.body, nullptr, /*allow_exceptions=*/false);
  if (answer.status == 200 && json.is_object() && json.value("event", "") == "reload") return json;
  return fail(ErrorCode::kProtocol, "{}: expected the page of a bridge; are both of one version?", socket);
}

Result<int> reload(const Options& options) {
  std::string socket = options.socket;
  if (socket.empty()) {
    FL_ASSIGN(socket, find_bridge("reload"));
  }
  const auto count = [](const nlohmann::json& json) { return json.value("taken", 0) + json.value("refused", 0); };
  FL_ASSIGN(const nlohmann::json before, snapshot(socket));
  FL_ASSIGN(const HttpAnswer asked, http_request(socket, "POST", "/reload"));
  if (asked.status == 403) return fail(ErrorCode::kPermission, "{}: {}", socket, asked.body);
  if (asked.status != 202) return fail(ErrorCode::kUnsupported, "{}: {}", socket, asked.body);
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + options.patience_ns;
  while (clock.now_ns() < end_ns) {
    FL_ASSIGN(const nlohmann::json now, snapshot(socket));
    if (count(now) != count(before) && !now.value("running", false)) {
      const std::string trouble = now.value("trouble", "");
      if (trouble.empty()) return kExitOk;
      return fail(ErrorCode::kBadInput, "not taken, everything stays as it was: {}", trouble);
    }
    clock.sleep_until_ns(clock.now_ns() + kSearchNs);
  }
  return fail(ErrorCode::kTimeout, "{}: the bridge is still at it; its events say how it goes on", socket);
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.option("--socket", options->socket, "FILE", "the bridge that is meant, where several run");
  arguments.duration("--wait", options->patience_ns, "how long to wait for the outcome; 60s");
  arguments.job([options]() -> Result<int> { return reload(*options); });
}

}  // namespace

extern const CommandInfo reload_command{
    .name = "reload",
    .help = "Have the running bridge read its show file anew",
    .examples =
        "  footlight reload\n"
        "Ports whose lines are what they were stay open; a file that is wrong changes nothing, and its trouble is\n"
        "printed here. The same as SIGHUP, or 'systemctl reload footlight'.",
    .add = add,
};

}  // namespace footlight::tools
