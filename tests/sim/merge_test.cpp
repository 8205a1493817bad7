#include "sim/merge.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <array>
#include <map>
#include <vector>

using namespace footlight;

namespace {

constexpr TimeNs kStart = 1'000 * kNsPerS;
constexpr DurationNs kTimeout = 2'500 * kNsPerMs;

// One universe, told in sender, level, priority.
class Stage {
 public:
  explicit Stage(MergeMode mode = MergeMode::kHtp) : merge_(1, {.timeout_ns = kTimeout, .mode = mode}) {}

  Merge::Received send(SenderId sender, std::uint8_t level, std::uint8_t priority = 100, std::size_t slot_count = 512) {
    const std::vector<std::uint8_t> slots(slot_count, level);
    return send_slots(sender, slots, priority);
  }
  Merge::Received send_slots(SenderId sender, std::span<const std::uint8_t> slots, std::uint8_t priority = 100) {
    FrameView frame;
    frame.sender = sender;
    frame.priority = priority;
    frame.stamp_ns = now_ns;
    frame.sequence = ++sequence_;
    frame.slots = slots;
    return receive(frame);
  }
  // As the pump does it: what is in the way is resolved first.
  Merge::Received receive(const FrameView& frame, SourceId source = 0) {
    const Merge::Received received = merge_.receive(0, frame, now_ns, source);
    if (received != Merge::Received::kResolveFirst) return received;
    settle();
    return merge_.receive(0, frame, now_ns, source);
  }
  void terminate(SenderId sender) {
    FrameView frame;
    frame.sender = sender;
    frame.terminated = true;
    receive(frame);
  }
  // What the pump does in a tick. True: there is a new look.
  bool settle() {
    merge_.expire(now_ns);
    bool made = false;
    for (const int index : merge_.changed()) made = merge_.resolve(index) || made;
    merge_.clear_changed();
    return made;
  }
  std::uint8_t level(Address address = 1) {
    settle();
    return merge_.look(0).slots[static_cast<std::size_t>(slot_of_address(address))];
  }
  SenderId sender() {
    settle();
    return merge_.look(0).sender;
  }
  Merge& merge() { return merge_; }
  const MergeCounters& counters() { return merge_.counters(0); }

  TimeNs now_ns = kStart;

 private:
  Merge merge_;
  std::uint32_t sequence_ = 0;
};

}  // namespace

TEST_CASE("the highest priority wins whatever the levels and the order") {
  Stage stage;
  stage.send(1, 255, 100);
  stage.send(2, 10, 150);
  CHECK(stage.level() == 10);
  stage.send(1, 200, 100);
  CHECK(stage.level() == 10);
  CHECK(stage.sender() == 2);
  stage.send(3, 5, 200);
  stage.send(4, 90, 0);
  CHECK(stage.level() == 5);
  CHECK(stage.merge().sender_count(0) == 4);
  CHECK(stage.merge().winner_count(0) == 1);
}

TEST_CASE("equal priorities merge to the highest level of each slot, and down again") {
  Stage stage;
  std::array<std::uint8_t, 3> a = {10, 200, 30}, b = {100, 20, 30};
  stage.send_slots(1, a);
  stage.send_slots(2, b);
  CHECK(stage.level(1) == 100);
  CHECK(stage.level(2) == 200);
  CHECK(stage.level(3) == 30);
  a[1] = 0;
  stage.send_slots(1, a);
  CHECK(stage.level(2) == 20);
  CHECK(stage.merge().winner_count(0) == 2);
}

TEST_CASE("under LTP the sender that changed last wins, and repeats of unchanged levels change nothing") {
  Stage stage(MergeMode::kLtp);
  stage.send(1, 255);
  stage.send(2, 10);
  CHECK(stage.level() == 10);
  for (int i = 0; i < 5; ++i) {
    stage.send(1, 255);
    CHECK_FALSE(stage.settle());
    CHECK(stage.level() == 10);
    stage.send(2, 10);
    CHECK(stage.settle());  // a repeat of the winner is passed on
    CHECK(stage.level() == 10);
  }
  stage.send(1, 254);
  CHECK(stage.level() == 254);
  CHECK(stage.sender() == 1);
  stage.terminate(1);
  CHECK(stage.level() == 10);
  stage.send(3, 1, 101);
  CHECK(stage.level() == 1);  // priority comes before mode
}

