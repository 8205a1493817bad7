// A receiver that keeps its frames, and waiting for frames without sleeping.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <time.h>

#include "drivers/net/net.h"
#include "drivers/net/udp.h"
#include "sim/core/ports.h"

namespace footlight::testing {

struct KeptFrame {
  FrameView view;  // its slots are invalid; use `slots`
  std::vector<std::uint8_t> slots;
};

class KeepingReceiver final : public FrameReceiver {
 public:
  void receive(const FrameView& frame) override {
    frames.push_back({frame, {frame.slots.begin(), frame.slots.end()}});
    frames.back().view.slots = {};
  }
  std::vector<KeptFrame> frames;
};

// From sender 0, with the default priority.
inline FrameView frame_of(int universe, std::span<const std::uint8_t> slots) {
  FrameView frame;
  frame.universe = universe;
  frame.slots = slots;
  return frame;
}

inline TimeNs real_now_ns() {
  timespec now = {};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

// Polls the source until `done` returns true or twenty seconds have passed; waits in poll(2). True: done.
template <class Done>
bool poll_until(Source& source, TimeNs now_ns, FrameReceiver& receiver, Done done) {
  const TimeNs deadline_ns = real_now_ns() + 20 * kNsPerS;
  while (!done()) {
    const DurationNs left_ns = deadline_ns - real_now_ns();
    if (left_ns <= 0) return false;
    pollfd waiting = {source.poll_fd(), POLLIN, 0};
    if (::poll(&waiting, 1, static_cast<int>(left_ns / kNsPerMs) + 1) < 0) return false;
    if (!source.poll(now_ns, receiver)) return false;
  }
  return true;
}

// Polls until the descriptor is not readable any more.
inline bool drain(Source& source, TimeNs now_ns, FrameReceiver& receiver) {
  pollfd waiting = {source.poll_fd(), POLLIN, 0};
  while (::poll(&waiting, 1, 0) == 1) {
    if (!source.poll(now_ns, receiver)) return false;
  }
  return true;
}

// Datagrams over "lo" are in the receiver's buffer when the send returns, so draining it shows that there were none.
inline bool receives_nothing(Source& source, TimeNs now_ns, KeepingReceiver& receiver) {
  const std::size_t before = receiver.frames.size();
  return drain(source, now_ns, receiver) && receiver.frames.size() == before;
}

// A UDP socket of another program: bound to this address and port, non-blocking, may broadcast, shares its port.
inline drivers::Fd stranger(std::uint32_t ipv4, std::uint16_t udp_port) {
  drivers::Fd fd(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  const int on = 1;
  for (const int option : {SO_REUSEADDR, SO_REUSEPORT, SO_BROADCAST}) {
    setsockopt(fd.get(), SOL_SOCKET, option, &on, sizeof on);
  }
  setsockopt(fd.get(), IPPROTO_IP, IP_PKTINFO, &on, sizeof on);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(ipv4);
  address.sin_port = htons(udp_port);
  if (::bind(fd.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) fd.reset();
  return fd;
}

inline bool send_bytes(const drivers::Fd& from, std::uint32_t ipv4, std::uint16_t udp_port,
                       std::span<const std::uint8_t> bytes) {
  drivers::DatagramWriter writer;
  writer.add(bytes, ipv4, udp_port);
  return writer.flush(from.get()).error_number == 0;
}

// The datagrams received, oldest first. `wait`: up to two seconds for the first, since datagrams between namespaces may
// be delayed.
inline std::vector<std::vector<std::uint8_t>> received(const drivers::Fd& fd, bool wait = false) {
  pollfd waiting = {fd.get(), POLLIN, 0};
  std::vector<std::vector<std::uint8_t>> datagrams;
  if (::poll(&waiting, 1, wait ? 2'000 : 0) <= 0) return datagrams;
  drivers::DatagramReader reader;
  while (true) {
    const int count = reader.read(fd.get());
    if (count <= 0) return datagrams;
    for (int i = 0; i < count; ++i) {
      const auto bytes = reader[static_cast<std::size_t>(i)].bytes;
      datagrams.emplace_back(bytes.begin(), bytes.end());
    }
  }
}

inline std::vector<WireUniverse> universes_from(int first, int count, int show_first) {
  std::vector<WireUniverse> universes;
  for (int i = 0; i < count; ++i) universes.push_back({first + i, show_first + i});
  return universes;
}

// Levels that differ from universe to universe, slot to slot and round to round.
inline std::vector<std::uint8_t> test_levels(int universe, int round, int count = kSlotCountMax) {
  std::vector<std::uint8_t> levels(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    levels[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(universe * 31 + round * 7 + i * 3 + i / 256);
  }
  return levels;
}

}  // namespace footlight::testing
