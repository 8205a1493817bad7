#include "drivers/net/artnet_rdm.h"

#include <algorithm>
#include <array>
#include <set>

#include <poll.h>

#include "drivers/net/net.h"

namespace footlight::drivers {
namespace {

constexpr std::array<std::uint16_t, 2> kRdmOpCodes = {kArtnetOpTodData, kArtnetOpRdm};
// How long a gateway with a table may take to send it.
constexpr DurationNs kTableTimeoutNs = 3 * kNsPerS;

}  // namespace

Result<std::unique_ptr<ArtnetRdmLine>> ArtnetRdmLine::open(const Options& options, Clock& clock) {
  SenderSocket wanted;
  wanted.port_name = options.name;
  auto socket = open_yielding_sender(wanted, options.udp_port, kRdmOpCodes);
  if (!socket) socket = open_sender(wanted);
  if (!socket) return tl::unexpected(std::move(socket).error());
  return std::unique_ptr<ArtnetRdmLine>(new ArtnetRdmLine(options, std::move(*socket), clock));
}

Status ArtnetRdmLine::send(const ArtnetRdmPacket& packet) {
  const Octets bytes = build_artnet_rdm_packet(packet);
  DatagramWriter writer;
  writer.add(bytes, options_.gateway, options_.udp_port);
  const auto sent = writer.flush(socket_.get());
  if (sent.error_number == 0) return {};
  return tl::unexpected(
      net_error(options_.name, fmt::format("send to {}", text_of_ipv4(options_.gateway)), sent.error_number));
}

Result<bool> ArtnetRdmLine::listen(TimeNs deadline_ns, const std::function<bool(const ArtnetRdmPacket&)>& take) {
  while (true) {
    const int count = reader_.read(socket_.get());
    if (count < 0) return tl::unexpected(net_error(options_.name, "receive", -count));
    bool done = false;
    for (int i = 0; i < count; ++i) {
      const auto packet = parse_artnet_rdm_packet(reader_[static_cast<std::size_t>(i)].bytes);
      done = done || (packet && take(*packet));
    }
    if (done) return true;
    const DurationNs left_ns = deadline_ns - clock_.now_ns();
    if (left_ns <= 0) return false;
    pollfd waiting = {socket_.get(), POLLIN, 0};
    (void)::poll(&waiting, 1, static_cast<int>(left_ns / kNsPerMs) + 1);
  }
}

Result<std::optional<RdmMessage>> ArtnetRdmLine::transact(const RdmMessage& request) {
  FL_TRY(send(ArtnetRdm{options_.port_address, build_rdm(request)}));
  if (request.to.is_broadcast()) return std::nullopt;
  std::optional<RdmMessage> answer;
  FL_TRY(listen(clock_.now_ns() + options_.answer_timeout_ns, [&](const ArtnetRdmPacket& packet) {
    const auto* const rdm = std::get_if<ArtnetRdm>(&packet);
    if (rdm == nullptr || rdm->port_address != options_.port_address) return false;
    auto message = parse_rdm_message(rdm->message);
    if (!message || message->from != request.to || message->to != request.from ||
        message->transaction != request.transaction || message->command != response_to(request.command)) {
      return false;
    }
    answer = std::move(*message);
    return true;
  }));
  return answer;
}

Result<std::vector<RdmFound>> ArtnetRdmLine::discover() {
  std::set<RdmUid> uids;
  bool is_empty = false;
  const auto take = [&](const ArtnetRdmPacket& packet) {
    const auto* const data = std::get_if<ArtnetTodData>(&packet);
    if (data == nullptr || data->port_address != options_.port_address || !data->available) return false;
    uids.insert(data->uids.begin(), data->uids.end());
    is_empty = data->total == 0;
    return !is_empty && uids.size() >= data->total;
  };
  FL_TRY(send(ArtnetTodRequest{{options_.port_address}}));
  FL_ASSIGN(bool whole, listen(clock_.now_ns() + kTableTimeoutNs,
                               [&](const ArtnetRdmPacket& packet) { return take(packet) || is_empty; }));
  if (!whole || is_empty) {
    FL_TRY(send(ArtnetTodControl{options_.port_address, true}));
    FL_ASSIGN(whole, listen(clock_.now_ns() + options_.discovery_timeout_ns, take));
  }
  if (!whole && uids.empty() && !is_empty) {
    return fail(ErrorCode::kTimeout,
                "{}: {} does not answer for this universe; is it a gateway for RDM with that port address? 'footlight "
                "discover' lists nodes",
                options_.name, text_of_ipv4(options_.gateway));
  }
  std::vector<RdmFound> found;
  for (const RdmUid& uid : uids) found.push_back({.uid = uid});
  return found;
}

Result<std::unique_ptr<RdmLine>> open_artnet_rdm_line(const Endpoint& endpoint, Clock& clock) {
  if (endpoint.scheme != "artnet" || endpoint.universes.size() != 1 || endpoint.addresses.size() != 1) {
    return fail(ErrorCode::kBadInput, "{}: expected one universe of one gateway, as in artnet:1@10.0.0.7",
                endpoint.text);
  }
  ArtnetRdmLine::Options options;
  options.name = endpoint.text;
  FL_ASSIGN(options.gateway, parse_ipv4(endpoint.text, endpoint.addresses.front()));
  options.udp_port = endpoint.udp_port == 0 ? kArtnetPort : endpoint.udp_port;
  options.port_address = artnet_port_address(endpoint.universes.front().wire);
  FL_ASSIGN(auto line, ArtnetRdmLine::open(options, clock));
  return std::unique_ptr<RdmLine>(std::move(line));
}

}  // namespace footlight::drivers
