#include "tools/footlight/hand/osc_hand.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <set>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {
namespace {

constexpr std::string_view kRoot = "/footlight/";
constexpr int kBatchesPerPoll = 4;  // the rest makes the socket readable again

// The number between `text`'s beginning and the first slash, which is removed with it.
std::optional<int> take_number(std::string_view& text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  int number = 0;
  const auto [end, fault] = std::from_chars(text.data(), text.data() + slash, number);
  if (slash == 0 || fault != std::errc() || end != text.data() + slash) return std::nullopt;
  text.remove_prefix(std::min(slash + 1, text.size()));
  return number;
}

// 0 to 1; 1 without an argument; nullopt: not a number.
std::optional<double> share_of(const drivers::OscMessage& message, std::size_t index = 0) {
  if (!message.all_numbers) return std::nullopt;
  if (message.number_count == 0) return 1.0;
  const double number = message.is_float[index] ? message.numbers[index] : message.numbers[index] / 255;
  if (std::isnan(number)) return std::nullopt;
  return std::clamp(number, 0.0, 1.0);
}

// Of a button: any integer but 0 is pressed, as is a float from one half on.
std::optional<double> press_of(const drivers::OscMessage& message) {
  const auto share = share_of(message);
  if (!share || message.number_count == 0 || message.is_float[0]) return share;
  return message.numbers[0] != 0 ? 1.0 : 0.0;
}

}  // namespace

Result<std::unique_ptr<OscHand>> OscHand::open(OscHandOptions options) {
  auto source = std::unique_ptr<OscHand>(new OscHand(std::move(options)));
  FL_TRY(source->make_controls());
  FL_TRY(source->listen());
  return source;
}

Status OscHand::listen() {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(options_.udp_port);
  address.sin_addr.s_addr = htonl(INADDR_ANY);
  if (!options_.address.empty() && inet_pton(AF_INET, options_.address.c_str(), &address.sin_addr) != 1) {
    return fail(ErrorCode::kBadInput, "{}: {}: expected an IPv4 address of this machine", options_.name,
                options_.address);
  }
  socket_ = drivers::Fd(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!socket_) return fail(ErrorCode::kIo, "{}: {}", options_.name, std::strerror(errno));
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return {};
  const int number = errno;
  const char* const next = number == EADDRINUSE      ? "another program uses this UDP port; choose another one"
                           : number == EADDRNOTAVAIL ? "this machine has no such address; see 'ip address'"
                                                     : "choose a UDP port from 1024";
  return fail(number == EACCES ? ErrorCode::kPermission : ErrorCode::kIo, "{}: {}; {}", options_.name,
              std::strerror(number), next);
}

std::uint16_t OscHand::udp_port() const { return drivers::local_udp_port(socket_); }

Status OscHand::make_controls() {
  std::optional<fixtures::Rig> rig;
  const ControlMap& map = options_.map;
  const RigOf rig_of = [&](const std::string& text) -> Result<const fixtures::Rig*> {
    if (rig) return &*rig;
    return fail(ErrorCode::kBadInput, "{}: names a fixture, so the map needs a line rig = \"FILE\"", text);
  };
  if (!map.rig.empty()) {
    FL_ASSIGN(rig, fixtures::load_rig(map.rig));
    FL_TRY(make_fixtures(*rig));
  }
  for (const ControlPlan& plan : map.controls) {
    if (!plan.input.starts_with('/')) {
      return fail(ErrorCode::kBadInput, "{}:{}: input: expected an OSC address as in \"/1/fader1\", got \"{}\"",
                  map.name, plan.at, plan.input);
    }
    FL_ASSIGN(Control control, Control::make(plan, map, rig_of));
    controls_[plan.input].push_back(std::move(control));
  }
  return {};
}

Status OscHand::make_fixtures(const fixtures::Rig& rig) {
  const RigOf rig_of = [&](const std::string&) -> Result<const fixtures::Rig*> { return &rig; };
  for (const fixtures::PatchedFixture& fixture : rig.fixtures) {
    if (!fixture.patched) continue;
    std::set<std::string> attributes;
    for (const fixtures::Channel& channel : fixtures::mode_of(rig, fixture).channels) {
      for (const fixtures::ChannelFunction& function : channel.functions) attributes.insert(function.attribute);
    }
    for (const std::string& attribute : attributes) {
      ControlPlan plan;
      plan.to = fixture.name + ":" + attribute;
      auto control = Control::make(plan, options_.map, rig_of);
      if (!control) continue;  // a wheel: it has no range
      controls_[fmt::format("{}fixture/{}/{}", kRoot, osc_name(fixture.name), osc_name(attribute))].push_back(
          std::move(*control));
    }
  }
  return {};
}

