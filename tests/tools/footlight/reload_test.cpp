// A show that changes while it runs: in this process with models of devices, and through the command with signals.
#include <algorithm>
#include <array>
#include <csignal>
#include <fstream>
#include <thread>

#include <poll.h>

#include <doctest/doctest.h>

#include "drivers/mock/mock_usb.h"
#include "drivers/net/net.h"
#include "drivers/wait/epoll_waiter.h"
#include "sim/system_clock.h"
#include "tests/drivers/net/port_helpers.h"
#include "tests/drivers/net/private_network.h"
#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/bridge/live_show.h"

namespace footlight::tools {
namespace {

using testing::Footlight;
using testing::TempFolder;

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

Show show_of(const std::string& text) {
  auto show = parse_show(text, "show.toml");
  REQUIRE_MESSAGE(show.has_value(), (show ? "" : show.error().message));
  return std::move(*show);
}

std::string in(const std::string& endpoint) { return "[[in]]\nendpoint = \"" + endpoint + "\"\n"; }
std::string out(const std::string& endpoint, const std::string& more = "") {
  return "[[out]]\nendpoint = \"" + endpoint + "\"\n" + more;
}

// A live show on a pump with its own thread.
class Running {
 public:
  explicit Running(const std::string& text) : live(clock) {
    const Status opened = live.open(show_of(text));
    REQUIRE_MESSAGE(opened.has_value(), (opened ? "" : opened.error().message));
    waiter = std::move(*drivers::EpollWaiter::make());
    PumpOptions options;
    options.on_notice = [this](const Notice& notice) {
      const std::lock_guard lock(mutex);
      notice_ids.emplace_back(notice.id);
    };
    pump = std::make_unique<Pump>(live.buffer(), clock, *waiter, options);
    live.add_to(*pump);
    thread = std::thread([this] { pump->run(); });
  }
  ~Running() {
    pump->request_stop();
    thread.join();
  }
  Result<ShowChange> change(const std::string& text) {
    return live.change_to(show_of(text), *pump, [] { return false; });
  }
  ShowChange must_change(const std::string& text) {
    const auto change_made = change(text);
    REQUIRE_MESSAGE(change_made.has_value(), (change_made ? "" : change_made.error().message));
    return *change_made;
  }

