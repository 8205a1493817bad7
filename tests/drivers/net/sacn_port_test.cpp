// sACN ports connected over real sockets, in a network namespace with only "lo".
#include "drivers/net/sacn_port.h"

#include <doctest/doctest.h>

#include <optional>
#include <random>
#include <set>

#include <netinet/in.h>
#include <sys/socket.h>

#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/support/must.h"

namespace footlight::drivers {
namespace {

using testing::enter_private_network;
using testing::frame_of;
using testing::KeepingReceiver;
using testing::must;
using testing::poll_until;
using testing::receives_nothing;
using testing::test_levels;
using testing::universes_from;

constexpr TimeNs kStartNs = 1'000 * kNsPerS;

SacnSourceOptions source_options(std::vector<WireUniverse> universes) {
  SacnSourceOptions options;
  options.name = "sacn:test-in";
  options.universes = std::move(universes);
  options.kernel_stamps = false;  // stamps then equal the time that the test passes
  return options;
}

SacnSinkOptions sink_options(std::vector<WireUniverse> universes) {
  SacnSinkOptions options;
  options.name = "sacn:test-out";
  options.universes = std::move(universes);
  options.announce = false;  // deadlines are then those of frames only; sacn_rules_test.cpp tests announcements
  return options;
}

// Datagrams with levels of its universes that a source has read, duplicates included.
std::uint64_t source_count(const SacnSource& source) { return source.counters().frames + source.details().late; }

// Sends packets made by the test, like a faulty sender.
class HandSender {
 public:
  explicit HandSender(int universe, std::uint8_t cid_octet = 1) : socket_(must(open_sender({"test", 0}))) {
    data_.cid.fill(cid_octet);
    data_.universe = universe;
  }
  void send() {
    std::array<std::uint8_t, kSacnDataBytesMax> packet;
    send_bytes(std::span(packet).first(build_sacn_data(data_, packet)));
  }
  void send(std::uint8_t sequence) {
    data_.sequence = sequence;
    send();
  }
  void send_bytes(std::span<const std::uint8_t> bytes) {
    writer_.add(bytes, 0x7F000001, kSacnPort);
    REQUIRE(writer_.flush(socket_.get()).error_number == 0);
  }
  SacnData& data() { return data_; }

 private:
  Fd socket_;
  DatagramWriter writer_;
  SacnData data_;
};

}  // namespace

TEST_CASE("nine universes cross from sink to source by multicast, every level of every round exact") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options(universes_from(1, 9, 1))));
  auto sink = must(SacnSink::create(sink_options(universes_from(1, 9, 1))));
  CHECK(source->state() == PortState::kWaiting);
  CHECK(sink->state() == PortState::kWaiting);
  for (int round = 0; round < 300; ++round) {  // past the wrap of the sequence number
    std::vector<std::vector<std::uint8_t>> levels;
    std::vector<FrameView> frames;
    for (int u = 1; u <= 9; ++u) levels.push_back(test_levels(u, round));
    for (int u = 1; u <= 9; ++u) frames.push_back(frame_of(u, levels[static_cast<std::size_t>(u - 1)]));
    const TimeNs now_ns = kStartNs + round * 22 * kNsPerMs;
    REQUIRE(sink->send(now_ns, frames).has_value());
    KeepingReceiver receiver;
    REQUIRE(poll_until(*source, now_ns, receiver, [&] { return receiver.frames.size() >= 9; }));
    REQUIRE(receiver.frames.size() == 9);
    for (int u = 1; u <= 9; ++u) {
      const auto& got = receiver.frames[static_cast<std::size_t>(u - 1)];
      REQUIRE(got.view.universe == u);
      REQUIRE(got.view.stamp_ns == now_ns);
      REQUIRE(got.view.priority == 100);
      REQUIRE(got.view.sequence == static_cast<std::uint32_t>(round % 256));
      REQUIRE_FALSE(got.view.terminated);
      REQUIRE(got.slots == levels[static_cast<std::size_t>(u - 1)]);
    }
  }
  CHECK(source->counters().frames == 2700);
  CHECK(source->counters().rejected == 0);
  CHECK(source->counters().dropped == 0);
  CHECK(sink->counters().frames == 2700);
  CHECK(source->state() == PortState::kWorking);
  CHECK(sink->state() == PortState::kWorking);
}

