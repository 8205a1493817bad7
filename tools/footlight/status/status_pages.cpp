#include "tools/footlight/status/status_pages.h"

#include "sim/core/endpoint.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

constexpr const char* kJsonType = "application/json";

HttpAnswer refusal(int status, const std::string& text) { return {.status = status, .body = text + "\n"}; }

}  // namespace

StatusPages::StatusPages(const Pump& pump, Clock& clock)
    : pump_(pump), clock_(clock), start_unix_ns_(wall_clock_unix_ns()) {}

void StatusPages::set_reload_trouble(const std::string& trouble) {
  const std::lock_guard lock(mutex_);
  reload_trouble_ = trouble;
}

HttpAnswer StatusPages::answer_metrics(const HttpRequest& request) const {
  if (request.path != "/metrics") return refusal(404, "no such page; try /metrics");
  if (request.method != "GET") return refusal(405, "expected GET");
  const PumpStatus status = pump_.latest_status();
  if (status.stamp_ns == 0) return refusal(503, "the pump is starting; try again");
  ServiceFacts facts;
  facts.start_unix_ns = start_unix_ns_;
  facts.real_time = real_time.load();
  facts.reloads = reloads.load();
  facts.reload_failures = reload_failures.load();
  if (guard != nullptr) facts.flashes = FlashFacts{guard->count_harmful(), guard->count_held()};
  return {.type = kMetricsType, .body = metrics_text(status, facts)};
}

HttpAnswer StatusPages::answer(const HttpRequest& request) const {
  if (request.path == "/metrics") return answer_metrics(request);
  if (request.path == "/reload") {
    if (request.method == "GET") {
      const std::lock_guard lock(mutex_);
      return {.type = kJsonType,
              .body = json_of_reloads(reloads.load(), reload_failures.load(), reloading.load(), reload_trouble_)};
    }
    if (request.method != "POST") return refusal(405, "expected GET or POST");
    if (!request.from_owner) return refusal(403, "only the user that runs this bridge, or root, may reload it");
    if (!request_reload) return refusal(409, "this bridge was started without a show file, so it cannot reload one");
    request_reload();
    return {.status = 202, .body = "reload requested; the bridge's events report the result\n"};
  }
  if (request.path == "/hand") return answer_hand(request);
  if (request.path != "/status" && request.path != "/levels") {
    return refusal(404, "no such page; try /status, /levels?universes=1-9, /hand or /metrics");
  }
  if (request.method != "GET") return refusal(405, "expected GET");
  if (request.path == "/status") return {.type = kJsonType, .body = json_of_status(pump_.latest_status())};
  const auto universes = pump_.universes();
  std::vector<Universe> requested;
  if (!request.universes.empty()) {
    const auto list = parse_wire_universes(request.universes);
    if (!list) return refusal(400, "universes: " + list.error().message);
    for (const WireUniverse& universe : *list) requested.push_back(universe.wire);
  } else {
    requested.assign(universes->numbers().begin(), universes->numbers().end());
  }
  return {.type = kJsonType, .body = json_of_levels(*universes, requested, clock_.now_ns())};
}

HttpAnswer StatusPages::answer_hand(const HttpRequest& request) const {
  if (hand == nullptr) return refusal(404, "this program takes no levels by hand");
  if (request.method == "GET") {
    const auto report = hand->report();
    if (!report) return refusal(503, report.error().message);
    return {.type = kJsonType, .body = json_of_hand(*report, rig)};
  }
  if (request.method != "POST") return refusal(405, "expected GET or POST");
  if (!request.from_owner) return refusal(403, "only the user that runs this bridge, or root, may set levels");
  const auto command = parse_hand_message(request.body);
  if (!command) return refusal(422, command.error().message);
  const auto slots = hand->apply(*command);
  if (slots) return {.type = kJsonType, .body = fmt::format("{{\"event\":\"hand\",\"slots\":{}}}\n", *slots)};
  const ErrorCode code = slots.error().code;
  return refusal(code == ErrorCode::kTimeout ? 503 : code == ErrorCode::kIo ? 500 : 422, slots.error().message);
}

}  // namespace footlight::tools