  SystemClock clock;
  LiveShow live;
  std::unique_ptr<drivers::EpollWaiter> waiter;
  std::unique_ptr<Pump> pump;
  std::mutex mutex;
  std::vector<std::string> notice_ids;  // guarded by mutex
  std::thread thread;
};

std::shared_ptr<drivers::mock::MockUsb> dongle(const std::string& name) {
  auto target = drivers::mock::mock_of_target("enttec-pro/" + name, true);
  REQUIRE(target.has_value());
  return target->usb;
}

// Waits until the model has received this many more frames than now.
bool gets_frames(drivers::mock::MockUsb& usb, std::uint64_t count) {
  using Model = drivers::mock::UsbModel;
  const auto before = usb.with_model<Model>([](Model& model) { return model.line(0).frame_count; });
  return usb.wait_for<Model>([&](const Model& model) { return model.line(0).frame_count >= before + count; });
}

TEST_CASE("ports with unchanged lines are the same objects after a change, and are never closed") {
  Running run(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/a=1") + out("mock:enttec-pro/b=1"));
  const auto before = run.live.sinks();
  const auto sources_before = run.live.sources();
  const auto a = dongle("a");
  CHECK(gets_frames(*a, 3));
  const ShowChange change =
      run.must_change(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/c=1") + out("mock:enttec-pro/a=1"));
  CHECK(change.kept == 2);
  CHECK(change.opened == 1);
  CHECK(change.closed == 1);
  CHECK(run.live.sources() == sources_before);
  CHECK(run.live.sinks()[1] == before[0]);
  CHECK(a->claimed());
  CHECK(gets_frames(*a, 3));
  CHECK(gets_frames(*dongle("c"), 3));
  CHECK(dongle("b")->wait_for_claim(false));
}

TEST_CASE("a change that fails has no effect") {
  Running run(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/d=1"));
  const auto before = run.live.sinks();
  const auto refused = run.change(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/e=1") + out("enttec-pro:NOSUCH=1"));
  REQUIRE_FALSE(refused.has_value());
  CHECK(contains(refused.error().message, "NOSUCH"));
  CHECK(run.live.sinks() == before);
  CHECK(gets_frames(*dongle("d"), 3));
  CHECK(dongle("e")->wait_for_claim(false));
  const auto ltp = run.change("[merge]\nltp = [9]\n" + in("mock:enttec-pro/in=1") + out("mock:enttec-pro/d=1"));
  REQUIRE_FALSE(ltp.has_value());
  CHECK(contains(ltp.error().message, "universe 9"));
}

TEST_CASE("a change that the pump has not started before it stops is cancelled, and does not happen later") {
  SystemClock clock;
  LiveShow live(clock);
  REQUIRE(live.open(show_of(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/stays=1"))).has_value());
  const auto waiter = std::move(*drivers::EpollWaiter::make());
  Pump pump(live.buffer(), clock, *waiter, {});
  live.add_to(pump);
  const auto before = live.sinks();
  // The pump does not run yet.
  const auto stopped =
      live.change_to(show_of(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/never=1")), pump, [] { return true; });
  REQUIRE_FALSE(stopped.has_value());
  CHECK(stopped.error().code == ErrorCode::kTimeout);
  std::thread thread([&] { pump.run(); });
  CHECK(gets_frames(*dongle("stays"), 3));
  pump.request_stop();
  thread.join();
  CHECK(live.sinks() == before);
  CHECK(dongle("never")->wait_for_claim(false));
}

TEST_CASE("universes may be added and removed, a snapshot stays while its universe does") {
  Running run(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/f=1"));
  CHECK(gets_frames(*dongle("f"), 3));
  run.must_change("universes = 40\n[merge]\nltp = [1, 30]\n" + in("mock:enttec-pro/in=1") + out("mock:enttec-pro/f=1") +
                  out("mock:enttec-pro/g=1"));
  CHECK(run.pump->universes()->count() == 40);
  CHECK(gets_frames(*dongle("f"), 3));
  CHECK(gets_frames(*dongle("g"), 3));
  run.must_change(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/f=1"));
  CHECK(run.pump->universes()->count() == 1);
  CHECK(gets_frames(*dongle("f"), 3));
}

TEST_CASE("a device that gets another universe is closed and opened again") {
  Running run(in("mock:enttec-pro/in=2") + out("mock:enttec-pro/h=1"));
  const ShowChange change = run.must_change(in("mock:enttec-pro/in=2") + out("mock:enttec-pro/h=2"));
  CHECK(change.kept == 1);
  CHECK(change.troubles.empty());
  CHECK(gets_frames(*dongle("h"), 3));
}

TEST_CASE("a standby output takes over when the main output is unplugged, and stops when it is back") {
  Running run(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/k=1") +
              out("mock:enttec-pro/l=1", "standby_for = \"mock:enttec-pro/k=1\"\n"));
  const auto first = dongle("k");
  const auto second = dongle("l");
  CHECK(gets_frames(*first, 3));
  REQUIRE(first->obey("unplug").has_value());
  CHECK(gets_frames(*second, 3));
  REQUIRE(first->obey("plug").has_value());
  CHECK(gets_frames(*first, 3));
  // The standby stays a standby after a change; a change may also swap the roles.
  run.must_change(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/k=1") +
                  out("mock:enttec-pro/l=1", "standby_for = \"mock:enttec-pro/k=1\"\n") + out("mock:enttec-pro/m=1"));
  REQUIRE(first->obey("unplug").has_value());
  CHECK(gets_frames(*second, 3));
  REQUIRE(first->obey("plug").has_value());
  CHECK(gets_frames(*first, 3));
  run.must_change(in("mock:enttec-pro/in=1") + out("mock:enttec-pro/k=1") + out("mock:enttec-pro/l=1"));
  CHECK(gets_frames(*second, 3));
}

// Writes the file as an editor does: a new file replaces the old one.
void write_show(const TempFolder& folder, const std::string& text) {
  std::ofstream(folder.file("new.toml")) << text;
  std::filesystem::rename(folder.file("new.toml"), folder.file("show.toml"));
}

TEST_CASE("SIGHUP reads the show file again, a wrong file is reported and changes nothing") {
  const TempFolder folder;
  const std::string one = in("mock:enttec-pro=1") + out("mock:enttec-pro=1");
  write_show(folder, one);
  Footlight bridge({"run", folder.file("show.toml"), "--json", "--socket", folder.file("b.sock")});
  bridge.wait_for(R"("event":"ready")");
  write_show(folder, one + out("mock:enttec-pro/other=1"));
  bridge.signal(SIGHUP);
  bridge.wait_for("1 ports opened, 0 closed, 2 unchanged");
  write_show(folder, one + "priorty = 5\n");
  bridge.signal(SIGHUP);
  bridge.wait_for("show.toml:5:");
  // The same through the socket.
  const auto refused = testing::footlight({"reload", "--socket", folder.file("b.sock")});
  CHECK(refused.exit_code == 2);
  CHECK(contains(refused.err, "priorty"));
  write_show(folder, one);
  CHECK(testing::footlight({"reload", "--socket", folder.file("b.sock")}).exit_code == 0);
  bridge.wait_for("0 ports opened, 1 closed, 2 unchanged");
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

TEST_CASE("a bridge without a show file reports that it cannot reload, and continues") {
  const TempFolder folder;
  Footlight bridge(
      {"run", "--in", "mock:enttec-pro", "--out", "mock:enttec-pro", "--json", "--socket", folder.file("b.sock")});
  bridge.wait_for(R"("event":"ready")");
  bridge.signal(SIGHUP);
  bridge.wait_for(R"("id":"reload-refused")");
  CHECK(testing::footlight({"reload", "--socket", folder.file("b.sock")}).exit_code == 1);
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

// A head of 14 slots in universe 1; the first four are pan and tilt, the next two its dimmer.
void write_rig(const TempFolder& folder, Address address) {
  std::ofstream(folder.file("rig.toml")) << "[rig]\nname = \"one\"\n[[fixture]]\nname = \"head\"\n"
                                            "type = \"generic/profile\"\nuniverse = 1\nposition = [0, 0, 5]\naddress = "
                                         << address << "\n";
}

// Each round is nine universes whose first slots count; the next round is sent after all nine have arrived.
class Rounds {
 public:
  Rounds() {
    drivers::SacnSinkOptions sink;
    sink.name = "sacn:1-9%lo";
    drivers::SacnSourceOptions source;
    source.name = "sacn:101-109%lo";
    for (Universe universe = 1; universe <= 9; ++universe) {
      sink.universes.push_back({universe, universe});
      source.universes.push_back({universe + 100, universe});
    }
    sink.interface_names = {"lo"};
    source.interface_names = {"lo"};
    auto to = drivers::make_sacn_sink(sink);
    auto from = drivers::make_sacn_source(source);
    REQUIRE(to.has_value());
    REQUIRE(from.has_value());
    to_ = std::move(*to);
    from_ = std::move(*from);
  }

  // False: not all arrived. Sends again until they do, up to `tries` times.
  bool round(int tries = 1) {
    ++count_;
    Slots slots{};
    for (std::size_t i = 0; i < 8; ++i) slots[i] = static_cast<std::uint8_t>(count_ >> (8 * i));
    std::vector<FrameView> frames(9);
    for (std::size_t i = 0; i < frames.size(); ++i) {
      frames[i].universe = static_cast<Universe>(i + 1);
      frames[i].slots = slots;
    }
    for (int i = 0; i < tries; ++i) {
      if (!to_->send(clock_.now_ns(), frames)) return false;
      testing::KeepingReceiver receiver;
      std::uint32_t received = 0;
      const auto all = [&] {
        for (const testing::KeptFrame& frame : receiver.frames) {
          const bool same =
              frame.slots.size() >= 8 && std::equal(slots.begin(), slots.begin() + 8, frame.slots.begin());
          if (same) received |= 1u << frame.view.universe;
        }
        receiver.frames.clear();
        return received == 0x3FEu;
      };
      if (testing::poll_until(*from_, clock_.now_ns(), receiver, all)) return true;
    }
    return false;
  }
  [[nodiscard]] std::uint64_t count() const { return count_; }

 private:
  SystemClock clock_;
  std::unique_ptr<Sink> to_;
  std::unique_ptr<Source> from_;
  std::uint64_t count_ = 0;
};

TEST_CASE("fifty reloads drop no frame of unchanged ports with nine universes sent without a pause") {
  if (!testing::enter_private_network()) return;
  const TempFolder folder;
  const std::string stays = in("sacn:1-9%lo") + out("sacn:101-109=1-9%lo");
  const std::string shows[] = {
      stays,
      stays + out("mock:enttec-pro=3") + in("artnet:20%lo"),
      "universes = 100\n[merge]\nltp = [1, 2]\n" + stays + out("sacn:201-220=1-20%lo"),
      stays + out("sacn:201-209=1-9%lo", "priority = 50\n"),
      "[merge]\nltp_rig = \"rig.toml\"\n" + stays,
  };
  write_show(folder, stays);
  Footlight bridge({"run", folder.file("show.toml"), "--json", "--socket", "none"});
  bridge.wait_for(R"("event":"ready")");
  Rounds rounds;
  REQUIRE(rounds.round(10));  // until the merge has the sender
  for (int reload = 1; reload <= 50; ++reload) {
    CAPTURE(reload);
    write_rig(folder, 1 + reload);
    write_show(folder, shows[reload % 5]);
    bridge.signal(SIGHUP);
    const std::string done = R"("id":"reloaded")";
    do {
      REQUIRE(rounds.round());
    } while (!bridge.has_printed(done, reload));
  }
  MESSAGE(rounds.count(), " rounds of 9 frames");
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

// Two consoles that differ in every slot of universe 1 and repeat their levels as consoles do, and the output of a
// bridge on universe 101.
class TwoDesks {
 public:
  TwoDesks() {
    drivers::SacnSourceOptions source;
    source.name = "sacn:101%lo";
    source.universes = {{101, 1}};
    source.interface_names = {"lo"};
    auto from = drivers::make_sacn_source(source);
    REQUIRE(from.has_value());
    from_ = std::move(*from);
    for (std::size_t desk = 0; desk < desks_.size(); ++desk) {
      drivers::SacnSinkOptions sink;
      sink.name = "sacn:1%lo";
      sink.universes = {{1, 1}};
      sink.interface_names = {"lo"};
      sink.cid[0] = static_cast<std::uint8_t>(1 + desk);
      auto to = drivers::make_sacn_sink(sink);
      REQUIRE(to.has_value());
      desks_[desk] = std::move(*to);
    }
  }

  void set(std::size_t desk, std::uint8_t level) {
    const std::vector<std::uint8_t> slots(kSlotCountMax, level);
    FrameView frame;
    frame.universe = 1;
    frame.slots = slots;
    REQUIRE(desks_[desk]->send(clock_.now_ns(), {&frame, 1}).has_value());
  }
  // Waits until these addresses have these levels.
  bool shows(const std::vector<std::pair<Address, std::uint8_t>>& expected) {
    testing::KeepingReceiver receiver;
    return testing::poll_until(*from_, clock_.now_ns(), receiver, [&] {
      for (const auto& desk : desks_) REQUIRE(desk->poll(clock_.now_ns()).has_value());
      if (receiver.frames.empty()) return false;
      const auto& slots = receiver.frames.back().slots;
      return std::all_of(expected.begin(), expected.end(), [&](const auto& one) {
        return slots[static_cast<std::size_t>(slot_of_address(one.first))] == one.second;
      });
    });
  }

 private:
  SystemClock clock_;
  std::unique_ptr<Source> from_;
  std::array<std::unique_ptr<Sink>, 2> desks_;
};

TEST_CASE("a reload that changes a rig changes its LTP slots at once, and one without a rig has none") {
  if (!testing::enter_private_network()) return;
  const TempFolder folder;
  const std::string ports = in("sacn:1%lo") + out("sacn:101=1%lo");
  write_rig(folder, 1);
  write_show(folder, "[merge]\nltp_rig = \"rig.toml\"\n" + ports);
  Footlight bridge({"run", folder.file("show.toml"), "--json", "--socket", "none"});
  bridge.wait_for(R"("event":"ready")");
  TwoDesks desks;
  desks.set(0, 200);
  REQUIRE(desks.shows({{1, 200}}));
  desks.set(1, 100);
  CHECK(desks.shows({{1, 100}, {5, 200}, {101, 200}}));  // pan: the latest; dimmer and elsewhere: the highest
  write_rig(folder, 101);
  bridge.signal(SIGHUP);
  bridge.wait_for(R"("id":"reloaded")");
  // No console changes anything.
  CHECK(desks.shows({{1, 200}, {5, 200}, {101, 100}, {105, 200}}));
  desks.set(0, 150);
  CHECK(desks.shows({{1, 150}, {101, 150}, {105, 150}}));
  desks.set(1, 120);
  CHECK(desks.shows({{1, 150}, {101, 120}, {105, 150}}));
  write_show(folder, ports);
  bridge.signal(SIGHUP);
  CHECK(desks.shows({{1, 150}, {101, 150}}));
  bridge.signal(SIGTERM);
  CHECK(bridge.wait().exit_code == 0);
}

}  // namespace
}  // namespace footlight::tools
