// The rules of a receiver, without a socket: packets in, frames out, time passed in.
#include <doctest/doctest.h>

#include <array>
#include <random>

#include "drivers/net/sacn_discovery.h"
#include "drivers/net/sacn_receiver.h"
#include "tests/drivers/net/port_helpers.h"

namespace footlight::drivers {
namespace {

using testing::KeepingReceiver;
using testing::test_levels;
using testing::universes_from;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;
constexpr std::uint32_t kDeskIpv4 = 0x0A000007;  // 10.0.0.7

struct Bench {
  explicit Bench(int universe_count = 9) : rules({universes_from(1, universe_count, 1), false, nullptr}) {}

  void take(const SacnData& data) {
    std::array<std::uint8_t, kSacnDataBytesMax> packet;
    const std::size_t size = build_sacn_data(data, packet);
    REQUIRE(rules.take(std::span(packet).first(size), kDeskIpv4, at_ns, kept));
    changes += rules.take_change() ? 1 : 0;
  }
  void sync(int address, std::uint8_t sequence, std::uint8_t cid_octet = 1) {
    SacnSync packet;
    packet.cid.fill(cid_octet);
    packet.sequence = sequence;
    packet.sync_universe = address;
    std::array<std::uint8_t, kSacnSyncBytes> bytes;
    build_sacn_sync(packet, bytes);
    REQUIRE(rules.take(bytes, kDeskIpv4, at_ns, kept));
  }
  [[nodiscard]] std::size_t count() const { return kept.frames.size(); }
  [[nodiscard]] const testing::KeptFrame& last() const { return kept.frames.back(); }