TEST_CASE("a closing sink ends exactly the universes that it has sent, once each") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options(universes_from(1, 9, 1))));
  auto sink = must(SacnSink::create(sink_options(universes_from(1, 9, 1))));
  const auto levels = test_levels(3, 0);
  const std::vector<FrameView> frames = {frame_of(3, levels), frame_of(7, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  sink->close(kStartNs);
  sink->close(kStartNs);
  CHECK(sink->state() == PortState::kEnded);
  CHECK(sink->next_deadline_ns() == kTimeNever);
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return source->details().ended_already >= 4; }));
  REQUIRE(receiver.frames.size() == 4);
  CHECK_FALSE(receiver.frames[0].view.terminated);
  CHECK_FALSE(receiver.frames[1].view.terminated);
  for (const std::size_t i : {2u, 3u}) {
    CHECK(receiver.frames[i].view.terminated);
    CHECK(receiver.frames[i].slots.empty());
    CHECK(receiver.frames[i].view.universe == (i == 2 ? 3 : 7));
    CHECK(receiver.frames[i].view.sender == receiver.frames[0].view.sender);
  }
}

TEST_CASE("a resting sink ends its universes and is silent until its next frame, which is received again") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  auto options = sink_options({{1, 1}});
  options.address_priorities = {120};
  auto sink = must(SacnSink::create(options));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  sink->rest(kStartNs);
  CHECK(sink->next_deadline_ns() == kTimeNever);
  REQUIRE(sink->poll(kStartNs + 60 * kNsPerS).has_value());
  CHECK(sink->state() == PortState::kWorking);
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return source->details().ended_already >= 2; }));
  REQUIRE_FALSE(receiver.frames.empty());
  CHECK(receiver.frames.back().view.terminated);
  const std::size_t before = receiver.frames.size();

  REQUIRE(sink->send(kStartNs, frames).has_value());  // the same levels
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= before + 2; }));
  CHECK_FALSE(receiver.frames.back().view.terminated);
  CHECK(receiver.frames.back().slots == levels);
  CHECK(receiver.frames[before].view.start_code != receiver.frames[before + 1].view.start_code);  // priorities again
}

TEST_CASE("a resting sink with a chosen identifier ends nothing, because its main may have the same") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  auto options = sink_options({{1, 1}});
  options.cid.fill(7);
  auto sink = must(SacnSink::create(options));
  auto main_options = options;
  main_options.name = "main";
  auto main = must(SacnSink::create(main_options));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  sink->rest(kStartNs);
  CHECK(sink->next_deadline_ns() == kTimeNever);
  const auto other_levels = test_levels(2, 1);
  const std::vector<FrameView> other_frames = {frame_of(1, other_levels)};
  for (int i = 0; i < 2; ++i) REQUIRE(main->send(kStartNs, other_frames).has_value());
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver,
                     [&] { return !receiver.frames.empty() && receiver.frames.back().slots == other_levels; }));
  for (const auto& frame : receiver.frames) CHECK_FALSE(frame.view.terminated);
}

TEST_CASE("a sender that restarts after its end is received again") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  HandSender sender(1);
  KeepingReceiver receiver;
  sender.send(10);
  sender.data().terminated = true;
  for (const int sequence : {11, 12, 13}) sender.send(static_cast<std::uint8_t>(sequence));
  sender.data().terminated = false;
  sender.send(10);  // a late packet from before the end does not restart it
  sender.send(14);
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 3; }));
  CHECK(receiver.frames.size() == 3);
  CHECK(receiver.frames[1].view.terminated);
  CHECK(receiver.frames[2].view.sequence == 14);
  CHECK(source->details().late == 1);
  // After a silence of 2.5 s any number is new.
  sender.send(0);
  REQUIRE(poll_until(*source, kStartNs + 2'500 * kNsPerMs, receiver, [&] { return receiver.frames.size() >= 4; }));
}

TEST_CASE("sequence numbers from 0 to 19 behind are discarded, 20 behind and any ahead are accepted") {
  if (!enter_private_network()) return;
  for (int step = -128; step < 128; ++step) {
    CAPTURE(step);
    SequenceFilter filter;
    const std::uint8_t base = 5;  // so that steps cross the wrap in both directions
    REQUIRE(filter.judge(1, base, false, SequenceRule::kSacn, kStartNs) == SequenceFilter::Verdict::kNew);
    const auto verdict = filter.judge(1, static_cast<std::uint8_t>(base + step), false, SequenceRule::kSacn, kStartNs);
    CHECK((verdict == SequenceFilter::Verdict::kLate) == (step > -20 && step <= 0));
  }
  auto source = must(SacnSource::create(source_options({{1, 1}, {2, 2}})));
  HandSender sender(1);
  HandSender other(1, 2);
  HandSender elsewhere(2);
  KeepingReceiver receiver;
  sender.send(100);
  sender.send(95);     // late
  other.send(95);      // another sender is checked separately
  elsewhere.send(95);  // so is another universe of the same sender
  sender.send(100);    // duplicate
  sender.send(80);     // taken as a restart
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 4; }));
  CHECK(receiver.frames.size() == 4);
  CHECK(source->details().late == 2);
  CHECK(receiver.frames[0].view.sender != receiver.frames[1].view.sender);
  CHECK(receiver.frames[0].view.sender == receiver.frames[2].view.sender);
}

