#include "drivers/net/vrsl_osc.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <utility>

#include "drivers/net/hash.h"

namespace footlight::drivers {
namespace {

constexpr std::string_view kPrefix = "/VRSL";
constexpr std::uint32_t kThisMachine = 0x7F00'0001;
constexpr std::size_t kAskedMax = 64;
constexpr DurationNs kRetryNs = 500 * kNsPerMs;  // while the network is down
// Nobody repeats a level that stays: a sender is never removed for its silence.
constexpr DurationNs kSilenceNs = DurationNs{1'000} * 24 * 3'600 * kNsPerS;

// The number at the end of a text; nullopt: it ends with none, or with one that is no channel.
std::optional<int> number_at_end(std::string_view text) {
  const std::size_t last_other = text.find_last_not_of("0123456789");
  const std::string_view digits = text.substr(last_other == std::string_view::npos ? 0 : last_other + 1);
  int number = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), number);
  if (digits.empty() || error != std::errc{} || end != digits.data() + digits.size()) return std::nullopt;
  return number;
}

std::optional<int> whole(double number, int max) {
  if (!(number >= 0.0 && number <= max)) return std::nullopt;  // NaN too
  return static_cast<int>(std::lround(number));
}

Status check_planes(const NetOptions& options) {
  return check_universes(options.name, options.universes, kVrslUniverses);
}

}  // namespace

std::optional<VrslCell> vrsl_cell_of(const OscMessage& message) {
  if (!message.address.starts_with(kPrefix) || !message.all_numbers) return std::nullopt;
  const std::string_view rest = message.address.substr(kPrefix.size());
  if (!rest.empty() && rest.front() != '/') return std::nullopt;
  if (rest.starts_with("/Command")) return std::nullopt;
  auto arguments = std::span(message.numbers).first(message.number_count);
  std::optional<int> channel = number_at_end(rest);
  if (!channel && !arguments.empty()) {
    channel = whole(arguments.front(), kVrslCells);
    arguments = arguments.subspan(1);
  }
  if (!channel || *channel < 1 || *channel > kVrslCells) return std::nullopt;
  if (arguments.size() != 1 && arguments.size() != kVrslPlanes) return std::nullopt;
  VrslCell cell;
  cell.channel = *channel;
  cell.level_count = static_cast<int>(arguments.size());
  for (std::size_t i = 0; i < arguments.size(); ++i) {
    const auto level = whole(arguments[i], 255);
    if (!level) return std::nullopt;
    cell.levels[i] = static_cast<std::uint8_t>(*level);
  }
  return cell;
}

Result<std::unique_ptr<VrslOscSource>> VrslOscSource::create(const VrslOscSourceOptions& options) {
  FL_TRY(check_planes(options));
  if (options.port < 2) {
    return fail(ErrorCode::kBadInput, "{}: requests go to the port below; expected a UDP port from 2", options.name);
  }
  Settings settings(options);
  settings.silence_max_ns = kSilenceNs;
  SenderSocket wanted;
  wanted.port_name = options.name;
  FL_ASSIGN(Fd asker, open_sender(wanted));
  auto source = std::unique_ptr<VrslOscSource>(new VrslOscSource(std::move(settings), std::move(asker)));
  FL_TRY(source->open());
  source->ask(kThisMachine);
  return source;
}

VrslOscSource::VrslOscSource(Settings settings, Fd asker) : NetSource(std::move(settings)), asker_(std::move(asker)) {
  const std::array<std::int32_t, 1> nothing = {0};  // the argument that VRSL's reader sends
  request_bytes_ = build_osc(kVrslOscRefresh, nothing, request_);
}

void VrslOscSource::ask(std::uint32_t ipv4) {
  if (asked_.size() == kAskedMax || std::find(asked_.begin(), asked_.end(), ipv4) != asked_.end()) return;
  asked_.push_back(ipv4);
  writer_.add(std::span(request_).first(request_bytes_), ipv4, static_cast<std::uint16_t>(settings().port - 1));
  if (writer_.flush(asker_.get()).error_number != 0) count_error();
}

void VrslOscSource::take(const Datagram& datagram, TimeNs stamp_ns, FrameReceiver& /*receiver*/) {
  messages_.clear();
  if (!parse_osc(datagram.bytes, messages_)) {
    count_rejected();
    return;
  }
  for (const OscMessage& message : messages_) {
    const auto cell = vrsl_cell_of(message);
    const int slot = cell ? (cell->channel - 1) % kVrslCellsPerUniverse : kSlotCountMax;
    if (slot >= kSlotCountMax) {
      ++other_messages_;
      continue;
    }
    ask(datagram.from_ipv4);
    for (int plane = 0; plane < cell->level_count; ++plane) {
      const auto universe = static_cast<std::size_t>(plane * kVrslPlanes + (cell->channel - 1) / kVrslCellsPerUniverse);
      levels_[universe][static_cast<std::size_t>(slot)] = cell->levels[static_cast<std::size_t>(plane)];
      changed_.set(universe);
    }
    stamp_ns_ = stamp_ns;
  }
}