TEST_CASE("LTP may be set for a single universe") {
  Merge merge(2);
  merge.set_mode(1, MergeMode::kLtp);
  const std::array<std::uint8_t, 1> high = {200}, low = {100};
  for (int index = 0; index < 2; ++index) {
    FrameView frame;
    frame.sender = 1;
    frame.slots = high;
    merge.receive(index, frame, kStart);
    frame.sender = 2;
    frame.slots = low;
    merge.receive(index, frame, kStart);
    merge.resolve(index);
  }
  CHECK(merge.look(0).slots[0] == 200);
  CHECK(merge.look(1).slots[0] == 100);
}

TEST_CASE(
    "a silent winner holds its look for 2.5 s to the nanosecond, then the next priority shows its newest levels") {
  Stage stage;
  stage.send(1, 200, 150);
  stage.send(2, 50, 100);
  CHECK(stage.level() == 200);
  const TimeNs last_word_ns = stage.now_ns;
  while (stage.now_ns + 25 * kNsPerMs < last_word_ns + kTimeout) {
    stage.now_ns += 25 * kNsPerMs;
    stage.send(2, static_cast<std::uint8_t>(60 + stage.now_ns % 7), 100);
    CHECK(stage.level() == 200);
  }
  stage.send(2, 77, 100);
  stage.now_ns = last_word_ns + kTimeout - 1;
  CHECK(stage.level() == 200);
  CHECK(stage.merge().next_expiry_ns() <= last_word_ns + kTimeout);
  stage.now_ns = last_word_ns + kTimeout;
  CHECK(stage.settle());
  CHECK(stage.level() == 77);
  CHECK(stage.sender() == 2);
  CHECK(stage.counters().senders_silent == 1);
}

TEST_CASE("a sender that says it stops is forgotten at once") {
  Stage stage;
  stage.send(1, 200, 150);
  stage.send(2, 50, 100);
  stage.settle();
  stage.terminate(1);
  CHECK(stage.level() == 50);
  CHECK(stage.counters().senders_ended == 1);
  stage.terminate(1);  // said three times on the wire
  stage.terminate(99);
  CHECK(stage.counters().senders_ended == 1);
}

TEST_CASE("the last look stays when the last sender vanishes, until somebody sends again") {
  for (const bool says_so : {true, false}) {
    Stage stage;
    stage.send(1, 123);
    stage.settle();
    if (says_so) stage.terminate(1);
    stage.now_ns += kTimeout;
    CHECK_FALSE(stage.settle());
    CHECK(stage.merge().sender_count(0) == 0);
    CHECK(stage.merge().next_expiry_ns() == kTimeNever);
    CHECK(stage.level() == 123);
    stage.send(2, 7, 1);
    CHECK(stage.level() == 7);
  }
}

TEST_CASE("a loser that vanishes makes no new look") {
  Stage stage;
  stage.send(1, 200, 150);
  stage.send(2, 50, 100);
  stage.settle();
  stage.send(2, 51, 100);
  CHECK_FALSE(stage.settle());
  stage.terminate(2);
  CHECK_FALSE(stage.settle());
}

TEST_CASE("priority 200 counts, 201 and 255 are ignored and counted") {
  Stage stage;
  stage.send(1, 10, 100);
  CHECK(stage.send(2, 20, 200) == Merge::Received::kStored);
  CHECK(stage.send(3, 30, 201) == Merge::Received::kRefusedPriority);
  CHECK(stage.send(3, 30, 255) == Merge::Received::kRefusedPriority);
  CHECK(stage.level() == 20);
  CHECK(stage.counters().refused_priority == 2);
  CHECK(stage.merge().sender_count(0) == 2);
}

TEST_CASE("a sender may change its priority, up and down") {
  Stage stage;
  stage.send(1, 10, 100);
  stage.send(2, 20, 90);
  CHECK(stage.level() == 10);
  stage.send(2, 20, 110);
  CHECK(stage.level() == 20);
  stage.send(2, 20, 80);
  CHECK(stage.level() == 10);
}

