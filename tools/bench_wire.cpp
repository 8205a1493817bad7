// bench_wire: measures the latency of a bridge, and how many frames it loses.
//
//   generator --(--to)--> device under test --(--from)--> receiver
//
// The generator stamps each universe's first slots with the time and a count and sends all universes at once. The
// receiver extracts the stamp. Latency is from just before the generator's send() to the wake-up of the receiver, so it
// contains two crossings of the kernel; --floor leaves the device out and measures one crossing. The last universe of a
// round also waits until the datagrams of the others are sent.
//
//   bench_wire --floor
//   bench_wire -- footlight run --in sacn:1-9%lo --out sacn:101-109=1-9%lo
//   bench_wire --from artnet:1-9@127.0.0.1 -- footlight run --in sacn:1-9%lo --out artnet:1-9@127.0.0.1
//   bench_wire --pid 1234          a device that is already running; its processor time is read from /proc
//   bench_wire --to sacn:1-9%lo --from artnet:2-5@127.0.0.1 --pid 1234    only four of the nine are received
//   bench_wire --relay             a device of a few lines in a separate process: only the ports
//
// A frame that the device replaced by a newer one of its universe counts as lost. A bridge that never queues does this
// after a stall of more than one period, of the device or of the generator.
//
// The default endpoints are on "lo", so nothing leaves the machine. Compare medians of several runs; the worst case is
// caused by the scheduler.
#include <algorithm>
#include <atomic>
#include <cmath>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include <poll.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>
#include <CLI/CLI.hpp>

#include "drivers/net/net.h"
#include "sim/core/endpoint.h"
#include "sim/system_clock.h"

