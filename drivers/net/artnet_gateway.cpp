#include "drivers/net/artnet_gateway.h"

#include <algorithm>
#include <utility>

namespace footlight::drivers {
namespace {

// Controllers that wait for one search at a time.
constexpr std::size_t kWaitingMax = 16;

ArtnetAnswers::Requester asker_of(const Datagram& datagram) {
  ArtnetAnswers::Requester requester;
  requester.ipv4 = datagram.from_ipv4;
  requester.udp_port = datagram.from_udp_port;
  requester.is_here = is_from_here(datagram);
  return requester;
}

}  // namespace

void ArtnetGateway::add_universe(int port_address, Universe universe, std::uint8_t bind_index, std::uint8_t port) {
  Line& line = lines_[port_address];
  line.universe = universe;
  line.bind_index = bind_index;
  line.port = port;
}

bool ArtnetGateway::has_line(int port_address) const {
  const auto line = lines_.find(port_address);
  return line != lines_.end() && directory_->find(line->second.universe).has_value();
}

ArtnetGateway::~ArtnetGateway() {
  for (auto& [port_address, line] : lines_) {
    if (line.agent) retire(port_address, line);
  }
}

// Requests to the agent stay unanswered; requesters repeat them.
void ArtnetGateway::retire(int port_address, Line& line) {
  std::erase_if(tickets_, [&](const auto& ticket) { return ticket.second.port_address == port_address; });
  line.waiting.clear();
  directory_->retire(std::move(line.agent));
}

ArtnetGateway::Line* ArtnetGateway::find(int port_address) {
  const auto found = lines_.find(port_address);
  if (found == lines_.end()) return nullptr;
  Line& line = found->second;
  const auto entry = directory_->find(line.universe);
  if (!entry) return nullptr;
  if (line.agent && line.generation == entry->generation) return &line;
  if (line.agent) retire(port_address, line);
  auto agent = RdmAgent::create(entry->make_line());
  if (!agent) return nullptr;
  line.agent = std::move(*agent);
  line.generation = entry->generation;
  if (on_new_descriptor) on_new_descriptor(line.agent->fd());
  return &line;
}

void ArtnetGateway::send_table(int port_address, const Line& line, const ArtnetAnswers::Requester& to,
                               std::vector<Reply>& replies) {
  const auto table = line.agent->table().value_or(std::vector<RdmUid>{});
  ArtnetTodData data;
  data.port_address = port_address;
  data.bind_index = line.bind_index;
  data.port = line.port;
  data.total = static_cast<std::uint16_t>(table.size());
  for (std::size_t first = 0; first == 0 || first < table.size(); first += kArtnetTodUidsMax) {
    const std::size_t last = std::min(first + kArtnetTodUidsMax, table.size());
    data.block = static_cast<std::uint8_t>(first / kArtnetTodUidsMax);
    data.uids.assign(table.begin() + static_cast<std::ptrdiff_t>(first),
                     table.begin() + static_cast<std::ptrdiff_t>(last));
    replies.push_back({build_artnet_rdm_packet(data), to});
  }
}

void ArtnetGateway::wait_for_search(Line& line, const ArtnetAnswers::Requester& requester) {
  const bool waits = std::any_of(line.waiting.begin(), line.waiting.end(), [&](const auto& one) {
    return one.ipv4 == requester.ipv4 && one.udp_port == requester.udp_port;
  });
  if (waits) return;
  if (line.waiting.size() < kWaitingMax) line.waiting.push_back(requester);
  line.agent->search();
}

void ArtnetGateway::take(const ArtnetRdmPacket& packet, const Datagram& datagram, std::vector<Reply>& replies) {
  const ArtnetAnswers::Requester requester = asker_of(datagram);
  if (const auto* request = std::get_if<ArtnetTodRequest>(&packet)) {
    for (const int port_address : request->port_addresses) {
      Line* const line = find(port_address);
      if (line == nullptr) continue;
      // The line is searched at the first request, not before, because DMX pauses meanwhile.
      if (line->agent->table()) {
        send_table(port_address, *line, requester, replies);
      } else {
        wait_for_search(*line, requester);
      }
    }
  } else if (const auto* control = std::get_if<ArtnetTodControl>(&packet)) {
    Line* const line = find(control->port_address);
    if (line == nullptr) return;
    if (control->flush || !line->agent->table()) {
      wait_for_search(*line, requester);
    } else {
      send_table(control->port_address, *line, requester, replies);
    }
  } else if (const auto* rdm = std::get_if<ArtnetRdm>(&packet)) {
    const auto message = parse_rdm_message(rdm->message);
    // Discovery is done by this gateway.
    if (!message || is_response(message->command) || message->command == RdmCommand::kDiscovery) return;
    Line* const line = find(rdm->port_address);
    if (line == nullptr || tickets_.size() >= kTicketsMax) return;
    if (line->agent->submit(next_ticket_, *message)) tickets_[next_ticket_++] = {rdm->port_address, requester};
  }
}

void ArtnetGateway::take_news(std::vector<Reply>& replies) {
  for (auto& [port_address, line] : lines_) {
    if (!line.agent) continue;
    RdmAgent::News news = line.agent->take();
    for (const auto& answer : news.answers) {
      const auto ticket = tickets_.find(answer.ticket);
      if (ticket == tickets_.end()) continue;
      if (answer.message) {
        ArtnetRdm rdm;
        rdm.port_address = ticket->second.port_address;
        rdm.message = build_rdm(*answer.message);
        replies.push_back({build_artnet_rdm_packet(rdm), ticket->second.requester});
      }
      tickets_.erase(ticket);
    }
    if (!news.table_changed) continue;
    for (const auto& requester : std::exchange(line.waiting, {})) send_table(port_address, line, requester, replies);
  }
}

}  // namespace footlight::drivers