Status VrslOscSource::poll(TimeNs now_ns, FrameReceiver& receiver) {
  const Status polled = NetSource::poll(now_ns, receiver);
  for (std::size_t universe = 0; changed_.any() && universe < changed_.size(); ++universe) {
    if (!changed_[universe]) continue;
    changed_.reset(universe);
    const int place = place_of(static_cast<int>(universe) + 1);
    if (place < 0) {
      ++other_messages_;
      continue;
    }
    FrameView frame;
    frame.universe = show_universe(place);
    frame.stamp_ns = stamp_ns_;
    frame.sender = sender_hash({reinterpret_cast<const std::uint8_t*>(kPrefix.data()), kPrefix.size()});
    frame.silence_max_ns = kSilenceNs;
    frame.slots = levels_[universe];
    deliver(frame, receiver);
  }
  return polled;
}

Result<std::unique_ptr<VrslOscSink>> VrslOscSink::create(const VrslOscSinkOptions& options) {
  FL_TRY(check_planes(options));
  if (options.port < 2) {
    return fail(ErrorCode::kBadInput, "{}: requests come to the port below; expected a UDP port from 2", options.name);
  }
  if (!options.interface_names.empty()) {
    return fail(ErrorCode::kBadInput, "{}: the address decides the interface; leave out what follows \"%\"",
                options.name);
  }
  FL_ASSIGN(std::vector<std::uint32_t> receivers, parse_ipv4_list(options.name, options.addresses));
  if (receivers.empty()) receivers.push_back(kThisMachine);
  for (const std::uint32_t ipv4 : receivers) {
    const int error_number = route_error(ipv4, 0);
    if (error_number != 0) {
      return tl::unexpected(net_error(options.name, fmt::format("send to {}", text_of_ipv4(ipv4)), error_number));
    }
  }
  SenderSocket wanted;
  wanted.port_name = options.name;
  FL_ASSIGN(Fd sender, open_sender(wanted));
  ReceiverSocket listening;
  listening.port_name = options.name;
  listening.udp_port = static_cast<std::uint16_t>(options.port - 1);
  listening.kernel_stamps = false;
  auto listener = open_receiver(listening);
  std::optional<PortNotice> notice;
  if (!listener) {
    notice =
        PortNotice{.level = NoticeLevel::kWarning,
                   .id = "port-shared",
                   .text = fmt::format("requests for all channels are not answered: {}", listener.error().message)};
  }
  auto sink = std::unique_ptr<VrslOscSink>(
      new VrslOscSink(options, std::move(receivers), std::move(sender), listener ? std::move(*listener) : Fd()));
  sink->notice_ = std::move(notice);
  return sink;
}

VrslOscSink::VrslOscSink(const VrslOscSinkOptions& options, std::vector<std::uint32_t> receivers, Fd sender,
                         Fd listener)
    : options_(options),
      receivers_(std::move(receivers)),
      rgb_(std::any_of(options.universes.begin(), options.universes.end(),
                       [](const WireUniverse& universe) { return universe.wire > kVrslUniverses / kVrslPlanes; })),
      show_universes_(show_numbers(options.universes)),
      show_index_(show_universes_),
      sender_(std::move(sender)),
      listener_(std::move(listener)) {
  messages_.reserve(kVrslOscBurst);
}

PortState VrslOscSink::state() const {
  if (!sender_) return PortState::kEnded;
  if (!trouble_.empty()) return PortState::kGone;
  return has_sent_ ? PortState::kWorking : PortState::kWaiting;
}

Status VrslOscSink::send(TimeNs now_ns, std::span<const FrameView> frames) {
  if (!sender_) return {};
  for (const FrameView& frame : frames) {
    const int place = show_index_.find(frame.universe);
    if (place < 0 || frame.terminated || frame.start_code != kStartCodeLevels) continue;
    const auto wire = static_cast<std::size_t>(options_.universes[static_cast<std::size_t>(place)].wire - 1);
    const std::size_t base = wire % kVrslPlanes * kVrslCellsPerUniverse;
    Slots& slots = levels_[wire];
    for (std::size_t i = 0; i < std::min(frame.slots.size(), slots.size()); ++i) {
      if (slots[i] == frame.slots[i]) continue;
      slots[i] = frame.slots[i];
      waiting_.set(base + i);
    }
    if (!known_[wire]) {  // the receiver may have other levels than zeros
      for (std::size_t i = 0; i < slots.size(); ++i) waiting_.set(base + i);
    }
    known_.set(wire);
  }
  transmit(now_ns);
  return {};
}