namespace footlight {
namespace {

constexpr std::size_t kStampBytes = 16;  // time in ns and count, 8 octets each, low octet first
constexpr DurationNs kWarmUpMaxNs = 5 * kNsPerS;
constexpr DurationNs kWarmUpRestNs = kNsPerS / 2;
constexpr DurationNs kDrainNs = kNsPerS / 2;

void write_u64(std::span<std::uint8_t> out, std::uint64_t value) {
  for (std::size_t i = 0; i < 8; ++i) out[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::uint64_t read_u64(std::span<const std::uint8_t> in) {
  std::uint64_t value = 0;
  for (std::size_t i = 0; i < 8; ++i) value |= std::uint64_t{in[i]} << (8 * i);
  return value;
}

// Extracts stamps from frames. Runs on the receiver's thread. The generator reads `universes_heard` meanwhile, and the
// rest after that thread has ended.
class Listener final : public FrameReceiver {
 public:
  Listener(std::span<const Universe> universes, std::size_t counts_max)
      : places_(static_cast<std::size_t>(kUniverseMax) + 1, -1),
        seen_(universes.size(), std::vector<bool>(counts_max)),
        heard_(universes.size()) {
    for (std::size_t i = 0; i < universes.size(); ++i) {
      places_[static_cast<std::size_t>(universes[i])] = static_cast<int>(i);
    }
  }

  void receive(const FrameView& frame) override {
    const int place = places_[static_cast<std::size_t>(frame.universe)];
    if (place < 0 || frame.slots.size() < kStampBytes) return;
    const std::uint64_t count = read_u64(frame.slots.subspan(8));
    auto& seen = seen_[static_cast<std::size_t>(place)];
    if (count >= seen.size()) return;
    if (seen[count]) {
      ++repeats;
      return;
    }
    if (!heard_[static_cast<std::size_t>(place)]) universes_heard.fetch_add(1);
    heard_[static_cast<std::size_t>(place)] = true;
    seen[count] = true;
    if (count < measured_from.load()) return;
    ++frames;
    latencies_ns.push_back(awake_ns - static_cast<TimeNs>(read_u64(frame.slots)));
  }

  TimeNs awake_ns = 0;
  std::atomic<std::size_t> universes_heard = 0;
  std::atomic<std::uint64_t> measured_from = UINT64_MAX;
  std::uint64_t frames = 0;
  std::uint64_t repeats = 0;
  std::vector<DurationNs> latencies_ns;

 private:
  std::vector<int> places_;  // per universe; -1: not one of ours
  std::vector<std::vector<bool>> seen_;
  std::vector<bool> heard_;
};

// Processor time of all threads of a process in ns; 0 if it cannot be read.
std::uint64_t cpu_ns_of(pid_t pid) {
  std::uint64_t sum_ns = 0;
  std::error_code error;
  const auto tasks = std::filesystem::directory_iterator(fmt::format("/proc/{}/task", pid), error);
  if (error) return 0;
  for (const auto& task : tasks) {
    std::ifstream file(task.path() / "schedstat");
    std::uint64_t on_cpu_ns = 0;
    if (file >> on_cpu_ns) sum_ns += on_cpu_ns;
  }
  return sum_ns;
}

// Resident memory of a process; 0 if it cannot be read.
std::uint64_t rss_kib_of(pid_t pid) {
  std::ifstream file(fmt::format("/proc/{}/status", pid));
  for (std::string word; file >> word;) {
    std::uint64_t kib = 0;
    if (word == "VmRSS:" && file >> kib) return kib;
  }
  return 0;
}

// The smallest bridge: sends every received frame, in batches in which no universe appears twice. (A pump would send
// only the newest frame of each universe; after a stall this program would count that as a loss.)
Status relay(Source& source, Sink& sink, Clock& clock) {
  class Collector final : public FrameReceiver {
   public:
    explicit Collector(Sink& to)
        : to_(to), slots_(to.universes().size()), is_in_(static_cast<std::size_t>(kUniverseMax) + 1) {}
    void receive(const FrameView& frame) override {
      if (frame.terminated || frame.start_code != kStartCodeLevels) return;
      if (is_in_[static_cast<std::size_t>(frame.universe)]) flush();
      is_in_[static_cast<std::size_t>(frame.universe)] = true;
      Slots& slots = slots_[batch_.size()];
      std::copy(frame.slots.begin(), frame.slots.end(), slots.begin());
      batch_.push_back(frame);
      batch_.back().slots = std::span(slots).first(frame.slots.size());
    }
    void flush() {
      if (status) status = to_.send(now_ns, batch_);
      for (const FrameView& frame : batch_) is_in_[static_cast<std::size_t>(frame.universe)] = false;
      batch_.clear();
    }
    TimeNs now_ns = 0;
    Status status;

   private:
    Sink& to_;
    std::vector<Slots> slots_;
    std::vector<bool> is_in_;
    std::vector<FrameView> batch_;
  } collector(sink);
  while (collector.status) {
    const TimeNs deadline_ns = sink.next_deadline_ns();
    const DurationNs left_ns =
        deadline_ns == kTimeNever ? kNsPerS : std::clamp<DurationNs>(deadline_ns - clock.now_ns(), 0, kNsPerS);
    pollfd waiting = {source.poll_fd(), POLLIN, 0};
    const int readable = ::poll(&waiting, 1, static_cast<int>((left_ns + kNsPerMs - 1) / kNsPerMs));
    collector.now_ns = clock.now_ns();
    if (readable == 1) FL_TRY(source.poll(collector.now_ns, collector));
    collector.flush();
    if (collector.now_ns >= sink.next_deadline_ns()) FL_TRY(sink.poll(collector.now_ns));
  }
  return collector.status;
}

// The device as a separate process, which ends with this object.
class Child {
 public:
  template <class Body>
  explicit Child(Body body) : pid_(fork()) {
    if (pid_ != 0) return;
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    body();
    _exit(127);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;
  ~Child() {
    if (pid_ <= 0) return;
    kill(pid_, SIGTERM);
    SystemClock clock;
    for (int i = 0; i < 200; ++i) {
      if (waitpid(pid_, nullptr, WNOHANG) == pid_) return;
      clock.sleep_until_ns(clock.now_ns() + 10 * kNsPerMs);
    }
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  [[nodiscard]] pid_t pid() const { return pid_; }

 private:
  pid_t pid_;
};

struct Settings {
  std::string to = "sacn:1-9%lo";
  std::string from = "sacn:101-109%lo";
  bool floor = false;
  bool use_relay = false;
  bool json = false;
  double rate_hz = 44.0;
  double seconds = 10.0;
  pid_t pid = 0;
  std::string latencies;
  std::vector<std::string> command;
};

struct Report {
  std::size_t universes = 0;
  std::uint64_t sent = 0;
  std::uint64_t received = 0;
  std::uint64_t repeats = 0;
  double seconds = 0.0;
  double cpu_percent = -1.0;             // of one core; below 0: unknown
  std::uint64_t rss_kib = 0;             // of the device, at the end
  std::vector<DurationNs> latencies_ns;  // sorted

  // Processor time of the device for each datagram that it sent.
  [[nodiscard]] double cpu_us_per_datagram() const {
    return received == 0 ? 0.0 : cpu_percent * 1e4 * seconds / static_cast<double>(received + repeats);
  }
  [[nodiscard]] double quantile_us(double q) const {
    if (latencies_ns.empty()) return 0.0;
    const auto at = static_cast<std::size_t>(std::ceil(q * static_cast<double>(latencies_ns.size())));
    return static_cast<double>(latencies_ns[std::clamp<std::size_t>(at, 1, latencies_ns.size()) - 1]) * 1e-3;
  }
};

Result<Report> measure(const Settings& settings, Source& source, Sink& sink, pid_t device) {
  SystemClock clock;
  const auto sink_universes = sink.universes();
  const auto period_ns = static_cast<DurationNs>(1e9 / settings.rate_hz);
  const auto rounds = static_cast<std::uint64_t>(settings.seconds * settings.rate_hz);
  const auto warm_up_rounds_max = static_cast<std::uint64_t>((kWarmUpMaxNs + kWarmUpRestNs) / period_ns) + 2;
  Listener listener(source.universes(), rounds + warm_up_rounds_max);
  listener.latencies_ns.reserve(rounds * source.universes().size());

  std::atomic<bool> stop = false;
  std::thread listening([&] {
    while (!stop.load()) {
      pollfd waiting = {source.poll_fd(), POLLIN, 0};
      if (::poll(&waiting, 1, 50) < 1) continue;
      listener.awake_ns = clock.now_ns();
      if (!source.poll(listener.awake_ns, listener)) return;
    }
  });
  const auto end_listening = [&] {
    stop.store(true);
    listening.join();
  };

  std::vector<Slots> slots(sink_universes.size());
  std::vector<FrameView> frames(sink_universes.size());
  for (std::size_t u = 0; u < frames.size(); ++u) {
    frames[u].universe = sink_universes[u];
    frames[u].slots = slots[u];
  }
  std::uint64_t count = 0;
  TimeNs next_ns = clock.now_ns();
  const auto send_round = [&]() -> Status {
    clock.sleep_until_ns(next_ns);
    next_ns += period_ns;
    const TimeNs now_ns = clock.now_ns();
    for (std::size_t u = 0; u < slots.size(); ++u) {
      write_u64(std::span(slots[u]).first(8), static_cast<std::uint64_t>(now_ns));
      write_u64(std::span(slots[u]).subspan(8, 8), count);
      // Some other slots change too, as in a show.
      for (std::size_t s = kStampBytes; s < slots[u].size(); s += 7)
        slots[u][s] = static_cast<std::uint8_t>(count + s + u);
    }
    ++count;
    return sink.send(now_ns, frames);
  };

  const TimeNs warm_up_end_ns = next_ns + kWarmUpMaxNs;
  Status status;
  while (status && next_ns < warm_up_end_ns && listener.universes_heard.load() < source.universes().size()) {
    status = send_round();
  }
  const TimeNs rest_end_ns = next_ns + kWarmUpRestNs;
  while (status && next_ns < rest_end_ns) status = send_round();
  if (status && listener.universes_heard.load() < source.universes().size()) {
    status = fail(ErrorCode::kTimeout,
                  "{}: {} of {} universes were received within {} s; check that the device receives {} and sends there",
                  source.name(), listener.universes_heard.load(), source.universes().size(), kWarmUpMaxNs / kNsPerS,
                  sink.name());
  }
  const std::uint64_t measured_from = count;
  listener.measured_from.store(measured_from);
  const std::uint64_t cpu_before_ns = device > 0 ? cpu_ns_of(device) : 0;
  const TimeNs begin_ns = clock.now_ns();
  for (std::uint64_t round = 0; status && round < rounds; ++round) status = send_round();
  const TimeNs end_ns = clock.now_ns();
  const std::uint64_t cpu_after_ns = device > 0 ? cpu_ns_of(device) : 0;
  const std::uint64_t rss_kib = device > 0 ? rss_kib_of(device) : 0;
  clock.sleep_until_ns(end_ns + kDrainNs);
  end_listening();
  sink.close(clock.now_ns());
  if (!status) return tl::unexpected(status.error());

  Report report;
  report.universes = source.universes().size();
  report.sent = (count - measured_from) * report.universes;
  report.received = listener.frames;
  report.repeats = listener.repeats;
  report.rss_kib = rss_kib;
  report.seconds = static_cast<double>(end_ns - begin_ns) * 1e-9;
  if (cpu_before_ns > 0 && cpu_after_ns >= cpu_before_ns) {
    report.cpu_percent = 1e-7 * static_cast<double>(cpu_after_ns - cpu_before_ns) / report.seconds;
  }
  report.latencies_ns = std::move(listener.latencies_ns);
  std::sort(report.latencies_ns.begin(), report.latencies_ns.end());
  return report;
}

void print(const Settings& settings, const Report& report) {
  const std::uint64_t lost = report.sent - std::min(report.sent, report.received);
  if (settings.json) {
    fmt::print(
        "{{\"to\": \"{}\", \"from\": \"{}\", \"universes\": {}, \"rate_hz\": {}, \"seconds\": {:.3f}, "
        "\"sent\": {}, \"received\": {}, \"lost\": {}, \"repeats\": {}, \"p50_us\": {:.1f}, \"p90_us\": {:.1f}, "
        "\"p99_us\": {:.1f}, \"max_us\": {:.1f}",
        settings.to, settings.floor ? settings.to : settings.from, report.universes, settings.rate_hz, report.seconds,
        report.sent, report.received, lost, report.repeats, report.quantile_us(0.5), report.quantile_us(0.9),
        report.quantile_us(0.99), report.quantile_us(1.0));
    if (report.cpu_percent >= 0) {
      fmt::print(", \"cpu_percent\": {:.3f}, \"cpu_us_per_datagram\": {:.3f}, \"rss_kib\": {}", report.cpu_percent,
                 report.cpu_us_per_datagram(), report.rss_kib);
    }
    fmt::print("}}\n");
    return;
  }
  fmt::print("{} to {}, {} universes at {} Hz for {:.1f} s\n", settings.to,
             settings.floor ? settings.to : settings.from, report.universes, settings.rate_hz, report.seconds);
  fmt::print("frames   {} sent, {} received, {} lost, {} repeats\n", report.sent, report.received, lost,
             report.repeats);
  fmt::print("latency  p50 {:.0f} us, p90 {:.0f} us, p99 {:.0f} us, worst {:.0f} us\n", report.quantile_us(0.5),
             report.quantile_us(0.9), report.quantile_us(0.99), report.quantile_us(1.0));
  if (report.cpu_percent >= 0) {
    fmt::print("device   {:.2f} % of one core, {:.2f} us a datagram, {} KiB resident\n", report.cpu_percent,
               report.cpu_us_per_datagram(), report.rss_kib);
  }
}

// One latency a line, in ns, the shortest first.
Status write_latencies(const std::string& path, const Report& report) {
  std::ofstream file(path);
  for (const DurationNs latency_ns : report.latencies_ns) file << latency_ns << '\n';
  file.close();
  if (!file) return fail(ErrorCode::kIo, "{}: cannot be written", path);
  return {};
}

Status run(const Settings& settings) {
  FL_ASSIGN(const Endpoint to, parse_endpoint(settings.to, {}));
  FL_ASSIGN(const Endpoint from, parse_endpoint(settings.floor ? settings.to : settings.from, {}));
  if (from.universes.size() > to.universes.size() ||
      (settings.use_relay && from.universes.size() < to.universes.size())) {
    return fail(ErrorCode::kBadInput, "{} and {} name {} and {} universes; expected {} on both sides", settings.to,
                settings.from, to.universes.size(), from.universes.size(),
                settings.use_relay ? "as many" : "no fewer on the first");
  }
  std::unique_ptr<Child> child;
  if (settings.use_relay) {
    child = std::make_unique<Child>([&] {
      // Frames on `from` have the numbers that they had on `to`.
      Endpoint out = from;
      for (std::size_t i = 0; i < out.universes.size(); ++i) out.universes[i].show = to.universes[i].show;
      out.text += " (relay)";
      SystemClock clock;
      auto source = drivers::make_net_source(to, nullptr);
      auto sink = drivers::make_net_sink(out, nullptr);
      Status status;
      if (!source) status = tl::unexpected(source.error());
      if (!sink) status = tl::unexpected(sink.error());
      if (status) status = relay(**source, **sink, clock);
      if (!status) fmt::print(stderr, "bench_wire: relay: {}\n", status.error().message);
    });
  } else if (!settings.command.empty()) {
    child = std::make_unique<Child>([&] {
      std::vector<char*> arguments;
      for (const auto& word : settings.command) arguments.push_back(const_cast<char*>(word.c_str()));
      arguments.push_back(nullptr);
      execvp(arguments[0], arguments.data());
      fmt::print(stderr, "bench_wire: cannot start {}: {}\n", settings.command[0], std::strerror(errno));
    });
  }
  FL_ASSIGN(const auto source, drivers::make_net_source(from, nullptr));
  FL_ASSIGN(const auto sink, drivers::make_net_sink(to, nullptr));
  FL_ASSIGN(const Report report, measure(settings, *source, *sink, child ? child->pid() : settings.pid));
  print(settings, report);
  return settings.latencies.empty() ? Status{} : write_latencies(settings.latencies, report);
}

}  // namespace
}  // namespace footlight

int main(int argc, char** argv) {
  footlight::Settings settings;
  CLI::App app("Measures latency, loss and processor time of a DMX bridge on the network.");
  app.add_option("--to", settings.to, "The input of the device")->capture_default_str();
  app.add_option("--from", settings.from, "The output of the device")->capture_default_str();
  app.add_option("--rate", settings.rate_hz, "Rounds per second")
      ->check(CLI::Range(0.1, 20'000.0))
      ->capture_default_str();
  app.add_option("--seconds", settings.seconds, "Duration")->check(CLI::Range(0.1, 3'600.0))->capture_default_str();
  app.add_flag("--floor", settings.floor, "Without a device: receive from the generator directly");
  app.add_flag("--relay", settings.use_relay, "Use the smallest bridge as the device");
  app.add_option("--pid", settings.pid, "The device is already running as this process");
  app.add_flag("--json", settings.json, "One line of JSON");
  app.add_option("--latencies", settings.latencies, "Write every latency to this file, in ns, one a line");
  app.add_option("command", settings.command, "After --: the command that starts the device");
  CLI11_PARSE(app, argc, argv);
  const auto status = footlight::run(settings);
  if (!status) {
    fmt::print(stderr, "bench_wire: {}\n", status.error().message);
    return 1;
  }
  return 0;
}
