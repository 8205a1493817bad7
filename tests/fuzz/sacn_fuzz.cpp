// Arbitrary datagrams on port 5568: each input as one datagram, and as a series of datagrams to one receiver.
//
// Accepted packets are within the ranges of sacn_packet.h, and a data packet that is parsed, encoded and parsed again
// is unchanged.
#include <algorithm>
#include <array>
#include <numeric>
#include <vector>

#include "drivers/net/sacn_discovery.h"
#include "drivers/net/sacn_packet.h"
#include "drivers/net/sacn_receiver.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace footlight;
using namespace footlight::drivers;

using footlight::testing::require;

void check(const SacnData& data) {
  require(is_universe(data.universe));
  require(data.sync_universe == 0 || is_universe(data.sync_universe));
  require(data.priority <= kPriorityMax);
  require(data.slots.size() <= kSlotCountMax);
  std::array<std::uint8_t, kSacnDataBytesMax> packet;
  const std::size_t size = build_sacn_data(data, packet);
  const auto again = parse_sacn_packet(std::span(packet).first(size));
  require(again.has_value() && std::holds_alternative<SacnData>(*again));
  const auto& read = std::get<SacnData>(*again);
  require(read.cid == data.cid && read.universe == data.universe && read.sequence == data.sequence);
  require(read.priority == data.priority && read.sync_universe == data.sync_universe);
  require(read.preview == data.preview && read.terminated == data.terminated && read.force_sync == data.force_sync);
  require(read.start_code == data.start_code);
  require(std::equal(read.slots.begin(), read.slots.end(), data.slots.begin(), data.slots.end()));
}

void check(const SacnSync& sync) { require(is_universe(sync.sync_universe)); }

void check(const SacnDiscovery& discovery) {
  require(discovery.page <= discovery.last_page);
  for (std::size_t i = 0; i < discovery.universe_count(); ++i) require(is_universe(discovery.universe(i)));
}

// A receiver of nine universes, and a list of senders, that take the packets one after the other.
//
// The input is divided into packets: two octets of length (low one first, modulo 2048), one of elapsed time in units of
// 16 ms, and the packet.
void receive(std::span<const std::uint8_t> input) {
  SacnReceiver rules({{{1, 1}, {2, 2}, {3, 3}, {4, 4}, {5, 5}, {6, 6}, {7, 7}, {8, 8}, {300, 9}}, false, nullptr});
  SacnDirectory directory;
  class Checker final : public FrameReceiver {
   public:
    void receive(const FrameView& frame) override {
      require(frame.universe >= 1 && frame.universe <= 9);
      require(frame.priority <= kPriorityMax);
      require(frame.sender != 0);
      require(frame.slots.size() <= kSlotCountMax);
      require(frame.start_code == kStartCodeLevels || frame.start_code == kStartCodePriorities);
      require(!frame.terminated || frame.slots.empty());
      sum_ += std::accumulate(frame.slots.begin(), frame.slots.end(), 0u);  // every slot can be read
    }

   private:
    unsigned sum_ = 0;
  } checker;
  TimeNs now_ns = 1'000 * kNsPerS;
  while (input.size() >= 3) {
    const std::size_t declared = static_cast<std::size_t>(input[0] | input[1] << 8) % 2048;
    const std::size_t size = std::min(declared, input.size() - 3);
    now_ns += input[2] * 16 * kNsPerMs;
    const auto datagram = input.subspan(3, size);
    rules.take(datagram, 0x0A000007, now_ns, checker);
    if (const auto change = rules.take_change()) require(is_universe(change->joined));
    const auto packet = parse_sacn_packet(datagram);
    if (packet && std::holds_alternative<SacnDiscovery>(*packet)) {
      directory.take(std::get<SacnDiscovery>(*packet), 0x0A000007, now_ns);
    }
    directory.expire(now_ns);
    for (const auto& sender : directory.list()) require(sender.pages <= sender.pages_wanted);
    input = input.subspan(3 + size);
  }
  const auto counters = rules.details().synchroniser;
  require(counters.replaced <= counters.held);
}

}  // namespace

void footlight::testing::add_seeds(Seeds& seeds) {
  std::array<std::uint8_t, kSlotCountMax> slots;
  for (std::size_t i = 0; i < slots.size(); ++i) slots[i] = static_cast<std::uint8_t>(i);
  std::array<std::uint8_t, kSacnDataBytesMax> packet;
  SacnData data;
  data.cid = {1, 2, 3};
  data.source_name = "Footlight";
  data.universe = 300;
  data.sync_universe = 7;
  data.sequence = 9;
  data.force_sync = true;
  for (const std::size_t count : {std::size_t{0}, std::size_t{24}, slots.size()}) {
    data.slots = std::span(slots).first(count);
    data.start_code = count == 24 ? 0xDD : 0;
    const std::size_t size = build_sacn_data(data, packet);
    seeds.add("data-" + std::to_string(count), std::span(packet).first(size));
  }
  std::array<std::uint8_t, kSacnSyncBytes> sync;
  build_sacn_sync({data.cid, 5, 7}, sync);
  seeds.add("sync", sync);
  std::array<std::uint8_t, kSacnDiscoveryBytesMax> list;
  const std::array<int, 3> universes = {1, 2, 300};
  const std::size_t list_size = build_sacn_discovery(data.cid, "Footlight", 0, 1, universes, list);
  seeds.add("discovery", std::span(list).first(list_size));

  // A series for receive(): synchronised frames of two universes, priorities, an end, a list.
  std::vector<std::uint8_t> row;
  const auto append = [&row](std::span<const std::uint8_t> bytes) {
    row.insert(row.end(), {static_cast<std::uint8_t>(bytes.size()), static_cast<std::uint8_t>(bytes.size() >> 8), 1});
    row.insert(row.end(), bytes.begin(), bytes.end());
  };
  for (std::uint8_t round = 0; round < 3; ++round) {
    for (const int universe : {1, 300}) {
      data.universe = universe;
      data.sequence = round;
      data.start_code = kStartCodeLevels;
      data.slots = std::span(slots).first(8);
      append(std::span(packet).first(build_sacn_data(data, packet)));
    }
    data.start_code = kStartCodePriorities;
    append(std::span(packet).first(build_sacn_data(data, packet)));
    build_sacn_sync({data.cid, round, 7}, sync);
    append(sync);
  }
  data.start_code = kStartCodeLevels;
  data.terminated = true;
  data.sequence = 3;
  append(std::span(packet).first(build_sacn_data(data, packet)));
  append(std::span(list).first(list_size));
  seeds.add("row", row);
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto packet = parse_sacn_packet({data, size});
  if (packet) std::visit([](const auto& one) { check(one); }, *packet);
  receive({data, size});
  return 0;
}
