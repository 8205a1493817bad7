#include "tools/footlight/hand/hand_client.h"

#include <unistd.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "tools/footlight/bridge/bridge_sockets.h"
#include "tools/footlight/hand/hand_targets.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/status/http_server.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kPatienceNs = 5 * kNsPerS;  // the bridge itself waits 2 s for its pump
constexpr std::string_view kStart = ", for example 'footlight run --out enttec-pro'";

int hex_digit(char digit) {
  if (digit >= '0' && digit <= '9') return digit - '0';
  return digit >= 'a' && digit <= 'f' ? digit - 'a' + 10 : -1;
}

Error not_of_bridge(const std::string& socket) {
  return {ErrorCode::kProtocol,
          fmt::format("{}: not the page of a bridge; both programs may be of different versions", socket)};
}

}  // namespace

void add_hand_options(Arguments& arguments, HandClientOptions& options) {
  arguments.option("--socket", options.socket, "FILE", "the socket of the bridge, if several run");
  arguments.option("--rig", options.rig, "FILE", "the rig with the named fixtures; default: the --rig of the bridge");
}

Result<HandClient> HandClient::connect(const HandClientOptions& options, const std::string& command) {
  std::string socket = options.socket;
  if (socket.empty()) {
    FL_ASSIGN(socket, find_bridge(command, kStart));
  }
  return HandClient(std::move(socket), options.rig);
}

Status HandClient::send(const HandCommand& command) const {
  const std::string message = hand_message(command);
  if (message.size() > kHandMessageBytesMax) {
    return fail(ErrorCode::kBadInput, "a command of {} bytes; expected at most {}: set fewer slots at once",
                message.size(), kHandMessageBytesMax);
  }
  FL_ASSIGN(const HttpAnswer answer, http_request(socket_, "POST", "/hand", kPatienceNs, message));
  std::string why = answer.body;
  while (why.ends_with('\n')) why.pop_back();
  switch (answer.status) {
    case 200: return {};
    case 403: return fail(ErrorCode::kPermission, "{}: {}", socket_, why);
    case 422: return fail(ErrorCode::kBadInput, "{}", why);
    case 500: return fail(ErrorCode::kIo, "{}", why);
    case 503: return fail(ErrorCode::kTimeout, "{}: {}", socket_, why);
    default: break;
  }
  return fail(ErrorCode::kUnsupported, "{}: {}", socket_, why);
}

void HandClient::print_done(const std::string& done) {
  if (isatty(STDERR_FILENO) != 0) fmt::print(stderr, "footlight: {}\n", printable_line(done));
}

void HandClient::report(const std::string& done) const {
  if (isatty(STDERR_FILENO) == 0) return;
  const auto text = page();
  const nlohmann::json json = text ? nlohmann::json::parse(*text, nullptr, /*allow_exceptions=*/false) : nullptr;
  const bool dark = json.is_object() && json.value("blackout", false);
  print_done(done + (dark ? "; a blackout is on: it shows after 'footlight blackout off'" : ""));
}

Result<std::string> HandClient::page() const {
  FL_ASSIGN(const HttpAnswer answer, http_request(socket_, "GET", "/hand", kPatienceNs));
  if (answer.status != 200) return tl::unexpected(not_of_bridge(socket_));
  return answer.body;
}

Result<std::vector<HandLevel>> HandClient::merged_levels() const {
  FL_ASSIGN(const HttpAnswer answer, http_request(socket_, "GET", "/levels", kPatienceNs));
  const nlohmann::json page = nlohmann::json::parse(answer.body, nullptr, /*allow_exceptions=*/false);
  const bool is_page =
      answer.status == 200 && page.is_object() && page.contains("universes") && page["universes"].is_array();
  if (!is_page) return tl::unexpected(not_of_bridge(socket_));
  std::vector<HandLevel> levels;
  for (const nlohmann::json& universe : page["universes"]) {
    if (!universe.is_object()) return tl::unexpected(not_of_bridge(socket_));
    const std::string digits = universe.value("levels", "");
    const int number = universe.value("universe", 0);
    if (digits.size() != std::size_t{2} * kSlotCountMax || !is_universe(number)) {
      return tl::unexpected(not_of_bridge(socket_));
    }
    if (universe.value("revision", 0U) == 0) continue;  // nothing was ever sent in it
    for (std::size_t slot = 0; slot < kSlotCountMax; ++slot) {
      const int high = hex_digit(digits[2 * slot]), low = hex_digit(digits[2 * slot + 1]);
      if (high < 0 || low < 0) return tl::unexpected(not_of_bridge(socket_));
      HandLevel level;
      level.universe = number;
      level.slots[0] = static_cast<std::uint16_t>(slot);
      level.value = static_cast<std::uint32_t>(16 * high + low);
      levels.push_back(level);
    }
  }
  return levels;
}

Result<const fixtures::Rig*> HandClient::named_rig() {
  if (rig_path_.empty()) return nullptr;
  if (!rig_) {
    FL_ASSIGN(rig_, fixtures::load_rig(rig_path_));
  }
  return &*rig_;
}

Result<const fixtures::Rig*> HandClient::rig(const std::string& target) {
  if (rig_path_.empty()) {
    FL_ASSIGN(const std::string text, page());
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
    if (json.is_object() && json.contains("rig") && json["rig"].is_string()) rig_path_ = json["rig"];
  }
  if (rig_path_.empty()) {
    return fail(
        ErrorCode::kBadInput,
        "{}: names a fixture, so a rig is needed: give --rig FILE, or start the bridge with 'footlight run --rig "
        "FILE'; slots are UNIVERSE.ADDRESS, as in 1.17",
        target);
  }
  return named_rig();
}

Result<std::vector<HandLevel>> HandClient::assignments(const std::vector<std::string>& texts) {
  std::vector<HandLevel> levels;
  for (const std::string& text : texts) {
    FL_TRY(add_assignment(
        text, [this](const std::string& target) { return rig(target); }, levels));
  }
  return levels;
}

Result<std::vector<HandLevel>> HandClient::targets(const std::vector<std::string>& texts) {
  std::vector<HandLevel> levels;
  for (const std::string& text : texts) {
    FL_TRY(add_target(
        text, [this](const std::string& target) { return rig(target); }, levels));
  }
  return levels;
}

}  // namespace footlight::tools
