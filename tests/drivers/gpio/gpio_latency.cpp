// gpio_latency [edges]: measures the time from an edge to the universe and to an sACN packet. Run it manually from an
// optimised build.
//
//   drive() -> descriptor readable -> pump wakes -> libgpiod reads -> merge -> universe -> sACN sink -> kernel of a
//   listener on "lo"
//
// It measures twice: with the real libgpiod on an emulated chip, and with the model in this process, whose descriptor
// is an eventfd. The chip and its interrupt are emulated. The emulation adds a round trip to a helper thread to every
// system call on the chip, which real hardware does not have. Not measured: the time from the voltage on the pin to the
// interrupt.
//
// Time zero is taken just before drive(). "universe": the call of the pump's first sink, which follows the write of the
// universe. "packet": the kernel's stamp of the packet's arrival on "lo".
#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <random>
#include <thread>
#include <vector>

#include <poll.h>

#include "drivers/gpio/gpio_model.h"
#include "drivers/gpio/gpio_source.h"
#include "drivers/net/net.h"
#include "drivers/wait/epoll_waiter.h"
#include "sim/core/check.h"
#include "sim/pump.h"
#include "sim/system_clock.h"
#include "tests/drivers/gpio/gpio_fs.h"
#include "tests/drivers/net/private_network.h"

namespace footlight {
namespace {

constexpr int kPatienceMs = 2'000;

// The current edge, shared by both ends.
struct Edge {
  std::atomic<TimeNs> start_ns{0};
  std::atomic<int> level{0};
  std::atomic<int> arrived_level{0};
};

// The first sink: records when it is called.
class Stopwatch final : public Sink {
 public:
  Stopwatch(Clock& clock, Edge& edge) : clock_(clock), edge_(edge) {}
  [[nodiscard]] std::string name() const override { return "stopwatch"; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {}; }
  [[nodiscard]] std::span<const Universe> universes() const override { return {&universe_, 1}; }
  Status poll(TimeNs) override { return {}; }
  void close(TimeNs) override {}
  Status send(TimeNs, std::span<const FrameView> frames) override {
    const TimeNs now_ns = clock_.now_ns();
    const int level = frames.back().slots[0];
    if (level != last_level_ && level == edge_.level) latencies_ns.push_back(now_ns - edge_.start_ns);
    last_level_ = level;
    return {};
  }
  std::vector<DurationNs> latencies_ns;

 private:
  Clock& clock_;
  Edge& edge_;
  Universe universe_ = 1;
  int last_level_ = 0;
};

class Listener final : public FrameReceiver {
 public:
  explicit Listener(Edge& edge) : edge_(edge) {}
  void receive(const FrameView& frame) override {
    if (frame.slots.empty()) return;  // the sender's final packets
    const int level = frame.slots[0];
    if (level == last_level_) return;
    last_level_ = level;
    if (level == edge_.level) latencies_ns.push_back(frame.stamp_ns - edge_.start_ns);
    edge_.arrived_level = level;
  }
  std::vector<DurationNs> latencies_ns;

