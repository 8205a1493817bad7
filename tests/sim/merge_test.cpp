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

// One universe, in terms of sender, level and priority.
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
  // Like the pump: resolves first if a frame is in the way.
  Merge::Received receive(const FrameView& frame, SourceId source = 0) {
    const Merge::Received received = merge_.receive(0, frame, now_ns, source);
    if (received != Merge::Received::kResolveFirst) return received;
    settle();
    return merge_.receive(0, frame, now_ns, source);
  }
  // Per-address priorities: the same in the first `slot_count` slots.
  Merge::Received claim(SenderId sender, std::uint8_t priority, std::size_t slot_count = 512, SourceId source = 0) {
    return claim_slots(sender, std::vector<std::uint8_t>(slot_count, priority), source);
  }
  Merge::Received claim_slots(SenderId sender, std::span<const std::uint8_t> priorities, SourceId source = 0) {
    FrameView frame;
    frame.sender = sender;
    frame.start_code = kStartCodePriorities;
    frame.slots = priorities;
    return receive(frame, source);
  }
  void terminate(SenderId sender) {
    FrameView frame;
    frame.sender = sender;
    frame.terminated = true;
    receive(frame);
  }
  // The pump's part in a tick. True: there is a new snapshot.
  bool settle() {
    merge_.expire(now_ns);
    bool made = false;
    for (const int index : merge_.changed()) made = merge_.resolve(index) || made;
    merge_.clear_changed();
    return made;
  }
  std::uint8_t level(Address address = 1) {
    settle();
    return merge_.snapshot(0).slots[static_cast<std::size_t>(slot_of_address(address))];
  }
  SenderId sender() {
    settle();
    return merge_.snapshot(0).sender;
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
  CHECK(merge.snapshot(0).slots[0] == 200);
  CHECK(merge.snapshot(1).slots[0] == 100);
}