Status OscHand::poll(TimeNs now_ns, FrameReceiver& /*receiver*/) {
  for (int batch = 0; batch < kBatchesPerPoll; ++batch) {
    const int count = reader_.read(socket_.get());
    if (count < 0) {
      ++counters_.errors;
      return {};
    }
    for (int i = 0; i < count; ++i) {
      const drivers::Datagram& datagram = reader_[static_cast<std::size_t>(i)];
      if (datagram.truncated) {
        ++counters_.rejected;
      } else {
        take(datagram.bytes, now_ns);
      }
    }
    if (count < static_cast<int>(drivers::DatagramReader::kBatch)) return {};
  }
  return {};
}

void OscHand::take(std::span<const std::uint8_t> packet, TimeNs now_ns) {
  messages_.clear();
  if (!drivers::parse_osc(packet, messages_)) {
    ++counters_.rejected;
    return;
  }
  for (const drivers::OscMessage& message : messages_) ++(obey(message, now_ns) ? counters_.frames : others_);
}

bool OscHand::give(const HandCommand& command, TimeNs now_ns) {
  if (options_.link->taker == nullptr) return false;
  const Status taken = options_.link->taker->take(command, now_ns);
  if (!taken && !refused_) {
    refused_ = true;
    notice_ = PortNotice{NoticeLevel::kWarning, "control-refused", taken.error().message};
  }
  return taken.has_value();
}

bool OscHand::set_slots(std::string_view place, const drivers::OscMessage& message, HandAction action, TimeNs now_ns) {
  const auto universe = take_number(place);
  const auto address = take_number(place);
  if (!universe || !address || !place.empty() || !is_universe(*universe) || !is_address(*address)) return false;
  if (!message.all_numbers) return false;
  const bool sets = action == HandAction::kSet;
  const std::size_t count = sets ? message.number_count : 1;
  if (count == 0 || *address + static_cast<int>(count) - 1 > kSlotCountMax) return false;
  command_.action = action;
  command_.priority = static_cast<std::uint8_t>(options_.map.priority);
  command_.levels.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto share = sets ? share_of(message, i) : 0.0;
    if (!share) return false;
    HandLevel& level = command_.levels[i];
    level.universe = *universe;
    level.slots[0] = static_cast<std::uint16_t>(slot_of_address(*address) + static_cast<int>(i));
    level.value = static_cast<std::uint32_t>(std::lround(*share * 255));
  }
  return give(command_, now_ns);
}

bool OscHand::obey(const drivers::OscMessage& message, TimeNs now_ns) {
  HandLearner& learner = options_.link->learner;
  if (learner.waits() && message.all_numbers) return learner.take(options_.name, std::string(message.address));
  if (options_.link->taker == nullptr) return false;
  if (const auto found = controls_.find(message.address); found != controls_.end()) {
    const auto share = share_of(message), press = press_of(message);
    if (!share || !press) return false;
    HandTaker& taker = *options_.link->taker;
    bool done = true;
    for (Control& control : found->second) {
      const bool is_tap = control.is_button() && message.number_count == 0;
      done =
          (is_tap ? control.tap(now_ns, taker) : control.move(control.is_button() ? *press : *share, now_ns, taker)) &&
          done;
    }
    return done;
  }
  std::string_view rest = message.address;
  if (!rest.starts_with(kRoot)) return false;
  rest.remove_prefix(kRoot.size());
  const auto press = press_of(message);
  if (!press) return false;
  const bool pressed = *press >= 0.5;
  if (rest == "tap" || rest == "tempo") {
    const bool taps = rest == "tap";
    if (taps ? !pressed : message.number_count != 1) return false;
    command_.action = HandAction::kTempo;
    command_.beats_a_minute = taps ? 0 : message.numbers[0];
    command_.levels.clear();
    return (taps || command_.beats_a_minute != 0) && give(command_, now_ns);
  }
  constexpr std::string_view kReleasePath = "release/", kScenePath = "scene/";
  if (rest == "blackout" || rest == "release") {
    if (rest == "release" && !pressed) return false;
    command_.action = rest == "release" ? HandAction::kReleaseAll : pressed ? HandAction::kBlackout : HandAction::kLift;
    command_.levels.clear();
    return give(command_, now_ns);
  }
  if (rest.starts_with(kReleasePath)) {
    return pressed && set_slots(rest.substr(kReleasePath.size()), message, HandAction::kRelease, now_ns);
  }
  if (rest.starts_with(kScenePath)) {
    if (!pressed) return false;
    options_.link->taker->recall({.name = std::string(rest.substr(kScenePath.size())),
                                  .file = options_.map.scenes,
                                  .rig = options_.map.rig,
                                  .over_ns = 0,
                                  .priority = static_cast<std::uint8_t>(options_.map.priority)});
    return true;
  }
  return set_slots(rest, message, HandAction::kSet, now_ns);
}

}  // namespace footlight::tools