TEST_CASE("a ninth sender of equal priority is refused and counted, and gets in when another leaves") {
  Stage stage;
  for (SenderId sender = 1; sender <= 8; ++sender) CHECK(stage.send(sender, 10) == Merge::Received::kStored);
  CHECK(stage.send(9, 255) == Merge::Received::kRefusedFull);
  CHECK(stage.send(9, 255) == Merge::Received::kRefusedFull);
  CHECK(stage.counters().refused_full == 2);
  CHECK(stage.level() == 10);
  stage.terminate(4);
  CHECK(stage.send(9, 255) == Merge::Received::kStored);
  CHECK(stage.level() == 255);
}

TEST_CASE("a ninth sender of higher priority takes the place of the lowest one that was silent for longest") {
  Stage stage;
  for (SenderId sender = 1; sender <= 8; ++sender)
    stage.send(sender, static_cast<std::uint8_t>(sender), sender < 3 ? 50 : 100);
  stage.send(1, 1, 50);  // so 2 is the silent one
  CHECK(stage.send(9, 99, 60) == Merge::Received::kStored);
  CHECK(stage.counters().senders_displaced == 1);
  CHECK(stage.merge().sender_count(0) == 8);
  CHECK(stage.send(2, 2, 50) == Merge::Received::kRefusedFull);
  CHECK(stage.send(1, 1, 50) == Merge::Received::kStored);
  CHECK(stage.level() == 8);
}

TEST_CASE("slots that no winner sent keep the last look, also across a change of winner") {
  Stage stage;
  stage.send(1, 50, 100, 512);
  CHECK(stage.level(512) == 50);
  stage.send(2, 60, 110, 24);
  CHECK(stage.level(24) == 60);
  CHECK(stage.level(25) == 50);
  stage.send(2, 61, 110, 1);  // a shorter frame of the same sender leaves its own slots
  CHECK(stage.level(1) == 61);
  CHECK(stage.level(24) == 60);
  stage.send(2, 62, 110, 0);
  CHECK(stage.level(1) == 61);
}

TEST_CASE("a place given to a new sender shows nothing of the old one") {
  Stage stage;
  stage.send(1, 200);
  stage.send(2, 10, 100, 1);
  stage.settle();
  stage.terminate(1);
  stage.send(3, 20, 100, 1);
  CHECK(stage.level(1) == 20);
  stage.terminate(2);
  const std::array<std::uint8_t, 3> slots = {1, 2, 3};
  stage.send_slots(4, slots);
  CHECK(stage.level(1) == 20);
  CHECK(stage.level(3) == 3);
}

TEST_CASE("silence counts from when a frame was read, so a stopped machine loses no sender whose frames were waiting") {
  Stage stage;
  stage.send(1, 10, 150);
  stage.send(2, 20, 100);
  stage.settle();
  stage.now_ns += 60 * kNsPerS;
  FrameView frame;  // arrived while the machine was stopped
  frame.sender = 1;
  frame.priority = 150;
  frame.stamp_ns = stage.now_ns - 50 * kNsPerS;
  const std::array<std::uint8_t, 1> slots = {11};
  frame.slots = slots;
  stage.merge().receive(0, frame, stage.now_ns);
  CHECK(stage.level() == 11);
  CHECK(stage.merge().sender_count(0) == 1);
}

TEST_CASE("a second frame of a winner is not taken before the first is in a look, and nothing is counted for it") {
  Merge merge(1);
  FrameView frame;
  frame.sender = 1;
  const std::array<std::uint8_t, 1> first = {10}, second = {20};
  frame.slots = first;
  CHECK(merge.receive(0, frame, kStart) == Merge::Received::kStored);
  frame.slots = second;
  CHECK(merge.receive(0, frame, kStart) == Merge::Received::kResolveFirst);
  frame.terminated = true;
  CHECK(merge.receive(0, frame, kStart) == Merge::Received::kResolveFirst);
  CHECK(merge.counters(0).frames == 1);
  CHECK(merge.resolve(0));
  CHECK(merge.look(0).slots[0] == 10);
  frame.terminated = false;
  CHECK(merge.receive(0, frame, kStart) == Merge::Received::kStored);
  CHECK(merge.resolve(0));
  CHECK(merge.look(0).slots[0] == 20);
  CHECK(merge.counters(0).frames == 2);
  CHECK(merge.counters(0).frames_shown == 2);
}