TEST_CASE(
    "a silent winner keeps its levels for 2.5 s to the nanosecond, then the next priority shows its newest levels") {
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

TEST_CASE("a terminated sender is removed at once") {
  Stage stage;
  stage.send(1, 200, 150);
  stage.send(2, 50, 100);
  stage.settle();
  stage.terminate(1);
  CHECK(stage.level() == 50);
  CHECK(stage.counters().senders_ended == 1);
  stage.terminate(1);  // three times on the wire
  stage.terminate(99);
  CHECK(stage.counters().senders_ended == 1);
}

TEST_CASE("the last snapshot stays when the last sender disappears, until a sender sends again") {
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

TEST_CASE("a loser that disappears makes no new snapshot") {
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

TEST_CASE("a ninth sender of higher priority replaces the lowest one that was silent for longest") {
  Stage stage;
  for (SenderId sender = 1; sender <= 8; ++sender)
    stage.send(sender, static_cast<std::uint8_t>(sender), sender < 3 ? 50 : 100);
  stage.send(1, 1, 50);  // so 2 has been silent for longest
  CHECK(stage.send(9, 99, 60) == Merge::Received::kStored);
  CHECK(stage.counters().senders_displaced == 1);
  CHECK(stage.merge().sender_count(0) == 8);
  CHECK(stage.send(2, 2, 50) == Merge::Received::kRefusedFull);
  CHECK(stage.send(1, 1, 50) == Merge::Received::kStored);
  CHECK(stage.level() == 8);
}

TEST_CASE("slots that no winner sent keep their levels, also across a change of winner") {
  Stage stage;
  stage.send(1, 50, 100, 512);
  CHECK(stage.level(512) == 50);
  stage.send(2, 60, 110, 24);
  CHECK(stage.level(24) == 60);
  CHECK(stage.level(25) == 50);
  stage.send(2, 61, 110, 1);  // a shorter frame of the same sender keeps its other slots
  CHECK(stage.level(1) == 61);
  CHECK(stage.level(24) == 60);
  stage.send(2, 62, 110, 0);
  CHECK(stage.level(1) == 61);
}

TEST_CASE("a reused place has no levels of the old sender") {
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

TEST_CASE("silence counts from the time a frame was read, so a stopped machine loses no sender with waiting frames") {
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

TEST_CASE("a second frame of a winner is not accepted or counted before the first is in a snapshot") {
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
  CHECK(merge.snapshot(0).slots[0] == 10);
  frame.terminated = false;
  CHECK(merge.receive(0, frame, kStart) == Merge::Received::kStored);
  CHECK(merge.resolve(0));
  CHECK(merge.snapshot(0).slots[0] == 20);
  CHECK(merge.counters(0).frames == 2);
  CHECK(merge.counters(0).frames_shown == 2);
}

TEST_CASE("each frame is counted as shown, outranked, ended or refused, and exactly once") {
  Stage stage;
  stage.send(1, 10, 100);
  stage.send(2, 20, 150);  // outranks the previous one, which is not in a snapshot yet
  stage.settle();
  CHECK(stage.counters().frames_shown == 1);
  CHECK(stage.counters().frames_outranked == 1);
  stage.send(1, 11, 100);
  CHECK(stage.counters().frames_outranked == 2);
  stage.send(3, 30, 150);
  stage.send(2, 21, 150);
  stage.settle();  // two frames, one snapshot
  CHECK(stage.counters().frames_shown == 3);
  stage.send(4, 0, 201);
  stage.terminate(1);
  stage.terminate(99);
  const MergeCounters& counters = stage.counters();
  CHECK(counters.frames_ended == 2);
  CHECK(counters.refused_priority == 1);
  CHECK(counters.frames == 8);
  CHECK(counters.frames ==
        counters.frames_shown + counters.frames_outranked + counters.frames_ended + counters.refused_priority);
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

TEST_CASE("equal sender ids of two sources are two senders") {
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
  stage.receive(frame, 3);  // another sender cannot end this one
  CHECK(stage.merge().sender_count(0) == 1);
}

TEST_CASE("removing a source removes its senders and no others") {
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

TEST_CASE("a sender with its own silence limit is removed after exactly that time") {
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

TEST_CASE("senders are reported with priority, time, rate and whether they win") {
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
  CHECK(first.received_ns == kStart);
  CHECK(first.rate_hz == doctest::Approx(0.5));
  CHECK(second.id == 2);
  CHECK_FALSE(second.wins);
  CHECK(second.priority == 100);
  CHECK(second.rate_hz == doctest::Approx(10.0));
  stage.merge().count_rates(1.0);
  CHECK(stage.merge().sender(0, 1).rate_hz == 0.0);
}

TEST_CASE("a merge that adopts another one continues with its senders, snapshots, counters and expiry") {
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
  CHECK(next.snapshot(2).slots[2] == 202);
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
  CHECK(next.snapshot(2).slots[1] == 101);
  next.expire(kStart + kTimeout);
  CHECK(next.sender_count(2) == 0);
}

// --- Per-address priority: ETC's rules (ETCLabs/sACN, docs/pages/per_address_priority.md) ---

TEST_CASE("0xDD frames are priorities and never levels") {
  Stage stage;
  stage.send(1, 50);
  CHECK(stage.level() == 50);
  stage.claim(1, 200);
  CHECK(stage.level() == 50);
  CHECK(stage.counters().frames_priorities == 1);
  CHECK(stage.counters().frames == 2);
}

TEST_CASE("the rules apply to one universe at a time") {
  Merge merge(2);
  const std::array<std::uint8_t, 1> low = {10}, high = {200}, leave = {0};
  FrameView frame;
  for (int index = 0; index < 2; ++index)
    for (const SenderId sender : {1u, 2u}) {
      frame.sender = sender;
      frame.slots = sender == 1 ? low : high;
      merge.receive(index, frame, kStart);
    }
  frame.sender = 2;
  frame.start_code = kStartCodePriorities;
  frame.slots = leave;
  merge.receive(1, frame, kStart);
  CHECK(merge.resolve(0));
  CHECK(merge.resolve(1));
  CHECK(merge.snapshot(0).slots[0] == 200);
  CHECK(merge.snapshot(1).slots[0] == 10);
}

TEST_CASE("the highest per-address priority wins slot by slot, whatever the levels and the packets' priorities") {
  Stage stage;
  stage.send(1, 10, 50);
  stage.send(2, 200, 150);
  const std::array<std::uint8_t, 3> first = {200, 100, 1}, second = {199, 100, 2};
  stage.claim_slots(1, first);
  stage.claim_slots(2, second);
  CHECK(stage.level(1) == 10);
  CHECK(stage.level(2) == 200);  // equal: the highest level
  CHECK(stage.level(3) == 200);
}

TEST_CASE("per-address priority 0 leaves the slot to others, even to a packet priority of 0") {
  Stage stage;
  stage.send(1, 200, 200);
  stage.send(2, 10, 0);
  const std::array<std::uint8_t, 2> only_first = {1, 0};
  stage.claim_slots(1, only_first);
  CHECK(stage.level(1) == 200);
  CHECK(stage.level(2) == 10);
}

TEST_CASE("a slot without a claim keeps its level") {
  Stage stage;
  stage.send(1, 200);
  CHECK(stage.level(2) == 200);
  stage.claim(1, 100, 1);  // short: the other slots have 0
  stage.send(1, 50);
  CHECK(stage.level(1) == 50);
  CHECK(stage.level(2) == 200);
  stage.claim(1, 100);
  CHECK(stage.level(2) == 50);
}

TEST_CASE("of equal per-address priorities the highest level counts, and down again") {
  Stage stage;
  for (const SenderId sender : {1u, 2u}) stage.claim(sender, 120);
  stage.send(1, 100);
  stage.send(2, 60);
  CHECK(stage.level() == 100);
  stage.send(1, 20);
  CHECK(stage.level() == 60);
}

TEST_CASE("of equal per-address priorities under LTP the latest change counts") {
  Stage stage(MergeMode::kLtp);
  for (const SenderId sender : {1u, 2u}) stage.claim(sender, 120);
  stage.send(1, 100);
  stage.send(2, 60);
  CHECK(stage.level() == 60);
  stage.send(1, 100);
  CHECK(stage.level() == 60);
  stage.send(1, 99);
  CHECK(stage.level() == 99);
}

TEST_CASE("a 0xDD frame of fewer than 512 values releases the other slots, also those it claimed before") {
  Stage stage;
  stage.send(1, 200, 50);
  stage.send(2, 10, 60);
  stage.claim(1, 100, 512);
  CHECK(stage.level(512) == 200);
  stage.claim(1, 100, 24);
  CHECK(stage.level(24) == 200);
  CHECK(stage.level(25) == 10);
  stage.claim(1, 100, 0);
  CHECK(stage.level(1) == 10);
}

TEST_CASE("a sender without 0xDD has its packets' priority in each slot, beside one that has it") {
  Stage stage;
  stage.send(1, 200, 100);
  stage.send(2, 10, 100);
  const std::array<std::uint8_t, 3> claims = {99, 100, 101};
  stage.claim_slots(2, claims);
  CHECK(stage.level(1) == 200);
  CHECK(stage.level(2) == 200);  // equal: HTP
  CHECK(stage.level(3) == 10);
  stage.send(1, 200, 98);
  CHECK(stage.level(1) == 10);
}

TEST_CASE("with per-address priorities a sender claims only the slots that it sends") {
  Stage stage;
  stage.send(1, 200, 150, 24);
  stage.send(2, 10, 100);
  CHECK(stage.level(25) == 0);  // without them the highest priority wins the whole universe
  stage.claim(2, 100);
  CHECK(stage.level(24) == 200);
  CHECK(stage.level(25) == 10);
}

TEST_CASE("taking control: levels first, then the priority, releasing it: priority 0") {
  Stage stage;
  stage.send(1, 100, 100);
  stage.claim(1, 100);
  stage.claim(2, 0);
  stage.send(2, 30, 100);
  CHECK(stage.level() == 100);
  const std::array<std::uint8_t, 1> take = {150};
  stage.claim_slots(2, take);
  CHECK(stage.level(1) == 30);
  CHECK(stage.level(2) == 100);
  stage.claim(2, 0);
  CHECK(stage.level(1) == 100);
}

TEST_CASE("a 0xDD frame before the first levels sets their priority from the first frame on") {
  Stage stage;
  stage.send(1, 100, 100);
  stage.claim(2, 90);
  CHECK(stage.level() == 100);
  CHECK(stage.merge().winner_count(0) == 1);
  stage.send(2, 200, 200);
  CHECK(stage.level() == 100);
  CHECK(stage.merge().sender(0, 1).per_address);
}

TEST_CASE("a sender of 0xDD without levels claims nothing, and is removed after the silence time") {
  Stage stage;
  stage.send(1, 100, 100);
  stage.claim(2, 200);
  CHECK(stage.level() == 100);
  stage.now_ns += kTimeout - 1;
  stage.send(1, 100, 100);
  stage.settle();
  CHECK(stage.merge().sender_count(0) == 2);
  stage.now_ns += 1;
  stage.settle();
  CHECK(stage.merge().sender_count(0) == 1);
}

TEST_CASE("when 0xDD stops and levels continue, the packets' priority applies again after 2.5 s to the nanosecond") {
  Stage stage;
  stage.send(2, 50, 100);
  stage.send(1, 200, 150);
  stage.claim(1, 10);
  CHECK(stage.level() == 50);
  for (int i = 1; i <= 10; ++i) {
    stage.now_ns = kStart + kTimeout * i / 10 - 1;
    stage.send(1, 200, 150);
    stage.send(2, 50, 100);
    CHECK(stage.level() == 50);
  }
  CHECK(stage.merge().next_expiry_ns() <= kStart + kTimeout);
  stage.now_ns = kStart + kTimeout;
  CHECK(stage.settle());
  CHECK(stage.level() == 200);
  CHECK_FALSE(stage.merge().sender(0, 1).per_address);
  CHECK(stage.counters().senders_silent == 0);
}

TEST_CASE("when levels stop the sender is removed, even if its 0xDD continues") {
  Stage stage;
  stage.claim(1, 200);
  stage.send(1, 200);
  stage.send(2, 50);
  CHECK(stage.level() == 200);
  for (int i = 1; i <= 10; ++i) {
    stage.now_ns = kStart + kTimeout * i / 10;
    stage.claim(1, 200);
    stage.send(2, 50);
    stage.settle();
  }
  CHECK(stage.level() == 50);
}

TEST_CASE("a terminated sender loses its per-address priorities, whichever of its frames is marked") {
  for (const std::uint8_t start_code : {kStartCodeLevels, kStartCodePriorities}) {
    Stage stage;
    stage.claim(1, 200);
    stage.send(1, 200, 100);
    stage.send(2, 50, 100);
    CHECK(stage.level() == 200);
    FrameView frame;
    frame.sender = 1;
    frame.terminated = true;
    frame.start_code = start_code;
    stage.receive(frame);
    CHECK(stage.level() == 50);
    stage.send(1, 200, 90);  // starts again, with the priority of its packets
    CHECK(stage.level() == 50);
  }
}

TEST_CASE("a new sender waits up to 1.5 s for its 0xDD only if others of its source send it") {
  Stage stage;
  FrameView frame;
  const std::array<std::uint8_t, 2> levels = {200, 200};
  frame.sender = 2;
  frame.priority = 150;
  frame.slots = levels;
  stage.claim(1, 100, 512, 7);
  const std::array<std::uint8_t, 2> old_levels = {10, 10};
  FrameView old = frame;
  old.sender = 1;
  old.slots = old_levels;
  stage.receive(old, 7);
  CHECK(stage.level() == 10);
  stage.receive(frame, 7);
  CHECK(stage.level() == 10);
  CHECK(stage.counters().frames_early == 1);

  const std::array<std::uint8_t, 2> claim = {0, 101};
  SUBCASE("it comes") {
    stage.now_ns += kNsPerS;
    stage.claim_slots(2, claim, 7);
    CHECK(stage.level(1) == 10);
    CHECK(stage.level(2) == 200);
  }
  SUBCASE("it does not") {
    stage.now_ns = kStart + kPrioritiesWaitNs - 1;
    stage.receive(frame, 7);
    CHECK(stage.level() == 10);
    CHECK(stage.merge().next_expiry_ns() <= kStart + kPrioritiesWaitNs);
    stage.now_ns += 1;
    CHECK(stage.level() == 200);
  }
  SUBCASE("the other one leaves") {
    FrameView end;
    end.sender = 1;
    end.terminated = true;
    stage.receive(end, 7);
    CHECK(stage.level() == 200);
  }
  SUBCASE("a sender of another source does not wait") {
    frame.sender = 3;
    stage.receive(frame, 8);
    CHECK(stage.level() == 200);
  }
}

TEST_CASE("a 0xDD frame with a value above 200 is refused and counted, and the previous one stays in effect") {
  Stage stage;
  stage.claim(1, 100);
  stage.send(1, 50);
  stage.send(2, 200, 99);
  const std::array<std::uint8_t, 2> wrong = {100, 201};
  CHECK(stage.claim_slots(1, wrong) == Merge::Received::kRefusedPriority);
  CHECK(stage.counters().refused_priority == 1);
  CHECK(stage.level(512) == 50);
}

TEST_CASE("a ninth sender is refused by its 0xDD frame, too") {
  Stage stage;
  for (SenderId sender = 1; sender <= 8; ++sender) stage.send(sender, 10);
  CHECK(stage.claim(9, 200) == Merge::Received::kRefusedFull);
  CHECK(stage.counters().refused_full == 1);
}

TEST_CASE("each slot names the senders that have set it: by level, by priority of its address, by the last change") {
  Stage stage;
  Merge::SlotSenders set;
  // As bits by sender, whatever their order in the merge.
  const auto bits = [&](std::size_t slot) {
    stage.settle();
    stage.merge().slot_senders(0, set);
    unsigned by_sender = 0;
    for (int k = 0; k < stage.merge().sender_count(0); ++k) {
      if ((set[slot] >> k & 1) != 0) by_sender |= 1u << stage.merge().sender(0, k).id;
    }
    return by_sender;
  };
  stage.send_slots(1, std::vector<std::uint8_t>{10, 20, 30});
  CHECK(bits(0) == 2);
  CHECK(bits(3) == 0);  // nobody sends it
  stage.send_slots(2, std::vector<std::uint8_t>{5, 20, 40, 0});
  CHECK(bits(0) == 2);
  CHECK(bits(1) == 6);
  CHECK(bits(2) == 4);
  stage.send_slots(3, std::vector<std::uint8_t>{255}, 90);  // outranked
  CHECK(bits(0) == 2);
  stage.claim_slots(2, std::vector<std::uint8_t>{150, 0, 50});
  CHECK(bits(0) == 4);  // though its level is lower
  CHECK(bits(1) == 2);
  CHECK(bits(2) == 2);
  Stage ltp(MergeMode::kLtp);
  ltp.send(1, 200);
  ltp.settle();
  ltp.send(2, 100);
  ltp.settle();
  ltp.merge().slot_senders(0, set);
  for (int k = 0; k < 2; ++k) CHECK((set[7] >> k & 1) == (ltp.merge().sender(0, k).id == 2 ? 1 : 0));
}

TEST_CASE("a sender without claims is reported as losing, and its frames make no snapshot") {
  Stage stage;
  stage.send(1, 10, 100);
  stage.claim(2, 0);
  stage.send(2, 200, 200);
  stage.settle();
  stage.send(2, 201, 200);
  CHECK_FALSE(stage.settle());
  CHECK_FALSE(stage.merge().sender(0, 1).wins);
  CHECK(stage.merge().winner_count(0) == 1);
  CHECK(stage.counters().frames_outranked == 2);
  stage.send(1, 11, 100);
  CHECK(stage.settle());
  const MergeCounters& counters = stage.counters();
  CHECK(counters.frames == counters.frames_shown + counters.frames_outranked + counters.frames_priorities);
}

TEST_CASE("a reused place has no per-address priorities of the old sender") {
  Stage stage;
  stage.claim(1, 200);
  stage.send(1, 200);
  stage.claim(2, 100);
  stage.send(2, 10);
  stage.settle();
  stage.terminate(1);
  stage.claim(3, 50, 1);
  stage.send(3, 99);
  CHECK(stage.level(1) == 10);
  CHECK(stage.level(512) == 10);
}

TEST_CASE("a merge that adopts another one keeps per-address priorities and which sender changed each slot last") {
  Merge old(1);
  old.set_slot_modes(0, SlotSet(2));  // address 2
  FrameView frame;
  const std::array<std::uint8_t, 3> first = {10, 200, 5}, second = {20, 100, 6}, claim = {100, 100, 101};
  frame.sender = 1;
  frame.slots = first;
  old.receive(0, frame, kStart);
  frame.sender = 2;
  frame.slots = second;
  old.receive(0, frame, kStart);
  frame.sender = 1;
  frame.start_code = kStartCodePriorities;
  frame.slots = claim;
  old.receive(0, frame, kStart);
  old.resolve(0);
  old.clear_changed();
  CHECK(old.snapshot(0).slots[1] == 100);
  Merge next(2);
  const std::array<int, 2> from_index = {-1, 0};
  next.adopt(old, from_index);
  next.set_slot_modes(1, SlotSet(2));
  CHECK(next.resolve(1));
  CHECK(next.snapshot(1).slots[0] == 20);
  CHECK(next.snapshot(1).slots[1] == 100);
  CHECK(next.snapshot(1).slots[2] == 5);
  CHECK(next.sender(1, 0).per_address);
}

TEST_CASE("a merge that adopts another one uses its own LTP slots at once") {
  Merge old(1);
  old.set_slot_modes(0, SlotSet(0b10));  // address 2
  FrameView frame;
  const std::array<std::uint8_t, 3> first = {200, 200, 200}, second = {100, 100, 100};
  for (const SenderId sender : {1u, 2u}) {
    frame.sender = sender;
    frame.slots = sender == 1 ? first : second;
    old.receive(0, frame, kStart);
    old.resolve(0);
    old.clear_changed();
  }
  CHECK(old.snapshot(0).slots[1] == 100);
  const std::array<int, 1> from_index = {0};
  Merge moved(1);
  moved.adopt(old, from_index);
  moved.set_slot_modes(0, SlotSet(0b100));
  REQUIRE(moved.changed().size() == 1);
  moved.resolve(0);
  moved.clear_changed();
  CHECK(moved.snapshot(0).slots[1] == 200);
  CHECK(moved.snapshot(0).slots[2] == 100);  // the last change was recorded although no LTP slot needed it
  Merge without(1);
  without.adopt(moved, from_index);
  REQUIRE(without.changed().size() == 1);
  without.resolve(0);
  CHECK(without.snapshot(0).slots[2] == 200);
}

TEST_CASE("slots that become LTP without a known change keep the highest level until a sender changes them") {
  Stage stage;
  stage.send(1, 100);
  stage.send(2, 200);
  stage.settle();
  stage.merge().set_slot_modes(0, SlotSet(1));
  stage.settle();
  CHECK(stage.level(1) == 200);
  CHECK(stage.level(2) == 200);
  stage.send(1, 90);
  CHECK(stage.level(1) == 90);
  CHECK(stage.level(2) == 200);
}

// --- HTP and LTP by slot ---

TEST_CASE("slots that are LTP show the latest change beside slots that are HTP") {
  Stage stage;
  stage.merge().set_slot_modes(0, SlotSet(0b110));
  std::array<std::uint8_t, 3> a = {200, 200, 200}, b = {100, 100, 100};
  stage.send_slots(1, a);
  stage.send_slots(2, b);
  CHECK(stage.level(1) == 200);
  CHECK(stage.level(2) == 100);
  CHECK(stage.level(3) == 100);
  a[1] = 201;
  stage.send_slots(1, a);
  CHECK(stage.level(2) == 201);
  CHECK(stage.level(3) == 100);  // each slot separately
  stage.send_slots(2, b);        // a repeat is not a change
  CHECK(stage.level(2) == 201);
  b[0] = 255;
  stage.send_slots(2, b);
  CHECK(stage.level(1) == 255);
  CHECK(stage.level(2) == 201);
}

TEST_CASE("priority comes before slot modes, and a lower sender does not fill slots that the winner does not send") {
  Stage stage;
  stage.merge().set_slot_modes(0, SlotSet(0b10));
  stage.send(1, 10, 150, 2);
  stage.send(2, 200, 100);
  CHECK(stage.level(1) == 10);
  CHECK(stage.level(2) == 10);
  CHECK(stage.level(3) == 0);
  stage.terminate(1);
  CHECK(stage.level(2) == 200);
}

TEST_CASE("set_mode removes slot modes, and an empty set of slots is HTP") {
  for (const bool by_set : {true, false}) {
    Stage stage;
    stage.merge().set_slot_modes(0, SlotSet(1));
    stage.send(1, 200);
    stage.send(2, 100);
    CHECK(stage.level() == 100);
    if (by_set) {
      stage.merge().set_mode(0, MergeMode::kHtp);
    } else {
      stage.merge().set_slot_modes(0, {});
    }
    CHECK(stage.level() == 200);
  }
}

// A second, slow implementation of the rules: a map of senders and a fold over all of them for every slot.
TEST_CASE("a long random history gives the snapshots of a slow reference implementation") {
  struct Expected {
    std::uint8_t priority;
    TimeNs received_ns;
    std::vector<std::uint8_t> slots;
  };
  constexpr int kSlots = 5;
  Stage stage;
  std::map<SenderId, Expected> senders;
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
      senders.erase(sender);
    } else if (what < 8) {
      std::vector<std::uint8_t> slots(draw(kSlots + 1));
      for (std::uint8_t& slot : slots) slot = static_cast<std::uint8_t>(draw(256));
      stage.send_slots(sender, slots, priority);
      if (priority <= kPriorityMax) {
        Expected& entry = senders[sender];
        entry.priority = priority;
        entry.received_ns = stage.now_ns;
        if (entry.slots.size() < slots.size()) entry.slots.resize(slots.size());
        std::copy(slots.begin(), slots.end(), entry.slots.begin());
      }
    }
    std::erase_if(senders, [&](const auto& entry) { return entry.second.received_ns + kTimeout <= stage.now_ns; });

    int top = -1;
    for (const auto& [id, entry] : senders) top = std::max(top, static_cast<int>(entry.priority));
    for (std::size_t slot = 0; slot < kSlots; ++slot) {
      int level = -1;
      for (const auto& [id, entry] : senders)
        if (entry.priority == top && slot < entry.slots.size())
          level = std::max(level, static_cast<int>(entry.slots[slot]));
      if (level >= 0) expected[slot] = static_cast<std::uint8_t>(level);
    }
    stage.settle();
    const FrameView snapshot = stage.merge().snapshot(0);
    REQUIRE(std::equal(expected.begin(), expected.end(), snapshot.slots.begin()));
    REQUIRE(stage.merge().sender_count(0) == static_cast<int>(senders.size()));
  }
}

// As above, with per-address priorities, their silence, and slots that are LTP.
TEST_CASE(
    "a long random history with priorities and modes by slot gives the snapshots of a slow reference implementation") {
  struct Expected {
    int priority = 0;
    TimeNs received_ns = -1;  // no levels yet
    TimeNs priorities_ns = -1;
    std::map<int, std::pair<int, int>> levels;  // slot -> level, step of its last change
    std::map<int, int> priorities;
  };
  constexpr int kSlots = 6;
  const SlotSet ltp(0b101100);
  Stage stage;
  stage.merge().set_slot_modes(0, ltp);
  std::map<SenderId, Expected> senders;
  std::array<int, kSlots> expected{};
  std::uint64_t random = 4242;
  const auto draw = [&](std::uint64_t below) {
    random = random * 6364136223846793005u + 1442695040888963407u;
    return (random >> 33) % below;
  };
  const auto reckon = [&] {
    int top = -1;
    bool speakers = false;
    for (const auto& [id, entry] : senders) {
      if (entry.received_ns >= 0) top = std::max(top, entry.priority);
      speakers = speakers || (entry.priorities_ns >= 0 && entry.received_ns >= 0);
    }
    for (int slot = 0; slot < kSlots; ++slot) {
      int best = -1, level = -1, changed = -1;
      for (const auto& [id, entry] : senders) {
        const auto known = entry.levels.find(slot);
        if (entry.received_ns < 0 || known == entry.levels.end()) continue;
        if (!speakers && entry.priority != top) continue;
        int rank = entry.priority;
        if (entry.priorities_ns >= 0) {
          const auto claim = entry.priorities.find(slot);
          if (claim == entry.priorities.end() || claim->second == 0) continue;
          rank = claim->second;
        }
        if (rank < best) continue;
        const auto [its_level, its_change] = known->second;
        const bool takes =
            rank > best || (ltp[static_cast<std::size_t>(slot)] ? its_change > changed : its_level > level);
        best = rank;
        if (!takes) continue;
        level = its_level;
        changed = its_change;
      }
      if (best >= 0) expected[static_cast<std::size_t>(slot)] = level;
    }
  };
  for (int step = 1; step <= 50'000; ++step) {
    stage.now_ns += static_cast<TimeNs>(draw(800)) * kNsPerMs;
    const auto expire = [&] {
      for (auto& [id, entry] : senders)
        if (entry.priorities_ns >= 0 && entry.priorities_ns + kTimeout <= stage.now_ns) {
          entry.priorities_ns = -1;
          entry.priorities.clear();
        }
      std::erase_if(senders, [&](const auto& pair) {
        const Expected& entry = pair.second;
        return entry.received_ns >= 0 ? entry.received_ns + kTimeout <= stage.now_ns : entry.priorities_ns < 0;
      });
    };
    expire();
    reckon();  // resolve the rest before the next frame
    stage.settle();
    const SenderId sender = 1 + draw(8);
    const SourceId source = static_cast<SourceId>(sender);  // so no sender is held back
    const auto priority = static_cast<std::uint8_t>(99 + draw(3));
    const std::uint64_t what = draw(20);
    FrameView frame;
    frame.sender = sender;
    frame.priority = priority;
    std::vector<std::uint8_t> slots(draw(kSlots + 1));
    if (what == 0) {
      frame.terminated = true;
      stage.receive(frame, source);
      senders.erase(sender);
    } else if (what < 7) {
      for (std::uint8_t& slot : slots) slot = static_cast<std::uint8_t>(draw(3) == 0 ? 0 : 98 + draw(4));
      stage.claim_slots(sender, slots, source);
      Expected& entry = senders[sender];
      entry.priorities_ns = stage.now_ns;
      entry.priorities.clear();
      for (int slot = 0; slot < static_cast<int>(slots.size()); ++slot)
        entry.priorities[slot] = slots[static_cast<std::size_t>(slot)];
    } else {
      for (std::uint8_t& slot : slots) slot = static_cast<std::uint8_t>(draw(3));
      frame.slots = slots;
      stage.receive(frame, source);
      Expected& entry = senders[sender];
      const bool all = entry.received_ns < 0 || entry.priority != priority;
      entry.priority = priority;
      entry.received_ns = stage.now_ns;
      for (int slot = 0; slot < static_cast<int>(slots.size()); ++slot) {
        const int level = slots[static_cast<std::size_t>(slot)];
        const auto known = entry.levels.find(slot);
        if (all || known == entry.levels.end() || known->second.first != level) entry.levels[slot] = {level, step};
      }
    }

    reckon();
    stage.settle();
    const FrameView snapshot = stage.merge().snapshot(0);
    REQUIRE(std::equal(expected.begin(), expected.end(), snapshot.slots.begin()));
    REQUIRE(stage.merge().sender_count(0) == static_cast<int>(senders.size()));
    const MergeCounters& counted = stage.counters();
    REQUIRE(counted.frames ==
            counted.frames_shown + counted.frames_outranked + counted.frames_priorities + counted.frames_ended);
  }
}
