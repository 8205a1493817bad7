// The part of an Art-Net input that is a gateway for RDM: tables of devices, and messages passed on to the lines behind
// its universes. No socket: what is to be sent is handed back.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <span>
#include <vector>

#include "drivers/net/artnet_nodes.h"
#include "drivers/net/artnet_rdm_packet.h"
#include "drivers/rdm/rdm_agent.h"
#include "drivers/rdm/rdm_directory.h"

namespace footlight::drivers {

class ArtnetGateway {
 public:
  // Messages under way, of all lines, whose answer somebody waits for.
  static constexpr std::size_t kTicketsMax = 64;

  struct Reply {
    Octets bytes;
    ArtnetAnswers::Asker to;
  };

  explicit ArtnetGateway(std::shared_ptr<RdmDirectory> directory) : directory_(std::move(directory)) {}
  ~ArtnetGateway();
  ArtnetGateway(const ArtnetGateway&) = delete;
  ArtnetGateway& operator=(const ArtnetGateway&) = delete;

  // A universe whose line, where there is one, is to be reached. `bind_index` and `port` (1 to 4): as its ArtPollReply
  // has them.
  void add_universe(int port_address, Universe universe, std::uint8_t bind_index, std::uint8_t port);
  [[nodiscard]] bool has_line(int port_address) const;
  // Called with the descriptor of each line that comes into use: readable when take_news() has something to do.
  std::function<void(int fd)> on_new_descriptor;

  // A request of a controller. What can be answered at once is appended to `replies`.
  void take(const ArtnetRdmPacket& packet, const Datagram& datagram, std::vector<Reply>& replies);
  // Answers and tables that the lines have meanwhile.
  void take_news(std::vector<Reply>& replies);

 private:
  struct Line {
    Universe universe = 0;
    std::uint8_t bind_index = 1;
    std::uint8_t port = 1;
    std::uint64_t generation = 0;               // of the directory, that `agent` was made from
    std::unique_ptr<RdmAgent> agent;            // made when it is first needed
    std::vector<ArtnetAnswers::Asker> waiting;  // for the end of a search
  };
  struct Ticket {
    int port_address = 0;
    ArtnetAnswers::Asker asker;
  };
  // In blocks.
  static void tell_table(int port_address, const Line& line, const ArtnetAnswers::Asker& to,
                         std::vector<Reply>& replies);
  static void wait_for_search(Line& line, const ArtnetAnswers::Asker& asker);
  // Gives up the line's agent and its tickets, without waiting.
  void retire(int port_address, Line& line);
  // With its agent; nullptr: there is no line now.
  Line* find(int port_address);

  const std::shared_ptr<RdmDirectory> directory_;
  std::map<int, Line> lines_;  // by port address
  std::map<std::uint64_t, Ticket> tickets_;
  std::uint64_t next_ticket_ = 1;
};

}  // namespace footlight::drivers
