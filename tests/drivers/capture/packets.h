// Packets and packet captures from our own encoders, for tests and for the corpora of fuzz targets.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "drivers/net/artnet_packet.h"
#include "drivers/net/sacn_packet.h"

namespace footlight::testing::packets {

using Bytes = std::vector<std::uint8_t>;

inline Bytes join(const std::vector<Bytes>& parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}
inline void put_be16(Bytes& to, std::size_t value) {
  to.push_back(static_cast<std::uint8_t>(value >> 8));
  to.push_back(static_cast<std::uint8_t>(value));
}

inline Bytes ethernet(std::uint16_t type, const Bytes& payload) {
  Bytes packet(12, 0x02);
  put_be16(packet, type);
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}
// From 10.0.0.7. Without checksums, which are not checked.
inline Bytes ipv4(const Bytes& payload) {
  Bytes packet = {0x45, 0};
  put_be16(packet, 20 + payload.size());
  packet.insert(packet.end(), {0, 0, 0x40, 0, 64, 17, 0, 0, 10, 0, 0, 7, 239, 255, 0, 1});
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}
inline Bytes ipv6(const Bytes& payload) {
  Bytes packet = {0x60, 0, 0, 0};
  put_be16(packet, payload.size());
  packet.insert(packet.end(), {17, 64});
  packet.insert(packet.end(), 32, 0xFD);
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}
inline Bytes udp(std::uint16_t to_port, const Bytes& payload) {
  Bytes packet;
  put_be16(packet, 40'000);
  put_be16(packet, to_port);
  put_be16(packet, 8 + payload.size());
  put_be16(packet, 0);
  packet.insert(packet.end(), payload.begin(), payload.end());
  return packet;
}

struct Sacn {
  int universe = 1;
  std::uint8_t sequence = 0;
  std::uint8_t cid = 1;
  std::uint8_t priority = 100;
  std::uint8_t start_code = 0;
  bool preview = false;
  bool terminated = false;
};

inline Bytes sacn_data(const Sacn& sacn, std::span<const std::uint8_t> slots) {
  drivers::SacnData data;
  data.cid.fill(sacn.cid);
  data.source_name = "test";
  data.universe = sacn.universe;
  data.sequence = sacn.sequence;
  data.priority = sacn.priority;
  data.start_code = sacn.start_code;
  data.preview = sacn.preview;
  data.terminated = sacn.terminated;
  data.slots = slots;
  Bytes packet(drivers::kSacnDataBytesMax);
  packet.resize(drivers::build_sacn_data(data, packet));
  return packet;
}

inline Bytes artnet_dmx(int port_address, std::uint8_t sequence, std::span<const std::uint8_t> slots) {
  drivers::ArtnetDmx dmx;
  dmx.port_address = port_address;
  dmx.sequence = sequence;
  dmx.slots = slots;
  Bytes packet(drivers::kArtnetDmxBytesMax);
  packet.resize(drivers::build_artnet_dmx(dmx, packet));
  return packet;
}

// A file in libpcap's format (draft-ietf-opsawg-pcap), in either byte order, with times to a microsecond or nanosecond.
class Pcap {
 public:
  Pcap(std::uint32_t link_type, bool nanoseconds, bool big_endian) : nanoseconds_(nanoseconds), big_(big_endian) {
    put(nanoseconds ? 0xA1B23C4D : 0xA1B2C3D4, 4);
    put(2, 2);
    put(4, 2);
    put(0, 4);
    put(0, 4);
    put(65'535, 4);
    put(link_type, 4);
  }
  // true_size: on the wire, if that is more than was captured.
  void add(std::int64_t unix_ns, const Bytes& packet, std::size_t true_size = 0) {
    put(static_cast<std::uint64_t>(unix_ns / 1'000'000'000), 4);
    put(static_cast<std::uint64_t>(unix_ns % 1'000'000'000 / (nanoseconds_ ? 1 : 1'000)), 4);
    put(packet.size(), 4);
    put(true_size == 0 ? packet.size() : true_size, 4);
    bytes_.insert(bytes_.end(), packet.begin(), packet.end());
  }
  [[nodiscard]] const Bytes& bytes() const { return bytes_; }

 private:
  void put(std::uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; ++i) {
      bytes_.push_back(static_cast<std::uint8_t>(value >> (8 * (big_ ? byte_count - 1 - i : i))));
    }
  }
  bool nanoseconds_;
  bool big_;
  Bytes bytes_;
};

}  // namespace footlight::testing::packets