 private:
  Edge& edge_;
  int last_level_ = 0;
};

void print(const char* chip, const char* what, std::vector<DurationNs> latencies_ns) {
  std::sort(latencies_ns.begin(), latencies_ns.end());
  const auto at = [&](double part) {
    const auto index = static_cast<std::size_t>(part * static_cast<double>(latencies_ns.size() - 1));
    return static_cast<double>(latencies_ns[index]) / 1e3;
  };
  if (latencies_ns.empty()) return;
  fmt::print("{:<9} {:<9} {:>6} edges  p50 {:7.1f} us  p90 {:7.1f} us  p99 {:7.1f} us  max {:8.1f} us\n", chip, what,
             latencies_ns.size(), at(0.5), at(0.9), at(0.99), at(1.0));
}

Status measure(const char* name, std::shared_ptr<drivers::GpioChips> chips, Clock& clock, int edge_count,
               const std::function<void(bool, TimeNs)>& drive) {
  Edge edge;
  drivers::GpioConfig config;
  config.chip = std::string(name) == "model" ? "mock" : "gpiochip0";
  config.lines = {"0"};
  config.strobe.hold_ns = 0;
  config.strobe.flashes_hz_max = 0;
  FL_ASSIGN(const auto source, drivers::GpioSource::open(config, std::move(chips), clock));
  drivers::SacnSinkOptions out;
  out.name = "sacn:1%lo";
  out.universes = {{1, 1}};
  out.interface_names = {"lo"};
  FL_ASSIGN(const auto sink, drivers::make_sacn_sink(out));
  drivers::SacnSourceOptions in;
  in.name = "sacn:1%lo";
  in.universes = {{1, 1}};
  in.interface_names = {"lo"};
  FL_ASSIGN(const auto ear, drivers::make_sacn_source(in));

  const std::vector<Universe> numbers = {1};
  FL_ASSIGN(const auto universes, Universes::make(numbers));
  FL_ASSIGN(const auto waiter, drivers::EpollWaiter::make());
  Stopwatch stopwatch(clock, edge);
  Listener listener(edge);
  Pump pump(*universes, clock, *waiter);
  pump.add_source(*source);
  pump.add_sink(stopwatch);
  pump.add_sink(*sink);
  std::atomic<bool> stopping{false};
  std::thread pumping([&] { pump.run(); });
  std::thread listening([&] {
    while (!stopping) {
      pollfd fd{.fd = ear->poll_fd(), .events = POLLIN, .revents = 0};
      if (::poll(&fd, 1, 20) > 0) FL_CHECK(ear->poll(clock.now_ns(), listener).has_value());
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(300));

  std::mt19937 random(1);
  int missing = 0;
  for (int i = 1; i <= edge_count; ++i) {
    std::this_thread::sleep_for(std::chrono::microseconds(std::uniform_int_distribution<>(500, 4'000)(random)));
    const bool level = i % 2 == 1;
    edge.level = level ? 255 : 0;
    const TimeNs start_ns = clock.now_ns();
    edge.start_ns = start_ns;
    drive(level, start_ns);
    const TimeNs end_ns = start_ns + kPatienceMs * kNsPerMs;
    while (edge.arrived_level != edge.level && clock.now_ns() < end_ns)
      std::this_thread::sleep_for(std::chrono::microseconds(200));
    if (edge.arrived_level != edge.level) ++missing;
  }
  stopping = true;
  pump.request_stop();
  pumping.join();
  listening.join();
  print(name, "universe", stopwatch.latencies_ns);
  print(name, "packet", listener.latencies_ns);
  if (missing != 0) fmt::print("{:<9} {} edges did not arrive\n", name, missing);
  return {};
}

Status run(int edge_count) {
  if (!testing::enter_private_network()) return fail(ErrorCode::kUnsupported, "needs a network namespace");
  SystemClock clock;
  {
    testing::Testbed testbed;
    testing::GpioFs chip(testbed, {"STROBE0"});
    FL_TRY(measure("libgpiod", drivers::make_gpio_chips(), clock, edge_count,
                   [&](bool level, TimeNs stamp_ns) { chip.drive(0, level, stamp_ns); }));
  }
  auto model = std::make_shared<drivers::mock::GpioModel>(1);
  return measure("model", drivers::mock::make_model_chips(model), clock, edge_count,
                 [&](bool level, TimeNs stamp_ns) { model->drive(0, level, stamp_ns); });
}

}  // namespace
}  // namespace footlight

int main(int argc, char** argv) {
  if (const int skip = footlight::testing::run_under_umockdev(argv); skip != 0) return skip;
  const footlight::Status status = footlight::run(argc > 1 ? std::atoi(argv[1]) : 5'000);
  if (status) return 0;
  fmt::print(stderr, "gpio_latency: {}\n", status.error().message);
  return 1;
}
