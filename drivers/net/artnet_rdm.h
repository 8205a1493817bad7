// The RDM line behind an Art-Net gateway: discovery is the gateway's, messages go through it.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "drivers/net/artnet_rdm_packet.h"
#include "drivers/net/udp.h"
#include "drivers/rdm/rdm_line.h"
#include "sim/core/clock.h"
#include "sim/core/endpoint.h"
#include "sim/core/result.h"

namespace footlight::drivers {

class ArtnetRdmLine final : public RdmLine {
 public:
  struct Options {
    std::string name;            // begins messages
    std::uint32_t gateway = 0;   // IPv4
    std::uint16_t udp_port = 0;  // of the gateway, and ours where it can be had
    int port_address = 0;
    DurationNs answer_timeout_ns = 2 * kNsPerS;      // of one message: the gateway may have others to serve
    DurationNs discovery_timeout_ns = 15 * kNsPerS;  // of a search from scratch
  };
  // The clock outlives it.
  [[nodiscard]] static Result<std::unique_ptr<ArtnetRdmLine>> open(const Options& options, Clock& clock);

  [[nodiscard]] Result<std::optional<RdmMessage>> transact(const RdmMessage& request) override;
  // The gateway's table; where it is empty the gateway is told to search, and waited for. kTimeout: it does not answer.
  [[nodiscard]] Result<std::vector<RdmFound>> discover() override;

 private:
  ArtnetRdmLine(const Options& options, Fd socket, Clock& clock)
      : options_(options), socket_(std::move(socket)), clock_(clock) {}
  Status send(const ArtnetRdmPacket& packet);
  // Gives what the gateway says to `take` until it returns true (then true) or the deadline has passed.
  Result<bool> listen(TimeNs deadline_ns, const std::function<bool(const ArtnetRdmPacket&)>& take);

  Options options_;
  Fd socket_;
  Clock& clock_;
  DatagramReader reader_;
};

// From the words of an endpoint with one universe and one address. kBadInput says what was expected.
[[nodiscard]] Result<std::unique_ptr<RdmLine>> open_artnet_rdm_line(const Endpoint& endpoint, Clock& clock);

}  // namespace footlight::drivers
