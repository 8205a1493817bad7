// footlight reload: makes the running bridge read its show file again, and waits for the result.
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

Result<nlohmann::json> read_page(const std::string& socket) {
  FL_ASSIGN(const HttpAnswer answer, http_request(socket, "GET", "/reload"));
  nlohmann::json json = nlohmann::json::parse(answer.body, nullptr, /*allow_exceptions=*/false);
  if (answer.status == 200 && json.is_object() && json.value("event", "") == "reload") return json;
  return fail(ErrorCode::kProtocol, "{}: not the page of a bridge; both programs may be of different versions", socket);
}

Result<int> reload(const Options& options) {
  std::string socket = options.socket;
  if (socket.empty()) {
    FL_ASSIGN(socket, find_bridge("reload", {}, /*with_windows=*/false));
  }
  const auto count = [](const nlohmann::json& json) { return json.value("taken", 0) + json.value("refused", 0); };
  FL_ASSIGN(const nlohmann::json before, read_page(socket));
  FL_ASSIGN(const HttpAnswer answer, http_request(socket, "POST", "/reload"));
  if (answer.status == 403) return fail(ErrorCode::kPermission, "{}: {}", socket, answer.body);
  if (answer.status != 202) return fail(ErrorCode::kUnsupported, "{}: {}", socket, answer.body);
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + options.patience_ns;
  while (clock.now_ns() < end_ns) {
    FL_ASSIGN(const nlohmann::json now, read_page(socket));
    if (count(now) != count(before) && !now.value("running", false)) {
      const std::string trouble = now.value("trouble", "");
      if (trouble.empty()) return kExitOk;
      return fail(ErrorCode::kBadInput, "show file not used, nothing changes: {}", trouble);
    }
    clock.sleep_until_ns(clock.now_ns() + kSearchNs);
  }
  return fail(ErrorCode::kTimeout, "{}: the reload is still running; the bridge's events report its result", socket);
}

void add(Arguments& arguments) {
  auto options = std::make_shared<Options>();
  arguments.option("--socket", options->socket, "FILE", "the socket of the bridge, if several run");
  arguments.duration("--wait", options->patience_ns, "how long to wait for the result [60s]");
  arguments.job([options]() -> Result<int> { return reload(*options); });
}

}  // namespace

extern const CommandInfo reload_command{
    .name = "reload",
    .help = "Make the running bridge read its show file again",
    .examples =
        "  footlight reload\n"
        "Ports with unchanged lines stay open. A file with an error changes nothing, and the error is printed. The "
        "same\n"
        "as SIGHUP, or 'systemctl reload footlight'.",
    .add = add,
};

}  // namespace footlight::tools