TEST_CASE("a thousand forged senders do not increase the memory of the sequence rule nor disturb a real one") {
  SequenceFilter filter;
  for (int i = 0; i < 1'000; ++i) {
    const TimeNs now_ns = kStartNs + i * kNsPerMs;
    REQUIRE(filter.judge(1, static_cast<std::uint8_t>(i), false, SequenceRule::kSacn, now_ns) ==
            SequenceFilter::Verdict::kNew);
    REQUIRE(filter.judge(1, static_cast<std::uint8_t>(i), false, SequenceRule::kSacn, now_ns) ==
            SequenceFilter::Verdict::kLate);
    filter.judge(static_cast<SenderId>(i + 2), 0, false, SequenceRule::kSacn, now_ns);
  }
}

TEST_CASE(
    "preview, other start codes, other universes, sync and invalid packets give no frame and are counted separately") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  KeepingReceiver receiver;
  HandSender preview(1, 1);
  preview.data().preview = true;
  preview.send(1);
  HandSender text(1, 2);
  text.data().start_code = 0x17;
  text.send(1);
  HandSender elsewhere(2, 3);
  elsewhere.send(1);
  HandSender rubbish(1, 4);
  const std::vector<std::uint8_t> zeros(638);
  rubbish.send_bytes(zeros);
  rubbish.send_bytes(std::span(zeros).first(0));
  const std::vector<std::uint8_t> huge(4'000);
  rubbish.send_bytes(huge);
  HandSender good(1, 5);
  good.data().priority = 7;
  good.data().sync_universe = 500;  // there was no synchronisation packet yet, so it is not held
  good.send(1);
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return !receiver.frames.empty(); }));
  CHECK(receiver.frames.size() == 1);
  CHECK(receiver.frames[0].view.priority == 7);
  CHECK(source->details().preview == 1);
  CHECK(source->details().other_start_code == 1);
  CHECK(source->details().other_universe == 1);
  CHECK(source->counters().rejected == 3);

  auto visualiser_options = source_options({{1, 1}});
  visualiser_options.hear_preview = true;
  source = must(SacnSource::create(visualiser_options));
  preview.send(2);
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 2; }));
}

TEST_CASE("an unchanged frame is sent three more times and then every 900 ms") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  auto sink = must(SacnSink::create(sink_options({{1, 1}})));
  CHECK(sink->next_deadline_ns() == kTimeNever);
  REQUIRE(sink->poll(kStartNs).has_value());  // nothing to keep alive before the first frame
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  KeepingReceiver receiver;
  std::vector<DurationNs> sent_after_ns;
  TimeNs last_ns = kStartNs;
  for (int i = 0; i < 6; ++i) {
    const TimeNs due_ns = sink->next_deadline_ns();
    sent_after_ns.push_back(due_ns - last_ns);
    last_ns = due_ns;
    REQUIRE(sink->poll(due_ns - 1).has_value());  // too early: nothing
    REQUIRE(sink->counters().frames == static_cast<std::uint64_t>(1 + i));
    REQUIRE(sink->poll(due_ns).has_value());
    REQUIRE(sink->counters().frames == static_cast<std::uint64_t>(2 + i));
  }
  for (int i = 0; i < 3; ++i) CHECK(sent_after_ns[static_cast<std::size_t>(i)] == 25 * kNsPerMs);
  for (int i = 3; i < 6; ++i) CHECK(sent_after_ns[static_cast<std::size_t>(i)] == 900 * kNsPerMs);
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 7; }));
  for (const auto& frame : receiver.frames) CHECK(frame.slots == levels);
}

TEST_CASE("sending the same levels again and again sends them four times, a change starts again") {
  if (!enter_private_network()) return;
  auto sink = must(SacnSink::create(sink_options({{1, 1}})));
  auto levels = test_levels(1, 0);
  for (int i = 0; i < 20; ++i) {
    const std::vector<FrameView> frames = {frame_of(1, levels)};
    REQUIRE(sink->send(kStartNs + i * 22 * kNsPerMs, frames).has_value());
  }
  CHECK(sink->counters().frames == 4);
  levels[511] ^= 1;
  const std::vector<FrameView> frames = {frame_of(1, levels), frame_of(2, levels)};  // universe 2 is not ours
  REQUIRE(sink->send(kStartNs + kNsPerS, frames).has_value());
  CHECK(sink->counters().frames == 5);
  CHECK(sink->next_deadline_ns() == kStartNs + kNsPerS + 25 * kNsPerMs);
}