TEST_CASE("each frame is counted as shown, outranked, ended or refused, and just once") {
  Stage stage;
  stage.send(1, 10, 100);
  stage.send(2, 20, 150);  // outranks the one before it, which nobody has seen yet
  stage.settle();
  CHECK(stage.counters().frames_shown == 1);
  CHECK(stage.counters().frames_outranked == 1);
  stage.send(1, 11, 100);
  CHECK(stage.counters().frames_outranked == 2);
  stage.send(3, 30, 150);
  stage.send(2, 21, 150);
  stage.settle();  // two frames, one look
  CHECK(stage.counters().frames_shown == 3);
  stage.send(4, 0, 201);
  stage.terminate(1);
  stage.terminate(99);
  const MergeCounters& told = stage.counters();
  CHECK(told.frames_ended == 2);
  CHECK(told.refused_priority == 1);
  CHECK(told.frames == 8);
  CHECK(told.frames == told.frames_shown + told.frames_outranked + told.frames_ended + told.refused_priority);
}

TEST_CASE("under LTP a frame that changes nothing, or is overtaken in the same wake-up, counts as outranked") {
  Stage stage(MergeMode::kLtp);
  stage.send(1, 10);
  stage.send(2, 20);
  stage.settle();
  CHECK(stage.counters().frames_shown == 1);
  CHECK(stage.counters().frames_outranked == 1);
  stage.send(1, 10);
  CHECK(stage.counters().frames_outranked == 2);
}

TEST_CASE("two sources that give out the same number for a sender are two senders") {
  Stage stage;
  FrameView frame;
  frame.sender = 7;
  const std::array<std::uint8_t, 2> low_high = {10, 200}, high_low = {100, 20};
  frame.slots = low_high;
  stage.receive(frame, 1);
  frame.slots = high_low;
  stage.receive(frame, 2);
  CHECK(stage.merge().sender_count(0) == 2);
  CHECK(stage.level(1) == 100);
  CHECK(stage.level(2) == 200);
  frame.terminated = true;
  stage.receive(frame, 2);
  CHECK(stage.level(1) == 10);
  stage.receive(frame, 3);  // a stranger cannot end somebody else
  CHECK(stage.merge().sender_count(0) == 1);
}

TEST_CASE("a source that is no more takes its senders along, and the others are left") {
  Stage stage;
  FrameView frame;
  const std::array<std::uint8_t, 1> first = {200}, second = {100};
  for (const SenderId sender : {1u, 2u}) {
    frame.sender = sender;
    frame.slots = first;
    stage.receive(frame, 1);
    frame.slots = second;
    stage.receive(frame, 2);
  }
  CHECK(stage.level() == 200);
  stage.merge().forget_source(1);
  CHECK(stage.level() == 100);
  CHECK(stage.merge().sender_count(0) == 2);
  stage.merge().forget_source(2);
  CHECK(stage.level() == 100);
  CHECK(stage.merge().sender_count(0) == 0);
}

TEST_CASE("a sender that says how long it may be silent is forgotten after that time and no other") {
  Stage stage;
  FrameView frame;
  const std::array<std::uint8_t, 1> slots = {10};
  frame.slots = slots;
  for (const SenderId sender : {1u, 2u, 3u}) {
    frame.sender = sender;
    frame.silence_max_ns = sender == 1 ? 10 * kNsPerS : sender == 2 ? kNsPerS : 0;
    stage.receive(frame);
  }
  stage.settle();
  const auto left_at = [&](DurationNs after_ns) {
    stage.now_ns = kStart + after_ns;
    stage.settle();
    return stage.merge().sender_count(0);
  };
  CHECK(left_at(kNsPerS - 1) == 3);
  CHECK(stage.merge().next_expiry_ns() <= kStart + kNsPerS);
  CHECK(left_at(kNsPerS) == 2);
  CHECK(left_at(kTimeout - 1) == 2);
  CHECK(left_at(kTimeout) == 1);
  CHECK(left_at(10 * kNsPerS - 1) == 1);
  CHECK(left_at(10 * kNsPerS) == 0);
}

