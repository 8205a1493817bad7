// The RDM gateway of an Art-Net input: tables of devices, and messages passed to the lines behind its universes. No
// socket: replies are returned to the caller.
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
  // Messages in progress on all lines whose requester waits for an answer.
  static constexpr std::size_t kTicketsMax = 64;

  struct Reply {
    Octets bytes;
    ArtnetAnswers::Requester to;
  };

  explicit ArtnetGateway(std::shared_ptr<RdmDirectory> directory) : directory_(std::move(directory)) {}
  ~ArtnetGateway();
  ArtnetGateway(const ArtnetGateway&) = delete;
  ArtnetGateway& operator=(const ArtnetGateway&) = delete;

  // Adds a universe whose line, if any, can be reached. `bind_index` and `port` (1 to 4): as in its ArtPollReply.
  void add_universe(int port_address, Universe universe, std::uint8_t bind_index, std::uint8_t port);
  [[nodiscard]] bool has_line(int port_address) const;
  // Called with the descriptor of each line that comes into use. It is readable when take_news() has work.
  std::function<void(int fd)> on_new_descriptor;

  // Takes a request of a controller. Immediate answers are appended to `replies`.
  void take(const ArtnetRdmPacket& packet, const Datagram& datagram, std::vector<Reply>& replies);
  // Appends answers and tables that the lines have produced since.
  void take_news(std::vector<Reply>& replies);

 private:
  struct Line {
    Universe universe = 0;
    std::uint8_t bind_index = 1;
    std::uint8_t port = 1;
    std::uint64_t generation = 0;                   // of the directory when `agent` was made
    std::unique_ptr<RdmAgent> agent;                // made when first needed
    std::vector<ArtnetAnswers::Requester> waiting;  // for the end of a search
  };
  struct Ticket {
    int port_address = 0;
    ArtnetAnswers::Requester requester;
  };
  // Sends the table, in blocks.
  static void send_table(int port_address, const Line& line, const ArtnetAnswers::Requester& to,
                         std::vector<Reply>& replies);
  static void wait_for_search(Line& line, const ArtnetAnswers::Requester& requester);
  // Drops the line's agent and its tickets, without waiting.
  void retire(int port_address, Line& line);
  // The line with its agent; nullptr: there is no line now.
  Line* find(int port_address);

  const std::shared_ptr<RdmDirectory> directory_;
  std::map<int, Line> lines_;  // by port address
  std::map<std::uint64_t, Ticket> tickets_;
  std::uint64_t next_ticket_ = 1;
};

}  // namespace footlight::drivers
