#include "drivers/net/net.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "drivers/machine_id.h"
#include "drivers/net/artnet_nodes.h"
#include "drivers/net/hash.h"
#include "drivers/net/unicast_exchange.h"

namespace footlight::drivers {
namespace {

tl::unexpected<Error> not_of_the_network(const Endpoint& endpoint) {
  return fail(ErrorCode::kBadInput, "{}: expected an endpoint of the network, as in sacn:1-9 or artnet:1-9@10.9.0.255",
              endpoint.text);
}

}  // namespace

Result<std::unique_ptr<Source>> make_net_source(const Endpoint& endpoint,
                                                const std::shared_ptr<OwnSenders>& own_senders) {
  if (endpoint.scheme == "sacn") {
    return make_sacn_source(options_of<SacnSourceOptions>(endpoint, own_senders));
  }
  if (endpoint.scheme == "artnet") {
    return make_artnet_source(options_of<ArtnetSourceOptions>(endpoint, own_senders));
  }
  return not_of_the_network(endpoint);
}

Result<std::unique_ptr<Sink>> make_net_sink(const Endpoint& endpoint, const std::shared_ptr<OwnSenders>& own_senders) {
  if (endpoint.scheme == "sacn") return make_sacn_sink(options_of<SacnSinkOptions>(endpoint, own_senders));
  if (endpoint.scheme == "artnet") {
    return make_artnet_sink(options_of<ArtnetSinkOptions>(endpoint, own_senders));
  }
  return not_of_the_network(endpoint);
}

OwnSenders::OwnSenders() : artnet_(std::make_unique<ArtnetProgram>()), unicast_(std::make_unique<UnicastExchange>()) {}
OwnSenders::~OwnSenders() = default;

void OwnSenders::add_cid(const Cid& cid) {
  const std::lock_guard lock(mutex_);
  if (std::find(cids_.begin(), cids_.end(), cid) == cids_.end()) cids_.push_back(cid);
}

bool OwnSenders::has_cid(const Cid& cid) const {
  const std::lock_guard lock(mutex_);
  return std::find(cids_.begin(), cids_.end(), cid) != cids_.end();
}

Cid sacn_cid(std::string_view machine, std::string_view source_name, std::string_view endpoint) {
  const std::uint64_t machine_digest = mix64(fnv1a64(machine));
  std::uint64_t halves[2];
  for (std::uint64_t i = 0; i < 2; ++i) {
    const std::uint64_t seed = mix64(machine_digest + i);
    halves[i] = mix64(fnv1a64(endpoint, mix64(fnv1a64(source_name, seed))));
  }
  Cid cid;
  for (std::size_t i = 0; i < cid.size(); ++i) cid[i] = static_cast<std::uint8_t>(halves[i / 8] >> (8 * (i % 8)));
  cid[6] = static_cast<std::uint8_t>((cid[6] & 0x0F) | 0x80);  // version 8: custom
  cid[8] = static_cast<std::uint8_t>((cid[8] & 0x3F) | 0x80);  // variant of RFC 9562
  return cid;
}

Cid sacn_cid_of(const SacnSinkOptions& options) {
  if (options.cid != Cid{}) return options.cid;
  return sacn_cid(machine_id(), options.source_name, options.name);
}

}  // namespace footlight::drivers