TEST_CASE("a short frame does not change the slots past its end") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  auto sink = must(SacnSink::create(sink_options({{1, 1}})));
  const std::vector<std::uint8_t> first = {1, 2, 3, 4};
  const std::vector<std::uint8_t> second = {9};
  std::vector<FrameView> frames = {frame_of(1, first)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  frames = {frame_of(1, second)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 2; }));
  CHECK(receiver.frames[0].slots == first);
  CHECK(receiver.frames[1].slots == std::vector<std::uint8_t>{9, 2, 3, 4});
}

TEST_CASE("wire universes 101 to 109 are received and sent as 1 to 9") {
  if (!enter_private_network()) return;
  const auto renumbered = must(parse_wire_universes("101-109=1-9"));
  auto in = must(SacnSource::create(source_options(renumbered)));
  auto wire = must(SacnSource::create(source_options(universes_from(101, 9, 101))));
  auto out = must(SacnSink::create(sink_options(renumbered)));
  std::vector<std::vector<std::uint8_t>> levels;
  std::vector<FrameView> frames;
  for (int u = 1; u <= 9; ++u) levels.push_back(test_levels(u, 0));
  for (int u = 1; u <= 9; ++u) frames.push_back(frame_of(u, levels[static_cast<std::size_t>(u - 1)]));
  REQUIRE(out->send(kStartNs, frames).has_value());
  KeepingReceiver heard_in;
  KeepingReceiver heard_wire;
  REQUIRE(poll_until(*in, kStartNs, heard_in, [&] { return heard_in.frames.size() >= 9; }));
  REQUIRE(poll_until(*wire, kStartNs, heard_wire, [&] { return heard_wire.frames.size() >= 9; }));
  for (int u = 1; u <= 9; ++u) {
    const auto i = static_cast<std::size_t>(u - 1);
    CHECK(heard_in.frames[i].view.universe == u);
    CHECK(heard_wire.frames[i].view.universe == 100 + u);
    CHECK(heard_in.frames[i].slots == levels[i]);
    CHECK(heard_wire.frames[i].slots == levels[i]);
  }
}

TEST_CASE("101 universes use the groups of six sockets, and each is received once") {
  if (!enter_private_network()) return;
  auto options = source_options(universes_from(1, 101, 1));
  options.interface_names = {"lo"};
  auto source = must(SacnSource::create(options));
  CHECK(source->socket_count() == 6);
  auto out_options = sink_options(universes_from(1, 101, 1));
  out_options.interface_names = {"lo"};
  auto sink = must(SacnSink::create(out_options));
  const auto levels = test_levels(1, 0);
  std::vector<FrameView> frames;
  for (int u = 1; u <= 101; ++u) frames.push_back(frame_of(u, levels));
  REQUIRE(sink->send(kStartNs, frames).has_value());
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() >= 101; }));
  REQUIRE(receives_nothing(*source, kStartNs, receiver));
  std::set<int> universes;
  for (const auto& frame : receiver.frames) universes.insert(frame.view.universe);
  CHECK(universes.size() == 101);
  CHECK(source->details().late == 0);  // no datagram came through two sockets

  // On an interface that is not selected it receives nothing, although another socket joins the same groups there.
  if (!testing::add_interface("eth4", "10.99.4.1")) return;
  auto elsewhere = options;
  elsewhere.interface_names = {"eth4"};
  auto other = must(SacnSource::create(elsewhere));
  out_options.interface_names = {"eth4"};
  out_options.source_name = "other";
  auto other_sink = must(SacnSink::create(out_options));
  REQUIRE(other_sink->send(kStartNs, frames).has_value());
  KeepingReceiver other_receiver;
  CHECK(poll_until(*other, kStartNs, other_receiver, [&] { return other_receiver.frames.size() == 101; }));
  CHECK(receives_nothing(*source, kStartNs, receiver));
}

TEST_CASE("two sources on one machine both receive a multicast sender") {
  if (!enter_private_network()) return;
  auto first = must(SacnSource::create(source_options({{1, 1}})));
  auto second = must(SacnSource::create(source_options({{1, 1}})));
  auto sink = must(SacnSink::create(sink_options({{1, 1}})));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  for (auto* source : {first.get(), second.get()}) {
    KeepingReceiver receiver;
    CHECK(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() == 1; }));
  }
}

