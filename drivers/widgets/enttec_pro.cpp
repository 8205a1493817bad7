#include "drivers/widgets/enttec_pro.h"

#include <algorithm>

#include "drivers/mock/enttec_pro_model.h"

namespace footlight::drivers {
namespace {

constexpr DurationNs kSplitMessageNs = 100 * kNsPerMs;  // a pause inside a message: the rest was lost
constexpr double kLineRateHzMax = 44.0;                 // 513 slots of 44 us with the shortest break
constexpr std::uint16_t kDmxkingEstaId = 0x6A6B;
constexpr std::uint16_t kDmxkingUltraPro = 2;  // device id of the model with two outputs
constexpr std::uint8_t kBothPortsDmx[] = {1, 1};

std::uint8_t number_of(ProLabel label) { return static_cast<std::uint8_t>(label); }

std::optional<std::uint16_t> id_of(std::span<const std::uint8_t> payload) {
  if (payload.size() < 2) return std::nullopt;
  return static_cast<std::uint16_t>(payload[0] | payload[1] << 8);
}

}  // namespace

Status EnttecPro::can(int line, LineUse use) const {
  if (line == 0) return {};
  if (config_.second_needs_key && !config_.second_port)
    return fail(ErrorCode::kUnsupported,
                "connector 2 of this model needs a key and labels that ENTTEC gives to each applicant; add yours "
                "to the show file as second_port (docs/hardware.md)");
  if (use == LineUse::kInput && !config_.second_port)
    return fail(ErrorCode::kUnsupported, "connector 2 is an output; use connector 1 as the input");
  return {};
}

Status EnttecPro::write(WidgetContext& context, std::span<const std::uint8_t> bytes) {
  const Status written = context.transport().write(bytes, context.now_ns() + config_.write_timeout_ns);
  if (!written) cut_short_ = true;
  return written;
}

Result<ProMessageView> EnttecPro::query(WidgetContext& context, const ProMessage& question, std::uint8_t label,
                                        TimeNs deadline_ns) {
  FL_TRY(write(context, question.bytes()));
  while (true) {
    ProMessageView message;
    while (parser_.next(unread_, message)) {
      if (message.label == label) return message;
      (void)take_line_message(context, message);
    }
    if (context.stopping()) return fail(ErrorCode::kDisconnected, "{}: closed", context.transport().where());
    if (context.now_ns() >= deadline_ns)
      return fail(ErrorCode::kTimeout, "{}: no answer to label {} within {} ms; is it a DMX USB Pro?",
                  context.transport().where(), label, config_.reply_timeout_ns / kNsPerMs);
    FL_ASSIGN(const std::size_t count, context.transport().read(input_, deadline_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
  }
}

Result<WidgetTraits> EnttecPro::begin(WidgetContext& context) {
  parser_.reset();
  unread_ = {};
  cut_short_ = false;
  received_ns_ = context.now_ns();
  for (Line& line : lines_) {
    line.frame.fill(0);
    line.shows = false;
  }
  const bool listens =
      std::any_of(context.lines().begin(), context.lines().end(), [](LineUse use) { return use == LineUse::kInput; });
  // A short latency timer for inputs: the end of a frame waits for it inside the chip.
  FL_TRY(context.transport().set_line({.latency_ms = listens ? 2 : 16}, context.now_ns() + config_.write_timeout_ns));
  // A program that was killed in the middle of a message, also this one, leaves the widget waiting for the rest.
  FL_TRY(write(context, pro_flush_bytes()));
  FL_TRY(find_out(context));

  WidgetTraits traits;
  traits.rate_hz_max = params_.rate_hz == 0 ? kLineRateHzMax : params_.rate_hz;
  traits.keep_alive_ns = config_.keep_alive_ns;
  traits.identity = fmt::format("{}firmware {}.{}", serial_ != 0 ? fmt::format("serial number {}, ", serial_) : "",
                                params_.firmware >> 8, params_.firmware & 0xFF);
  FL_TRY(set_up_lines(context, traits));
  return traits;
}

// All requests but the last may stay unanswered: a blank EEPROM has no serial number, and labels 77 and 78 are not
// ENTTEC's own. They are sent together, so that a widget that ignores some costs no timeout.
Status EnttecPro::find_out(WidgetContext& context) {
  is_dmxking_ = false;
  port_count_ = 1;
  serial_ = 0;
  FL_TRY(write(context, ProMessage(ProLabel::kManufacturer, {}).bytes()));
  FL_TRY(write(context, ProMessage(ProLabel::kDeviceName, {}).bytes()));
  FL_TRY(write(context, encode_get_serial().bytes()));
  FL_TRY(write(context, encode_get_params().bytes()));
  const TimeNs deadline_ns = context.now_ns() + config_.reply_timeout_ns;
  bool has_params = false;
  while (!has_params) {
    ProMessageView message;
    while (!has_params && parser_.next(unread_, message)) {
      if (message.label == number_of(ProLabel::kManufacturer)) {
        is_dmxking_ = id_of(message.payload) == kDmxkingEstaId;
      } else if (message.label == number_of(ProLabel::kDeviceName)) {
        if (is_dmxking_ && id_of(message.payload) == kDmxkingUltraPro) port_count_ = 2;
      } else if (message.label == number_of(ProLabel::kSerialNumber)) {
        serial_ = decode_serial(message.payload).value_or(0);
      } else if (message.label == number_of(ProLabel::kGetParams)) {
        FL_ASSIGN(params_, decode_params(message.payload));
        has_params = true;
      }
    }
    if (has_params) break;
    if (context.stopping()) return fail(ErrorCode::kDisconnected, "{}: closed", context.transport().where());
    if (context.now_ns() >= deadline_ns)
      return fail(ErrorCode::kTimeout, "{}: no answer to label {} within {} ms; is it a DMX USB Pro?",
                  context.transport().where(), number_of(ProLabel::kGetParams), config_.reply_timeout_ns / kNsPerMs);
    FL_ASSIGN(const std::size_t count, context.transport().read(input_, deadline_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
  }
  if (!is_dmxking_) return {};
  const auto answer = query(context, ProMessage(ProLabel::kPortCount, {}), number_of(ProLabel::kPortCount),
                            context.now_ns() + config_.reply_timeout_ns);
  if (answer && !answer->payload.empty())
    port_count_ = std::max<int>(port_count_, answer->payload[0]);
  else if (!answer && answer.error().code != ErrorCode::kTimeout)
    return tl::unexpected(answer.error());
  return {};
}

Status EnttecPro::set_up_lines(WidgetContext& context, WidgetTraits& traits) {
  const auto uses = context.lines();
  const bool two = is_dmxking_ && port_count_ >= 2;
  lines_[0].send_label = number_of(two ? ProLabel::kSendDmxFirst : ProLabel::kSendDmx);
  lines_[1].send_label = number_of(ProLabel::kSendDmxSecond);
  if (uses.size() > 1 && uses[1] != LineUse::kUnused && !two) {
    if (!config_.second_port)
      return fail(ErrorCode::kUnsupported,
                  "{}: reports one DMX connector; the second of an ENTTEC Mk2 needs a key and labels that "
                  "ENTTEC gives to each applicant: add yours to the show file as second_port (docs/hardware.md)",
                  context.transport().where());
    const SecondPort& second = *config_.second_port;
    lines_[1].send_label = second.send;
    const std::uint8_t needed = uses[1] == LineUse::kOutput ? second.send : second.receive;
    if (needed == 0)
      return fail(ErrorCode::kUnsupported, "connector 2: second_port has no label to {}; add \"{}\"",
                  uses[1] == LineUse::kOutput ? "send with" : "receive with",
                  uses[1] == LineUse::kOutput ? "send" : "receive");
    FL_TRY(write(context, ProMessage(ProLabel::kApiKey, second.key).bytes()));
    if (second.assign != 0) FL_TRY(write(context, ProMessage(ProLabel{second.assign}, kBothPortsDmx).bytes()));
  }
  const std::uint8_t mode[] = {static_cast<std::uint8_t>(config_.receive_mode)};
  if (uses[0] == LineUse::kInput) FL_TRY(write(context, ProMessage(ProLabel::kReceiveMode, mode).bytes()));
  if (uses.size() > 1 && uses[1] == LineUse::kInput && config_.second_port->receive_mode != 0)
    FL_TRY(write(context, ProMessage(ProLabel{config_.second_port->receive_mode}, mode).bytes()));
  if (uses[0] == LineUse::kInput && config_.receive_mode == ProReceiveMode::kOnChange && params_.firmware >> 8 == 2)
    traits.remarks.emplace_back("its RDM firmware does not report changes; frames may be missing");
  return {};
}

Status EnttecPro::send(WidgetContext& context, int line, std::span<const std::uint8_t, kSlotCountMax> snapshot) {
  if (cut_short_) {
    // The widget still waits for the rest of a message and would read this one as that rest.
    FL_TRY(write(context, pro_flush_bytes()));
    cut_short_ = false;
  }
  Line& out = lines_[static_cast<std::size_t>(line)];
  out.frame[0] = kStartCodeLevels;
  std::copy(snapshot.begin(), snapshot.end(), out.frame.begin() + 1);
  out.shows = true;
  return write(context, ProMessage(ProLabel{out.send_label}, out.frame).bytes());
}

Result<Octets> EnttecPro::exchange_rdm(WidgetContext& context, int line, std::span<const std::uint8_t> request) {
  if (line != 0 || context.lines()[0] != LineUse::kOutput)
    return fail(ErrorCode::kUnsupported, "{}: RDM works on connector 1, as an output", context.transport().where());
  FL_ASSIGN(const RdmMessage sent, parse_rdm(request));
  const bool searches = sent.command == RdmCommand::kDiscovery && sent.parameter == kRdmUniqueBranch;
  if (cut_short_) {
    FL_TRY(write(context, pro_flush_bytes()));
    cut_short_ = false;
  }
  FL_TRY(write(context, ProMessage(searches ? ProLabel::kRdmDiscovery : ProLabel::kSendRdm, request).bytes()));
  // A broadcast gets no response, but the widget may report a timeout, which must not be taken for the next answer.
  const bool is_silent = sent.to.is_broadcast() && !searches;
  const TimeNs deadline_ns = context.now_ns() + (is_silent ? config_.rdm_timeout_ns / 3 : config_.rdm_timeout_ns);
  Octets answer;
  bool done = false;
  bool answered = false;
  while (!done) {
    ProMessageView message;
    while (!done && parser_.next(unread_, message)) {
      if (message.label == number_of(ProLabel::kRdmTimeout)) {
        done = answered = true;
      } else if (message.label == number_of(ProLabel::kReceived)) {
        const auto received = decode_received(message.payload);
        // Levels are old: the widget received them from another console.
        if (!received || received->frame[0] == kStartCodeLevels) continue;
        if (!searches && received->frame[0] != kRdmStartCode) continue;
        answer.assign(received->frame.begin(), received->frame.end());
        done = answered = true;
      } else {
        (void)take_line_message(context, message);
      }
    }
    if (done || context.stopping() || context.now_ns() >= deadline_ns) break;
    FL_ASSIGN(const std::size_t count, context.transport().read(input_, deadline_ns));
    unread_ = std::span<const std::uint8_t>(input_).first(count);
  }
  if (Line& out = lines_[0]; out.shows) FL_TRY(write(context, ProMessage(ProLabel{out.send_label}, out.frame).bytes()));
  if (answered) rdm_answers_ = true;
  if (!answered && !searches && !is_silent && !rdm_answers_ && params_.firmware >> 8 == 1)
    return fail(ErrorCode::kUnsupported,
                "{}: firmware {}.{} does not support RDM; load ENTTEC's firmware for RDM (2.x)",
                context.transport().where(), params_.firmware >> 8, params_.firmware & 0xFF);
  return answer;
}

Status EnttecPro::listen(WidgetContext& context, TimeNs deadline_ns) {
  ProMessageView message;
  while (parser_.next(unread_, message)) (void)take_line_message(context, message);
  count_rejected(context);
  const TimeNs split_ns = parser_.pending() ? received_ns_ + kSplitMessageNs : kTimeNever;
  FL_ASSIGN(const std::size_t count, context.transport().read(input_, std::min(deadline_ns, split_ns)));
  unread_ = std::span<const std::uint8_t>(input_).first(count);
  const TimeNs now_ns = context.now_ns();
  if (count > 0)
    received_ns_ = now_ns;
  else if (parser_.pending() && now_ns >= split_ns)
    parser_.abandon();
  while (parser_.next(unread_, message)) (void)take_line_message(context, message);
  count_rejected(context);
  return {};
}

bool EnttecPro::take_line_message(WidgetContext& context, const ProMessageView& message) {
  const SecondPort second = config_.second_port.value_or(SecondPort{});
  const auto is = [&](ProLabel label, std::uint8_t second_label) {
    if (message.label == number_of(label)) return 0;
    return message.label == second_label && second_label != 0 ? 1 : -1;
  };
  const TimeNs now_ns = context.now_ns();
  if (const int at = is(ProLabel::kReceived, second.receive); at >= 0) {
    const auto received = decode_received(message.payload);
    if (!received) {
      ++bad_payload_count_;
    } else if (received->queue_overflow || received->overrun) {
      // Slots may be missing anywhere in it, so the rest is at wrong addresses.
      ++line_error_count_;
    } else {
      LineFrame& frame = lines_[static_cast<std::size_t>(at)].frame;
      std::copy(received->frame.begin(), received->frame.end(), frame.begin());
      context.deliver(at, received->frame, now_ns);
    }
    return true;
  }
  if (const int at = is(ProLabel::kChangeOfState, second.change_of_state); at >= 0) {
    LineFrame& frame = lines_[static_cast<std::size_t>(at)].frame;
    if (apply_change_of_state(message.payload, frame))
      context.deliver(at, frame, now_ns);
    else
      ++bad_payload_count_;
    return true;
  }
  return false;  // late answers, and labels of relatives
}

void EnttecPro::count_rejected(WidgetContext& context) {
  const std::uint64_t rejected = parser_.rejected_count() + bad_payload_count_ + line_error_count_;
  if (rejected == reported_rejected_) return;
  context.count_rejected(rejected - reported_rejected_);
  reported_rejected_ = rejected;
}

std::vector<WidgetFigure> EnttecPro::figures() const {
  return {{"garbage_bytes", static_cast<double>(parser_.garbage_byte_count())},
          {"bad_messages", static_cast<double>(parser_.rejected_count() + bad_payload_count_)},
          {"line_errors", static_cast<double>(line_error_count_)},
          {"widget_serial", static_cast<double>(serial_)},
          {"firmware", static_cast<double>(params_.firmware)},
          {"break_us", us_of_pro_units(params_.break_units)},
          {"mab_us", us_of_pro_units(params_.mab_units)},
          {"rate_hz", static_cast<double>(params_.rate_hz)}};
}

// --- The driver's row

namespace {

constexpr UsbModelId kModels[] = {
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "ENTTEC",
     .product_text = "DMX USB PRO Mk2",
     .model_name = "ENTTEC DMX USB Pro Mk2",
     .quirks = kQuirkGenericUsbIds | kQuirkSecondPortNeedsKey},
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "ENTTEC",
     .product_text = "DMX USB PRO",
     .model_name = "ENTTEC DMX USB Pro",
     .quirks = kQuirkGenericUsbIds},
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "DMXking",
     .product_text = "",
     .model_name = "DMXking ultraDMX",
     .quirks = kQuirkGenericUsbIds | kQuirkTwoPorts},
    {.vendor = 0x0403,
     .product = 0x6001,
     .manufacturer_text = "",
     .product_text = "DMXIS",
     .model_name = "ENTTEC DMXIS",
     .quirks = kQuirkGenericUsbIds},
    {.vendor = 0x1FC9,
     .product = 0x0094,
     .manufacturer_text = "",
     .product_text = "",
     .model_name = "DMXking MAX",
     .quirks = kQuirkTwoPorts,
     .transport = TransportKind::kTty},
};

// An unknown device may have a second connector; begin() finds out.
Result<std::unique_ptr<Widget>> make_enttec_pro(const PortRequest& request, const UsbModelId& model) {
  const bool unknown = model.vendor == 0;
  const bool needs_key = (model.quirks & kQuirkSecondPortNeedsKey) != 0;
  const bool two = unknown || needs_key || (model.quirks & kQuirkTwoPorts) != 0;
  return std::make_unique<EnttecPro>(EnttecProConfig{
      .line_count = two ? 2 : 1,
      .second_needs_key = needs_key,
      .second_port = request.second_port,
      .receive_mode = request.receive_on_change ? ProReceiveMode::kOnChange : ProReceiveMode::kEveryFrame});
}

}  // namespace

extern constinit const DriverInfo enttec_pro_driver{
    .id = "enttec-pro",
    .full_name = "ENTTEC DMX USB Pro and compatible",
    .usb_ids = kModels,
    .capabilities = kCanOutput | kCanInput | kKeepsSnapshotAlive,
    .notes = "One universe per connector, in or out. The widget times the line itself.",
    .make_widget = make_enttec_pro,
    .make_model = []() -> std::unique_ptr<mock::UsbModel> {
      auto model = std::make_unique<mock::EnttecProModel>();
      model->rdm_line = mock::example_rdm_line();
      return model;
    },
};

}  // namespace footlight::drivers