Status VrslOscSink::poll(TimeNs now_ns) {
  if (!sender_) return {};
  read_requests();
  transmit(now_ns);
  return {};
}

void VrslOscSink::read_requests() {
  if (!listener_) return;
  while (true) {
    const int count = reader_.read(listener_.get());
    if (count < 0) ++counters_.errors;
    if (count <= 0) return;
    for (int i = 0; i < count; ++i) {
      requests_.clear();
      if (!parse_osc(reader_[static_cast<std::size_t>(i)].bytes, requests_)) {
        ++counters_.rejected;
        continue;
      }
      for (const OscMessage& request : requests_) {
        if (request.address != kVrslOscRefresh) continue;
        ++refreshes_;
        mark_all();
      }
    }
  }
}

void VrslOscSink::mark_all() {
  for (std::size_t universe = 0; universe < known_.size(); ++universe) {
    if (!known_[universe]) continue;
    const std::size_t base = universe % kVrslPlanes * kVrslCellsPerUniverse;
    for (std::size_t i = 0; i < kSlotCountMax; ++i) waiting_.set(base + i);
  }
}

void VrslOscSink::transmit(TimeNs now_ns) {
  if (waiting_.none()) {
    due_ns_ = kTimeNever;
    return;
  }
  if (now_ns < burst_ns_ + kVrslOscBurstIntervalNs || (!trouble_.empty() && now_ns < due_ns_)) {
    if (trouble_.empty()) due_ns_ = burst_ns_ + kVrslOscBurstIntervalNs;
    return;
  }
  burst_ns_ = now_ns;
  messages_.clear();
  std::bitset<kVrslCells> sent;
  for (std::size_t step = 0; step < waiting_.size() && messages_.size() < kVrslOscBurst; ++step) {
    const std::size_t cell = (next_cell_ + step) % waiting_.size();
    if (!waiting_[cell]) continue;
    const std::size_t universe = cell / kVrslCellsPerUniverse;
    const std::size_t slot = cell % kVrslCellsPerUniverse;
    std::array<std::int32_t, kVrslPlanes> levels;
    for (std::size_t plane = 0; plane < levels.size(); ++plane) levels[plane] = levels_[plane * 3 + universe][slot];
    Message& message = messages_.emplace_back();
    message.size =
        build_osc(fmt::format("/VRSL/ch{}", cell + 1), std::span(levels).first(rgb_ ? kVrslPlanes : 1), message.bytes);
    sent.set(cell);
  }
  for (const Message& message : messages_) {
    for (const std::uint32_t ipv4 : receivers_) {
      writer_.add(std::span(message.bytes).first(message.size), ipv4, options_.port);
    }
  }
  writer_.flush_each(sender_.get(), error_numbers_);
  // A receiver that is not running refuses datagrams on this machine: it asks for all levels when it starts.
  const auto failed = std::find_if(error_numbers_.begin(), error_numbers_.end(),
                                   [](int error_number) { return error_number != 0 && error_number != ECONNREFUSED; });
  if (failed != error_numbers_.end()) {
    ++counters_.errors;
    trouble_ = net_error(options_.name, "send", *failed).message;
    due_ns_ = now_ns + kRetryNs;
    return;  // everything waits, and is sent with its newest levels
  }
  trouble_.clear();
  waiting_ &= ~sent;
  next_cell_ = (next_cell_ + 1) % waiting_.size();
  for (std::size_t cell = 0; cell < sent.size(); ++cell) {
    if (sent[cell]) next_cell_ = (cell + 1) % waiting_.size();
  }
  counters_.frames += messages_.size();
  has_sent_ = true;
  due_ns_ = waiting_.any() ? now_ns + kVrslOscBurstIntervalNs : kTimeNever;
}

void VrslOscSink::rest(TimeNs /*now_ns*/) {
  waiting_.reset();
  known_.reset();
  due_ns_ = kTimeNever;
}

void VrslOscSink::close(TimeNs /*now_ns*/) {
  sender_.reset();
  listener_.reset();
  due_ns_ = kTimeNever;
}

Result<std::unique_ptr<Source>> make_vrsl_osc_source(const VrslOscSourceOptions& options) {
  FL_ASSIGN(std::unique_ptr<VrslOscSource> source, VrslOscSource::create(options));
  return source;
}

Result<std::unique_ptr<Sink>> make_vrsl_osc_sink(const VrslOscSinkOptions& options) {
  FL_ASSIGN(std::unique_ptr<VrslOscSink> sink, VrslOscSink::create(options));
  return sink;
}

}  // namespace footlight::drivers