TEST_CASE("a source ignores the sinks of its own program and receives those of others") {
  if (!enter_private_network()) return;
  const auto own_senders = std::make_shared<OwnSenders>();
  auto in = source_options({{1, 1}});
  in.own_senders = own_senders;
  auto source = must(SacnSource::create(in));
  auto out = sink_options({{1, 1}});
  out.own_senders = own_senders;
  auto own = must(SacnSink::create(out));
  auto foreign_options = sink_options({{1, 1}});
  foreign_options.source_name = "Another program";
  auto foreign = must(SacnSink::create(foreign_options));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(own->send(kStartNs, frames).has_value());
  REQUIRE(foreign->send(kStartNs, frames).has_value());
  KeepingReceiver receiver;
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return !receiver.frames.empty(); }));
  own->close(kStartNs);
  REQUIRE(receives_nothing(*source, kStartNs, receiver));
  CHECK(receiver.frames.size() == 1);
  CHECK(source->details().own == 4);
}

TEST_CASE("20000 damaged packets sent to a live source disturb none of the good ones between them") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  HandSender rubbish(1, 9);
  auto sink_made = sink_options({{1, 1}});
  sink_made.addresses = {"127.0.0.1"};
  auto sink = must(SacnSink::create(sink_made));
  std::mt19937 random(3);
  const auto noise_levels = test_levels(1, 99);
  std::array<std::uint8_t, kSacnDataBytesMax> good_packet;
  SacnData data;
  data.cid.fill(9);
  data.universe = 1;
  data.slots = noise_levels;
  build_sacn_data(data, good_packet);
  std::optional<SenderId> good_sender;
  for (int round = 0; round < 1'000; ++round) {
    for (int i = 0; i < 20; ++i) {
      auto packet = good_packet;
      for (std::size_t f = 0; f < 1 + random() % 4; ++f) packet[random() % 126] = static_cast<std::uint8_t>(random());
      rubbish.send_bytes(std::span(packet).first(random() % 4 == 0 ? random() % packet.size() : packet.size()));
    }
    const auto levels = test_levels(1, round);
    const std::vector<FrameView> frames = {frame_of(1, levels)};
    REQUIRE(sink->send(kStartNs, frames).has_value());
    KeepingReceiver receiver;
    const auto found = [&] {
      for (const auto& frame : receiver.frames) {
        if (frame.slots == levels && (!good_sender || frame.view.sender == *good_sender)) {
          good_sender = frame.view.sender;
          return true;
        }
      }
      return false;
    };
    REQUIRE(poll_until(*source, kStartNs, receiver, found));
    for (const auto& frame : receiver.frames) {
      REQUIRE(frame.view.universe == 1);
      REQUIRE(frame.view.priority <= 200);
      REQUIRE(frame.slots.size() <= 512);
    }
  }
  CHECK(source->counters().rejected > 1'000);
}

TEST_CASE("a kernel stamp is not later than the poll and gives the waiting time of the datagram") {
  if (!enter_private_network()) return;
  auto options = source_options({{1, 1}});
  options.kernel_stamps = true;
  auto source = must(SacnSource::create(options));
  HandSender sender(1);
  KeepingReceiver receiver;
  // The kernel starts stamping shortly after the first socket requests it; earlier datagrams have the time of poll().
  bool stamped = false;
  for (int i = 0; i < 200 && !stamped; ++i) {
    sender.send(static_cast<std::uint8_t>(i));
    const TimeNs sent_ns = testing::real_now_ns();
    while (testing::real_now_ns() < sent_ns + 3 * kNsPerMs) {
    }
    const std::size_t before = receiver.frames.size();
    REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() > before; }));
    const TimeNs stamp_ns = receiver.frames.back().view.stamp_ns;
    REQUIRE(stamp_ns <= kStartNs);
    REQUIRE(stamp_ns > kStartNs - 10 * kNsPerS);
    stamped = stamp_ns <= kStartNs - 3 * kNsPerMs;
  }
  CHECK(stamped);
}

TEST_CASE("a flood past the receive buffer is counted as dropped") {
  if (!enter_private_network()) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  HandSender sender(1);
  const std::vector<std::uint8_t> levels(512);
  sender.data().slots = levels;
  constexpr int kFlood = 20'000;  // more than 4 MiB, doubled by the kernel, hold
  for (int i = 0; i < kFlood; ++i) sender.send(static_cast<std::uint8_t>(i));
  KeepingReceiver receiver;
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  REQUIRE(receiver.frames.size() < kFlood);
  // The kernel reports it with the next datagram that fits.
  HandSender late_comer(1, 2);
  late_comer.send(1);
  const std::size_t before = receiver.frames.size();
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() > before; }));
  CHECK(source->counters().dropped + receiver.frames.size() == kFlood + 1);
}

