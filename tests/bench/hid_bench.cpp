// How long a frame or a report waits in the HID transport, on an emulated kernel: from Sink::send() to the report at
// the device, and from the device's report to the return of Transport::read().
//
// Prints the median, the 99th percentile and the maximum in microseconds. The emulated kernel passes each write through
// another thread, so the figures are comparable among transports and higher than on a real kernel.
#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <thread>
#include <vector>

#include "drivers/mock/hid_model.h"
#include "drivers/ports_factory.h"
#include "drivers/transport/hid_opener.h"
#include "sim/core/check.h"
#include "sim/system_clock.h"
#include "tests/support/hidraw_fs.h"
#include "tests/support/umockdev_bed.h"
#include "tests/support/usb_port_test.h"

namespace footlight::drivers {
namespace {

constexpr int kRounds = 1000;
constexpr int kWarmUpRounds = 20;

// A Nodle that notes when a block of slots arrives.
class StampingModel final : public mock::HidModel {
 public:
  explicit StampingModel(Clock& clock) : clock_(clock) {}
  void data_out(std::uint8_t, std::span<const std::uint8_t> report) override {
    if (!report.empty() && report[0] < 16) {
      stamp_ns = clock_.now_ns();
      ++block_count;
    }
  }
  void receive_line_frame(int, std::span<const std::uint8_t>, std::uint8_t) override {}
  bool listens(int) const override { return true; }

  std::atomic<TimeNs> stamp_ns{0};
  std::atomic<std::uint64_t> block_count{0};

 protected:
  Shape shape() const override { return {0x16D0, 0x0830, false, 0x02, 0x81, 33}; }

 private:
  Clock& clock_;
};

struct Bed {
  SystemClock clock;
  testing::Testbed testbed;
  StampingModel model{clock};
  testing::HidSocket socket{testbed, model};
  Bed() {
    model.serial = "A0042";
    socket.plug();
  }
};

// Rounds begin at times without a period of their own, as frames of a console do.
void pause(Clock& clock, int round) { clock.sleep_until_ns(clock.now_ns() + (2 + round * 7 % 11) * kNsPerMs); }

void print(const char* what, std::vector<DurationNs> took_ns) {
  took_ns.erase(took_ns.begin(), took_ns.begin() + kWarmUpRounds);
  std::sort(took_ns.begin(), took_ns.end());
  const auto us = [&](std::size_t percent) {
    return static_cast<double>(took_ns[std::min(took_ns.size() - 1, took_ns.size() * percent / 100)]) * 1e-3;
  };
  std::printf("%-42s p50 %8.1f us   p99 %8.1f us   max %8.1f us   n %zu\n", what, us(50), us(99), us(100),
              took_ns.size());
}

void measure_output(bool with_input) {
  Bed bed;
  const PortRequest request{.scheme = "nodle", .target = "", .universes = {1}};
  auto sink = open_sink(request, bed.clock);
  FL_CHECK(sink);
  std::unique_ptr<Source> source;
  if (with_input) {
    auto opened = open_source(request, bed.clock);
    FL_CHECK(opened);
    source = std::move(*opened);
  }
  testing::Snapshot slots(512);
  std::vector<DurationNs> took_ns;
  for (int round = 0; round < kRounds; ++round) {
    pause(bed.clock, round);
    slots[0] = static_cast<std::uint8_t>(round + 1);
    const std::uint64_t before = bed.model.block_count;
    const FrameView frame{.universe = 1, .slots = slots};
    const TimeNs sent_ns = bed.clock.now_ns();
    FL_CHECK((*sink)->send(sent_ns, {&frame, 1}));
    FL_CHECK(bed.socket.wait_for([&] { return bed.model.block_count > before; }));
    took_ns.push_back(bed.model.stamp_ns - sent_ns);
  }
  print(with_input ? "frame to report, input in use" : "frame to report, output only", std::move(took_ns));
}

void measure_input() {
  Bed bed;
  auto opener = make_hid_opener({.driver_id = "nodle", .target = ""}, bed.clock);
  FL_CHECK(opener);
  auto transport = (*opener)->connect();
  FL_CHECK(transport);
  std::atomic<TimeNs> said_ns{0};
  std::atomic<int> read_count{0};
  std::vector<DurationNs> took_ns;
  std::jthread reader([&] {
    std::array<std::uint8_t, 65> report{};
    while (took_ns.size() < kRounds) {
      const auto size = (*transport)->read(report, bed.clock.now_ns() + kNsPerS);
      FL_CHECK(size);
      if (*size == 0) continue;
      took_ns.push_back(bed.clock.now_ns() - said_ns);
      ++read_count;
    }
  });
  for (int round = 0; round < kRounds; ++round) {
    pause(bed.clock, round);
    const std::array<std::uint8_t, 33> report{};
    bed.socket.with_model([&] {
      bed.model.send_to_host(report);
      said_ns = bed.clock.now_ns();
    });
    while (read_count <= round) bed.clock.sleep_until_ns(bed.clock.now_ns() + kNsPerMs);
  }
  reader.join();
  print("report to read()", std::move(took_ns));
}

}  // namespace
}  // namespace footlight::drivers

int main(int, char** argv) {
  if (const int skipped = footlight::testing::run_under_umockdev(argv)) return skipped;
  footlight::drivers::measure_output(false);
  footlight::drivers::measure_output(true);
  footlight::drivers::measure_input();
}