TEST_CASE("senders are told with priority, time, rate and whether they win") {
  Stage stage;
  stage.send(1, 10, 150);
  for (int i = 0; i < 20; ++i) {
    stage.now_ns += 100 * kNsPerMs;
    stage.send(2, 20, 100);
  }
  stage.settle();
  stage.merge().count_rates(2.0);
  const MergeSender first = stage.merge().sender(0, 0), second = stage.merge().sender(0, 1);
  CHECK(first.id == 1);
  CHECK(first.wins);
  CHECK(first.heard_ns == kStart);
  CHECK(first.rate_hz == doctest::Approx(0.5));
  CHECK(second.id == 2);
  CHECK_FALSE(second.wins);
  CHECK(second.priority == 100);
  CHECK(second.rate_hz == doctest::Approx(10.0));
  stage.merge().count_rates(1.0);
  CHECK(stage.merge().sender(0, 1).rate_hz == 0.0);
}

TEST_CASE("a merge that adopts another one goes on with its senders, looks, counters and expiry") {
  Merge old(2);
  const std::array<std::uint8_t, 3> high = {200, 201, 202}, low = {100, 101, 102};
  FrameView frame;
  for (const SenderId sender : {1u, 2u}) {
    frame.sender = sender;
    frame.priority = sender == 1 ? 150 : 100;
    frame.slots = sender == 1 ? high : low;
    old.receive(1, frame, kStart);
  }
  CHECK(old.resolve(1));
  old.clear_changed();
  Merge next(3);
  const std::array<int, 3> from_index = {-1, -1, 1};
  next.adopt(old, from_index);
  CHECK(next.look(2).slots[2] == 202);
  CHECK(next.sender_count(2) == 2);
  CHECK(next.sender_count(0) == 0);
  CHECK(next.counters(2).frames == 2);
  CHECK(next.changed().empty());
  next.expire(kStart + kTimeout - 1);
  CHECK(next.sender_count(2) == 2);
  frame.terminated = true;
  frame.sender = 1;
  next.receive(2, frame, kStart + 1);
  CHECK(next.resolve(2));
  CHECK(next.look(2).slots[1] == 101);
  next.expire(kStart + kTimeout);
  CHECK(next.sender_count(2) == 0);
}

// The rules told a second time, slowly: a map of senders and a fold over all of them for every slot.
TEST_CASE("a long random history gives the look that the rules give when told slowly") {
  struct Told {
    std::uint8_t priority;
    TimeNs heard_ns;
    std::vector<std::uint8_t> slots;
  };
  constexpr int kSlots = 5;
  Stage stage;
  std::map<SenderId, Told> told;
  std::array<std::uint8_t, kSlots> expected{};
  std::uint64_t random = 42;
  const auto draw = [&](std::uint64_t below) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return (random >> 33) % below;
  };
  for (int step = 0; step < 50'000; ++step) {
    stage.now_ns += static_cast<TimeNs>(draw(800)) * kNsPerMs;
    const SenderId sender = 1 + draw(8);
    const auto priority = static_cast<std::uint8_t>(draw(8) == 0 ? 200 + draw(3) : 99 + draw(3));
    const std::uint64_t what = draw(10);
    if (what == 0) {
      stage.terminate(sender);
      told.erase(sender);
    } else if (what < 8) {
      std::vector<std::uint8_t> slots(draw(kSlots + 1));
      for (std::uint8_t& slot : slots) slot = static_cast<std::uint8_t>(draw(256));
      stage.send_slots(sender, slots, priority);
      if (priority <= kPriorityMax) {
        Told& entry = told[sender];
        entry.priority = priority;
        entry.heard_ns = stage.now_ns;
        if (entry.slots.size() < slots.size()) entry.slots.resize(slots.size());
        std::copy(slots.begin(), slots.end(), entry.slots.begin());
      }
    }
    std::erase_if(told, [&](const auto& entry) { return entry.second.heard_ns + kTimeout <= stage.now_ns; });

    int top = -1;
    for (const auto& [id, entry] : told) top = std::max(top, static_cast<int>(entry.priority));
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      int level = -1;
      for (const auto& [id, entry] : told)
        if (entry.priority == top && slot < entry.slots.size())
          level = std::max(level, static_cast<int>(entry.slots[slot]));
      if (level >= 0) expected[slot] = static_cast<std::uint8_t>(level);
    }
    stage.settle();
    const FrameView look = stage.merge().look(0);
    REQUIRE(std::equal(expected.begin(), expected.end(), look.slots.begin()));
    REQUIRE(stage.merge().sender_count(0) == static_cast<int>(told.size()));
  }
}