TEST_CASE("source and sink follow an interface that appears, disappears and returns") {
  if (!enter_private_network(false)) return;
  auto source = must(SacnSource::create(source_options({{1, 1}})));
  CHECK(source->state() == PortState::kGone);
  CHECK(source->trouble().find("no network interface is up and supports multicast") != std::string::npos);
  if (!testing::add_interface("eth7", "10.99.0.1")) return;
  KeepingReceiver receiver;
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  CHECK(source->state() == PortState::kWaiting);
  auto out = sink_options({{1, 1}});
  out.interface_names = {"eth7"};
  auto sink = must(SacnSink::create(out));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() == 1; }));

  testing::remove_interface("eth7");
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  REQUIRE(sink->poll(sink->next_deadline_ns()).has_value());
  CHECK(sink->state() == PortState::kGone);
  CHECK(sink->trouble().find("sacn:test-out: cannot send to 239.255.0.1:5568") != std::string::npos);

  // The sink has kept the levels and sends them again by itself, although the interface has another number now.
  REQUIRE(testing::add_interface("eth7", "10.99.0.1"));
  REQUIRE(testing::drain(*source, kStartNs, receiver));
  REQUIRE(sink->poll(sink->next_deadline_ns()).has_value());
  CHECK(sink->state() == PortState::kWorking);
  REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() == 2; }));
  CHECK(receiver.frames[1].slots == levels);
}