  SacnReceiver rules;
  KeepingReceiver kept;
  TimeNs at_ns = kStartNs;
  int changes = 0;
};

// The packets of one sender, numbered in the order of their creation.
struct Desk {
  explicit Desk(std::uint8_t cid_octet = 1, int sync_universe = 0) {
    data.cid.fill(cid_octet);
    data.source_name = "FOH desk";
    data.sync_universe = sync_universe;
  }
  const SacnData& levels(int universe, std::uint8_t level) {
    data.universe = universe;
    data.sequence = sequence++;
    slots.fill(level);
    data.slots = slots;
    return data;
  }
  SacnData data;
  std::array<std::uint8_t, 4> slots = {};
  std::uint8_t sequence = 0;
};

}  // namespace

TEST_CASE("priorities per address are delivered with their start code, and are numbered separately from the levels") {
  Bench bench;
  Desk desk;
  desk.sequence = 200;
  bench.take(desk.levels(3, 7));
  SacnData priorities = desk.levels(3, 120);
  priorities.start_code = kStartCodePriorities;
  priorities.sequence = 190;  // 10 behind the levels: late if they were counted together
  bench.take(priorities);
  REQUIRE(bench.count() == 2);
  CHECK(bench.kept.frames[0].view.start_code == kStartCodeLevels);
  CHECK(bench.last().view.start_code == kStartCodePriorities);
  CHECK(bench.last().view.universe == 3);
  CHECK(bench.last().view.sender == bench.kept.frames[0].view.sender);
  CHECK(bench.last().slots == std::vector<std::uint8_t>(4, 120));
  bench.take(priorities);  // duplicate
  CHECK(bench.count() == 2);
  CHECK(bench.rules.details().late == 1);
  // A sender with one counter for both works as well.
  bench.take(desk.levels(3, 8));
  priorities.sequence = desk.sequence++;
  bench.take(priorities);
  CHECK(bench.count() == 4);
}

TEST_CASE("skipped numbers of a desk are lost, swapped ones are late, also across the wrap") {
  for (const int first : {0, 100, 250, 253, 255}) {
    CAPTURE(first);
    Bench bench;
    Desk desk;
    SenderId sender = 0;
    const auto number = [&](int offset) {
      desk.sequence = static_cast<std::uint8_t>(first + offset);
      bench.take(desk.levels(2, static_cast<std::uint8_t>(offset)));
      sender = bench.last().view.sender;
      return bench.rules.losses(1, sender);
    };
    (void)number(0);
    CHECK(number(1).lost == 0);
    CHECK(number(4).lost == 2);  // 2 and 3 are missing
    CHECK(number(6).lost == 3);  // and 5
    SenderLosses losses = number(5);
    CHECK(losses.lost == 2);  // it arrived late
    CHECK(losses.late == 1);
    CHECK(number(5).late == 1);  // duplicate
    CHECK(number(6).late == 1);  // duplicate
    CHECK(number(2).lost == 1);
    CHECK(number(7).lost == 1);
    losses = number(7 + 127);
    CHECK(losses.lost == 127);
    CHECK(losses.late == 2);
    CHECK(bench.rules.losses(0, sender).lost == 0);  // another universe
    CHECK(bench.rules.losses(1, sender + 1).lost == 0);
    CHECK(bench.count() == 6);  // 0, 1, 4, 6, 7 and the last: no late ones
  }
}

TEST_CASE("a thousand numbers in a row, a silence and a restart lose nothing") {
  Bench bench;
  Desk desk;
  for (int i = 0; i < 1'000; ++i) bench.take(desk.levels(1, 1));
  const SenderId sender = bench.last().view.sender;
  CHECK(bench.rules.losses(0, sender).lost == 0);
  desk.sequence = static_cast<std::uint8_t>(desk.sequence - 60);  // restarted
  bench.take(desk.levels(1, 1));
  bench.at_ns += kSenderTimeoutNs;
  desk.sequence = static_cast<std::uint8_t>(desk.sequence + 50);
  bench.take(desk.levels(1, 1));
  CHECK(bench.rules.losses(0, sender).lost == 0);
  CHECK(bench.rules.losses(0, sender).late == 0);
  desk.sequence += 2;
  bench.take(desk.levels(1, 1));
  CHECK(bench.rules.losses(0, sender).lost == 2);
}

TEST_CASE("priorities cause no loss, whether they share the numbers of the levels or have their own") {
  for (const bool shared : {true, false}) {
    CAPTURE(shared);
    Bench bench;
    Desk desk;
    std::uint8_t own = 77;
    for (int i = 0; i < 600; ++i) {
      if (i % 40 == 0) {
        SacnData priorities = desk.levels(1, 120);
        if (!shared) --desk.sequence;
        priorities.start_code = kStartCodePriorities;
        if (!shared) priorities.sequence = own++;
        bench.take(priorities);
      }
      if (i == 300) ++desk.sequence;  // one of the levels is lost
      bench.take(desk.levels(1, 1));
    }
    CHECK(bench.rules.losses(0, bench.last().view.sender).lost == 1);
    CHECK(bench.rules.losses(0, bench.last().view.sender).late == 0);
  }
}

TEST_CASE("a sender has its newest name and address, without control characters") {
  Bench bench;
  Desk desk;
  bench.take(desk.levels(1, 1));
  const SenderId sender = bench.last().view.sender;
  CHECK(bench.rules.sender_text(sender) == "FOH desk (10.0.0.7)");
  CHECK(bench.rules.sender_text(sender + 1).empty());
  desk.data.source_name = "Ren\xC3\xA9\x1B[2J\xC2\x9B!";
  bench.take(desk.levels(1, 1));
  CHECK(bench.rules.sender_text(sender) == "Ren\xC3\xA9?[2J?! (10.0.0.7)");
  desk.data.source_name = "";
  bench.take(desk.levels(1, 1));
  CHECK(bench.rules.sender_text(sender) == "10.0.0.7");
}

TEST_CASE("names of 255 senders are kept beside a real one, however many are forged") {
  SenderNames names;
  for (SenderId id = 1; id <= 10'000; ++id) {
    names.note(1, "live", kDeskIpv4, kStartNs + static_cast<TimeNs>(id));
    names.note(id + 1, "made up", kDeskIpv4, kStartNs + static_cast<TimeNs>(id));
  }
  CHECK(names.text_of(1) == "live (10.0.0.7)");
  int kept = 0;
  for (SenderId id = 2; id <= 10'001; ++id) kept += names.text_of(id).empty() ? 0 : 1;
  CHECK(kept == 255);
}

TEST_CASE("data with a synchronisation address is used at once until the first synchronisation packet, then waits") {
  Bench bench;
  Desk desk(1, 500);
  bench.take(desk.levels(1, 1));
  bench.take(desk.levels(2, 1));
  CHECK(bench.count() == 2);
  CHECK(bench.changes == 1);  // one group to join
  bench.sync(500, 0);
  CHECK(bench.count() == 2);
  bench.take(desk.levels(1, 2));
  bench.take(desk.levels(2, 2));
  CHECK(bench.count() == 2);
  bench.sync(501, 0);  // another address
  CHECK(bench.count() == 2);
  bench.at_ns += 5 * kNsPerMs;
  bench.sync(500, 1);
  REQUIRE(bench.count() == 4);
  for (const std::size_t i : {2u, 3u}) {
    CHECK(bench.kept.frames[i].view.universe == static_cast<int>(i) - 1);
    CHECK(bench.kept.frames[i].slots == std::vector<std::uint8_t>(4, 2));
    CHECK(bench.kept.frames[i].view.stamp_ns == bench.at_ns);
  }
  bench.sync(500, 2);  // no frames wait
  CHECK(bench.count() == 4);
  CHECK(bench.rules.details().synchroniser.held == 2);
  CHECK(bench.rules.details().synchroniser.replaced == 0);
  CHECK(bench.rules.details().synchroniser.foreign == 1);
}

TEST_CASE("of several waiting frames the newest is used, and replaced ones are counted") {
  Bench bench;
  Desk desk(1, 500);
  bench.take(desk.levels(1, 1));
  bench.sync(500, 0);
  for (const int level : {2, 3, 4}) bench.take(desk.levels(1, static_cast<std::uint8_t>(level)));
  bench.sync(500, 1);
  REQUIRE(bench.count() == 2);
  CHECK(bench.last().slots == std::vector<std::uint8_t>(4, 4));
  CHECK(bench.last().view.sequence == 3);
  CHECK(bench.rules.details().synchroniser.replaced == 2);
}

TEST_CASE("a synchronisation packet out of sequence releases nothing") {
  Bench bench;
  Desk desk(1, 500);
  bench.take(desk.levels(1, 1));
  bench.sync(500, 10);
  bench.take(desk.levels(1, 2));
  bench.sync(500, 10);
  bench.sync(500, 5);
  CHECK(bench.count() == 1);
  CHECK(bench.rules.details().synchroniser.late == 2);
  bench.sync(500, 1, 7);  // another sender synchronises the same address, with its own numbers
  CHECK(bench.count() == 2);
}

TEST_CASE("data without an address is used at once and drops waiting frames of its sender and universe only") {
  Bench bench;
  Desk desk(1, 500);
  Desk other(2, 500);
  bench.take(desk.levels(1, 1));
  bench.sync(500, 0);
  bench.take(desk.levels(1, 2));
  bench.take(desk.levels(2, 2));
  bench.take(other.levels(1, 3));
  desk.data.sync_universe = 0;
  bench.take(desk.levels(1, 9));
  REQUIRE(bench.count() == 2);
  CHECK(bench.last().slots == std::vector<std::uint8_t>(4, 9));
  bench.sync(500, 1);
  REQUIRE(bench.count() == 4);
  CHECK(bench.kept.frames[2].view.universe + bench.kept.frames[3].view.universe == 3);
  CHECK(bench.last().view.sender != bench.kept.frames[2].view.sender);
}

TEST_CASE("a sender ends at once, and its waiting frames are never used") {
  Bench bench;
  Desk desk(1, 500);
  bench.take(desk.levels(1, 1));
  bench.sync(500, 0);
  bench.take(desk.levels(1, 2));
  SacnData last = desk.levels(1, 3);
  last.terminated = true;
  bench.take(last);
  REQUIRE(bench.count() == 2);
  CHECK(bench.last().view.terminated);
  CHECK(bench.last().slots.empty());
  bench.sync(500, 1);
  CHECK(bench.count() == 2);
}

TEST_CASE("after 2.5 s without synchronisation packets data is used at once if its flag allows, else it stays frozen") {
  for (const bool force : {true, false}) {
    CAPTURE(force);
    Bench bench;
    Desk desk(1, 500);
    desk.data.force_sync = force;
    bench.take(desk.levels(1, 1));
    bench.sync(500, 0);
    for (int i = 0; i < 200; ++i) {  // 4.4 s at 44 Hz
      bench.at_ns += 22 * kNsPerMs;
      bench.take(desk.levels(1, static_cast<std::uint8_t>(i)));
      const bool lost = bench.at_ns - kStartNs >= 2'500 * kNsPerMs;
      REQUIRE(bench.count() == (force && lost ? static_cast<std::size_t>(i) - 112 + 1 : 1));
    }
    bench.take(desk.levels(1, 250));
    bench.sync(500, 1);
    CHECK(bench.last().slots == std::vector<std::uint8_t>(4, 250));
    // Synchronised again.
    const std::size_t before = bench.count();
    bench.take(desk.levels(1, 251));
    CHECK(bench.count() == before);
  }
}

TEST_CASE("a desk that returns after 2.5 s of silence is used at once, synchronised or not") {
  Bench bench;
  Desk desk(1, 500);  // would freeze
  bench.take(desk.levels(1, 1));
  bench.sync(500, 0);
  bench.take(desk.levels(1, 2));
  bench.at_ns += 2'500 * kNsPerMs;
  bench.take(desk.levels(1, 3));
  REQUIRE(bench.count() == 2);
  CHECK(bench.last().slots == std::vector<std::uint8_t>(4, 3));
  bench.sync(500, 1);
  CHECK(bench.count() == 2);  // the frame from before the silence is gone
}

TEST_CASE("beyond 32 addresses and 4 senders of a universe data is used at once and counted") {
  Bench bench;
  Desk desk;
  for (int address = 1; address <= 33; ++address) {
    desk.data.sync_universe = address;
    bench.take(desk.levels(1, 0));
    bench.sync(address, 0);
  }
  CHECK(bench.changes == 32);
  CHECK(bench.count() == 33);
  CHECK(bench.rules.details().synchroniser.unfollowed == 1);
  // An idle one is replaced.
  bench.at_ns += 2'500 * kNsPerMs;
  bench.take(desk.levels(1, 0));
  bench.sync(33, 1);
  const std::size_t before = bench.count();
  std::vector<Desk> desks;
  for (std::uint8_t cid = 10; cid < 15; ++cid) desks.emplace_back(cid, 33);
  for (Desk& one : desks) bench.take(one.levels(2, 1));
  CHECK(bench.count() == before + 1);
  CHECK(bench.rules.details().synchroniser.unfollowed == 2);
  bench.sync(33, 2);
  CHECK(bench.count() == before + 5);
}

TEST_CASE("priorities per address do not wait for synchronisation") {
  Bench bench;
  Desk desk(1, 500);
  bench.take(desk.levels(1, 1));
  bench.sync(500, 0);
  desk.data.start_code = kStartCodePriorities;
  bench.take(desk.levels(1, 150));
  REQUIRE(bench.count() == 2);
  CHECK(bench.last().view.start_code == kStartCodePriorities);
}

TEST_CASE("the list of senders has every page in order, removes senders after 20 s and holds 128 senders") {
  SacnDirectory directory;
  std::array<std::uint8_t, kSacnDiscoveryBytesMax> bytes;
  const auto announce = [&](std::uint8_t cid_octet, int page, int last_page, std::vector<int> universes,
                            TimeNs now_ns) {
    Cid cid;
    cid.fill(cid_octet);
    const std::size_t size = build_sacn_discovery(cid, "FOH desk", page, last_page, universes, bytes);
    const auto packet = parse_sacn_packet(std::span(bytes).first(size));
    REQUIRE(packet.has_value());
    directory.take(std::get<SacnDiscovery>(*packet), kDeskIpv4, now_ns);
  };
  announce(1, 1, 1, {700, 800}, kStartNs);
  REQUIRE(directory.list().size() == 1);
  CHECK(directory.list()[0].pages == 1);
  CHECK(directory.list()[0].pages_wanted == 2);
  announce(1, 0, 1, {1, 9, 3}, kStartNs);  // a sender that does not sort
  CHECK(directory.list()[0].universes == std::vector<int>{1, 3, 9, 700, 800});
  CHECK(directory.list()[0].pages == 2);
  CHECK(directory.list()[0].name == "FOH desk");
  CHECK(directory.list()[0].ipv4 == kDeskIpv4);
  announce(1, 0, 0, {4}, kStartNs + kNsPerS);  // it sends fewer universes from now on
  CHECK(directory.list()[0].universes == std::vector<int>{4});
  announce(2, 0, 0, {}, kStartNs + 2 * kNsPerS);
  directory.expire(kStartNs + 21 * kNsPerS - 1);
  CHECK(directory.list().size() == 2);
  directory.expire(kStartNs + 21 * kNsPerS);
  REQUIRE(directory.list().size() == 1);
  CHECK(directory.list()[0].universes.empty());
  for (int i = 0; i < 200; ++i) announce(static_cast<std::uint8_t>(i), 0, 255, {1}, kStartNs + i);
  CHECK(directory.list().size() == 128);
}

TEST_CASE("after 20000 damaged packets of every kind the receiver still works and no frame is out of range") {
  Bench bench;
  SacnDirectory directory;
  std::mt19937 random(7);
  const auto levels = test_levels(1, 1);
  std::vector<std::vector<std::uint8_t>> good;
  std::array<std::uint8_t, kSacnDiscoveryBytesMax> bytes;
  for (const int address : {0, 1, 500}) {
    for (const std::uint8_t start_code : {kStartCodeLevels, kStartCodePriorities}) {
      SacnData data;
      data.universe = 1;
      data.sync_universe = address;
      data.start_code = start_code;
      data.slots = levels;
      const std::size_t size = build_sacn_data(data, bytes);
      good.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    }
  }
  for (const int address : {1, 500}) {
    std::array<std::uint8_t, kSacnSyncBytes> sync;
    build_sacn_sync({{}, 0, address}, sync);
    good.emplace_back(sync.begin(), sync.end());
  }
  const std::vector<int> universes = {1, 2, 3, 400};
  const std::size_t size = build_sacn_discovery({}, "desk", 0, 1, universes, bytes);
  good.emplace_back(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));

  int sound = 0;
  for (int i = 0; i < 20'000; ++i) {
    auto packet = good[random() % good.size()];
    const std::size_t header = std::min<std::size_t>(packet.size(), 126);
    // Numbers that affect the state machine change in most of them, other bytes in some.
    if (packet.size() > kSacnSyncBytes) {
      packet[22] = static_cast<std::uint8_t>(random() % 8);
      packet[111] = static_cast<std::uint8_t>(random());
      if (random() % 8 == 0) packet[112] = static_cast<std::uint8_t>(random());
      if (random() % 4 == 0) packet[110] = static_cast<std::uint8_t>(random());
      if (random() % 4 == 0) packet[114] = static_cast<std::uint8_t>(random() % 12);
    } else {
      packet[44] = static_cast<std::uint8_t>(random());
      if (random() % 4 == 0) packet[46] = static_cast<std::uint8_t>(random());
    }
    if (random() % 2 == 0) packet[random() % header] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) packet.resize(random() % packet.size());
    bench.at_ns += static_cast<DurationNs>(random() % 64) * kNsPerMs;
    sound += bench.rules.take(packet, kDeskIpv4, bench.at_ns, bench.kept) ? 1 : 0;
    if (const auto change = bench.rules.take_change()) {
      REQUIRE((change->left == 0 || is_universe(change->left)));
      REQUIRE(is_universe(change->joined));
    }
    if (const auto parsed = parse_sacn_packet(packet); parsed && std::holds_alternative<SacnDiscovery>(*parsed)) {
      directory.take(std::get<SacnDiscovery>(*parsed), kDeskIpv4, bench.at_ns);
    }
    for (const auto& frame : bench.kept.frames) {
      REQUIRE((frame.view.universe >= 1 && frame.view.universe <= 9));
      REQUIRE(frame.view.priority <= kPriorityMax);
      REQUIRE(frame.slots.size() <= kSlotCountMax);
    }
    bench.kept.frames.clear();
  }
  CHECK(sound > 5'000);
  const auto details = bench.rules.details();
  CHECK(details.synchroniser.held > 100);
  CHECK(details.synchroniser.replaced > 10);
  CHECK(directory.list().size() <= 128);
}

}  // namespace footlight::drivers