TEST_CASE("of three interfaces the two selected ones are used, and the third is not") {
  if (!enter_private_network(false)) return;
  for (const char* const name : {"eth1", "eth2", "eth3"}) {
    if (!testing::add_interface(name, fmt::format("10.99.{}.1", name[3] - 0).c_str())) return;
  }
  // One listener per interface, and the port under test on two of them.
  std::vector<std::unique_ptr<SacnSource>> listeners;
  for (const char* const name : {"eth1", "eth2", "eth3"}) {
    auto options = source_options({{7, 7}});
    options.interface_names = {name};
    listeners.push_back(must(SacnSource::create(options)));
  }
  auto in = source_options({{7, 7}});
  in.interface_names = {"eth1", "eth3"};
  auto source = must(SacnSource::create(in));
  auto out = sink_options({{7, 7}});
  out.interface_names = {"eth1", "eth3"};
  auto sink = must(SacnSink::create(out));
  const auto levels = test_levels(7, 0);
  const std::vector<FrameView> frames = {frame_of(7, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  CHECK(sink->counters().frames == 1);  // one frame, two datagrams
  for (const std::size_t i : {0u, 2u}) {
    KeepingReceiver kept;
    CHECK(poll_until(*listeners[i], kStartNs, kept, [&] { return kept.frames.size() == 1; }));
  }
  KeepingReceiver kept;
  CHECK(receives_nothing(*listeners[1], kStartNs, kept));
  CHECK(poll_until(*source, kStartNs, kept, [&] { return source->details().late == 1; }));
  CHECK(kept.frames.size() == 1);  // received twice, counted once

  auto elsewhere_options = sink_options({{7, 7}});
  elsewhere_options.source_name = "elsewhere";
  elsewhere_options.interface_names = {"eth2"};
  auto elsewhere = must(SacnSink::create(elsewhere_options));
  REQUIRE(elsewhere->send(kStartNs, frames).has_value());
  CHECK(receives_nothing(*source, kStartNs, kept));

  // One of the two is removed: the other continues, and neither port is lost.
  testing::remove_interface("eth1");
  const auto changed = test_levels(7, 1);
  const std::vector<FrameView> next = {frame_of(7, changed)};
  REQUIRE(sink->send(kStartNs + kNsPerS, next).has_value());
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->counters().errors == 1);
  REQUIRE(poll_until(*source, kStartNs + kNsPerS, kept, [&] { return kept.frames.size() == 2; }));
  REQUIRE(source->poll(kStartNs + 10 * kNsPerS, kept).has_value());
  CHECK(source->state() == PortState::kWaiting);
  // It returns.
  REQUIRE(testing::add_interface("eth1", "10.99.1.1"));
  REQUIRE(testing::drain(*source, kStartNs + 10 * kNsPerS, kept));
  const auto changed_again = test_levels(7, 2);
  const std::vector<FrameView> last = {frame_of(7, changed_again)};
  REQUIRE(sink->send(kStartNs + 10 * kNsPerS, last).has_value());
  CHECK(sink->counters().errors == 1);
  const auto late_before = source->details().late;
  CHECK(poll_until(*source, kStartNs + 10 * kNsPerS, kept, [&] { return source->details().late > late_before; }));
}

TEST_CASE("on a slow network frames are replaced by the newest, and nothing waits in our queue") {
  if (!enter_private_network()) return;
  if (!testing::add_interface("eth6", "10.99.6.1") || !testing::choke_interface("eth6")) return;
  auto in = source_options({{7, 7}});
  in.interface_names = {"eth6"};
  auto source = must(SacnSource::create(in));
  auto out = sink_options({{7, 7}});
  out.interface_names = {"eth6"};
  auto sink = must(SacnSink::create(out));
  // Datagrams that the kernel accepts return to this machine at once, whenever the network sends them.
  KeepingReceiver kept;
  TimeNs now_ns = kStartNs;
  int round = 0;
  const auto send_next = [&] {
    const auto levels = test_levels(7, ++round);
    const std::vector<FrameView> frames = {frame_of(7, levels)};
    REQUIRE(sink->send(++now_ns, frames).has_value());
    REQUIRE(drain(*source, now_ns, kept));
  };
  while (round < 100'000 && sink->counters().dropped < 20) send_next();
  REQUIRE(sink->counters().dropped == 20);
  CHECK(sink->counters().errors == 0);
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->next_deadline_ns() - now_ns <= 2 * kNsPerMs);  // it soon tries again
  CHECK(static_cast<int>(kept.frames.size()) == round - 21);
  CHECK(kept.frames.back().slots != test_levels(7, round));
  testing::free_interface("eth6");
  const std::size_t before = kept.frames.size();
  now_ns = sink->next_deadline_ns();
  REQUIRE(sink->poll(now_ns).has_value());
  REQUIRE(poll_until(*source, now_ns, kept, [&] { return kept.frames.size() > before; }));
  REQUIRE(receives_nothing(*source, now_ns, kept));
  CHECK(kept.frames.size() == before + 1);
  CHECK(kept.frames.back().slots == test_levels(7, round));
  CHECK(sink->counters().frames + sink->counters().dropped == static_cast<std::uint64_t>(round));
}

TEST_CASE("a sink sends to every address of its list, and one without a route does not delay the others") {
  if (!enter_private_network()) return;
  std::vector<std::unique_ptr<SacnSource>> listeners;
  for (const char* const address : {"127.0.0.1", "127.0.0.2"}) {
    auto options = source_options({{1, 1}, {2, 2}});
    options.addresses = {address};
    listeners.push_back(must(SacnSource::create(options)));
  }
  auto both_options = source_options({{1, 1}, {2, 2}});
  both_options.addresses = {"127.0.0.3", "127.0.0.4"};
  auto both = must(SacnSource::create(both_options));
  auto out = sink_options({{1, 1}, {2, 2}});
  out.addresses = {"127.0.0.1", "127.0.0.3", "127.0.0.4", "127.0.0.2"};
  auto sink = must(SacnSink::create(out));
  const auto levels = test_levels(1, 0);
  const std::vector<FrameView> frames = {frame_of(1, levels), frame_of(2, levels)};
  REQUIRE(sink->send(kStartNs, frames).has_value());
  for (auto& listener : listeners) {
    KeepingReceiver kept;
    CHECK(poll_until(*listener, kStartNs, kept, [&] { return kept.frames.size() == 2; }));
  }
  KeepingReceiver kept;
  CHECK(poll_until(*both, kStartNs, kept, [&] { return source_count(*both) == 4; }));
  CHECK(kept.frames.size() == 2);

  if (!testing::add_interface("eth5", "10.99.5.1")) return;
  out.addresses = {"10.99.5.9", "127.0.0.1"};
  out.source_name = "Another";  // its numbers start again
  sink = must(SacnSink::create(out));
  testing::remove_interface("eth5");  // removes the route
  REQUIRE(sink->send(kStartNs, frames).has_value());
  CHECK(poll_until(*listeners[0], kStartNs, kept, [&] { return kept.frames.size() == 4; }));
  CHECK(sink->state() == PortState::kWorking);
  CHECK(sink->counters().errors == 2);  // one per universe
  CHECK(sink->counters().frames == 2);
}

TEST_CASE("wrong options are refused with a message that names the port and the next step") {
  if (!enter_private_network()) return;
  const auto message = [](const auto& result) { return result ? std::string("accepted") : result.error().message; };
  CHECK(message(SacnSource::create(source_options({}))).find("no universe is named") != std::string::npos);
  CHECK(message(SacnSource::create(source_options({{0, 1}}))).find("from 1 to 63999, got 0") != std::string::npos);
  CHECK(message(SacnSource::create(source_options({{64'000, 1}}))).find("got 64000") != std::string::npos);
  CHECK(message(SacnSource::create(source_options({{1, 1}, {1, 2}}))).find("universe 1 is named twice") !=
        std::string::npos);
  CHECK(message(SacnSource::create(source_options({{1, 5}, {2, 5}}))).find("universe 5 is named twice") !=
        std::string::npos);

  auto in = source_options({{1, 1}});
  in.interface_names = {"eht7"};
  auto refused = SacnSource::create(in);
  CHECK(message(refused) == "sacn:test-in: no network interface is called \"eht7\"; choose one of: lo");
  CHECK(refused.error().code == ErrorCode::kNotFound);
  in = source_options({{1, 1}});
  in.addresses = {"house"};
  CHECK(message(SacnSource::create(in)).find("expected an IPv4 address such as 10.0.0.5, got \"house\"") !=
        std::string::npos);
  in.addresses = {"10.1.2.3"};
  CHECK(message(SacnSource::create(in)).find("this machine does not have that address") != std::string::npos);

  auto out = sink_options({{1, 1}});
  out.priority = 201;
  CHECK(message(SacnSink::create(out)).find("expected a priority from 0 to 200, got 201") != std::string::npos);
  out = sink_options({{1, 1}});
  out.multicast_ttl = 256;
  CHECK(message(SacnSink::create(out)).find("time to live from 1 to 255, got 256") != std::string::npos);
  out = sink_options({{1, 1}});
  out.addresses = {"10.1.2.3"};
  auto unreachable = SacnSink::create(out);
  CHECK(message(unreachable).find("cannot send to 10.1.2.3") != std::string::npos);
  CHECK(message(unreachable).find("there is no route") != std::string::npos);
}

TEST_CASE("the error for a port held exclusively names the port and how to find the program") {
  if (!enter_private_network()) return;
  const Fd greedy(socket(AF_INET, SOCK_DGRAM, 0));
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_port = htons(kSacnPort);
  REQUIRE(bind(greedy.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  const auto refused = SacnSource::create(source_options({{1, 1}}));
  REQUIRE_FALSE(refused.has_value());
  CHECK(refused.error().message.find("cannot listen on UDP 0.0.0.0:5568") != std::string::npos);
  CHECK(refused.error().message.find("ss -ulpn") != std::string::npos);
}

TEST_CASE("network endpoints open their ports, and device endpoints open none") {
  if (!enter_private_network()) return;
  const auto ends = std::make_shared<OwnSenders>();
  for (const char* const text : {"sacn:101-109=1-9@127.0.0.1:5570%lo", "artnet:1-9@127.0.0.1:6460"}) {
    const auto endpoint = must(parse_endpoint(text, {}));
    auto source = must(make_net_source(endpoint, nullptr));
    auto sink = must(make_net_sink(endpoint, ends));
    CHECK(source->name() == text);
    const auto levels = test_levels(9, 0);
    const std::vector<FrameView> frames = {frame_of(9, levels)};
    REQUIRE(sink->send(kStartNs, frames).has_value());
    KeepingReceiver receiver;
    REQUIRE(poll_until(*source, kStartNs, receiver, [&] { return receiver.frames.size() == 1; }));
    CHECK(receiver.frames[0].view.universe == 9);
  }
  const auto file = must(parse_endpoint("log:show.dmxlog", {}));
  CHECK(make_net_source(file, nullptr).error().code == ErrorCode::kBadInput);
  CHECK(make_net_sink(file, nullptr).error().code == ErrorCode::kBadInput);
}

TEST_CASE("a CID depends on machine, name and endpoint, is constant, and is a UUID of version 8") {
  const Cid one = sacn_cid("machine", "Footlight", "sacn:1-9");
  CHECK(one == sacn_cid("machine", "Footlight", "sacn:1-9"));
  CHECK(one != sacn_cid("machine2", "Footlight", "sacn:1-9"));
  CHECK(one != sacn_cid("machine", "Footlight2", "sacn:1-9"));
  CHECK(one != sacn_cid("machine", "Footlight", "sacn:1-10"));
  CHECK((one[6] & 0xF0) == 0x80);
  CHECK((one[8] & 0xC0) == 0x80);
  std::set<Cid> distinct;
  for (int i = 0; i < 1'000; ++i) distinct.insert(sacn_cid("machine", "Footlight", std::to_string(i)));
  CHECK(distinct.size() == 1'000);
  SacnSinkOptions options;
  options.cid.fill(3);
  CHECK(sacn_cid_of(options) == options.cid);
}

}  // namespace footlight::drivers
