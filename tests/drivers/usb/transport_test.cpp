// The transports between drivers and devices: two transports for one device, and the faults that a model simulates on
// command.
#include <doctest/doctest.h>

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/mock/enttec_pro_model.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/transport/either_opener.h"
#include "tests/support/usb_shared_clock.h"

namespace footlight::drivers {
namespace {

using mock::MockUsb;
using testing::SharedFakeClock;
using Bytes = std::vector<std::uint8_t>;

class NamedTransport final : public Transport {
 public:
  explicit NamedTransport(std::string where) : where_(std::move(where)) {}
  std::string where() const override { return where_; }
  std::string serial() const override { return {}; }
  Status wait(TimeNs) override { return {}; }
  Status write(std::span<const std::uint8_t>, TimeNs) override { return {}; }
  Result<std::size_t> read(std::span<std::uint8_t>, TimeNs) override { return 0; }

 private:
  const std::string where_;
};

// How often the wait() of a transport was called.
int& waits_of(const std::string& name) {
  static std::map<std::string, int> waits;
  return waits[name];
}

// kOk: connects; otherwise fails with this.
enum class Way { kOk, kPermission, kUnsupported, kNotFound, kIo, kDisconnected };

// outcome: read at each connect().
std::unique_ptr<Opener> way(std::string name, const Way& outcome, int& tries) {
  class Fixed final : public Opener {
   public:
    Fixed(std::string name, const Way& outcome, int& tries)
        : name_(std::move(name)), outcome_(outcome), tries_(tries) {}
    Result<std::unique_ptr<Transport>> connect() override {
      ++tries_;
      switch (outcome_) {
        case Way::kOk: return std::make_unique<NamedTransport>(name_);
        case Way::kPermission: return fail(ErrorCode::kPermission, "{}", name_);
        case Way::kUnsupported: return fail(ErrorCode::kUnsupported, "{}", name_);
        case Way::kNotFound: return fail(ErrorCode::kNotFound, "{}", name_);
        case Way::kIo: return fail(ErrorCode::kIo, "{}", name_);
        case Way::kDisconnected: break;
      }
      return fail(ErrorCode::kDisconnected, "{}", name_);
    }
    void wait(TimeNs) override { ++waits_of(name_); }
    void wake() override {}
    std::string identity() override { return name_; }
    void abort() override {}

   private:
    const std::string name_;
    const Way& outcome_;
    int& tries_;
  };
  return std::make_unique<Fixed>(std::move(name), outcome, tries);
}

TEST_SUITE_BEGIN("transport");

TEST_CASE("a device that its first transport may not open uses the second, and one with another error does not") {
  for (const Way first :
       {Way::kOk, Way::kPermission, Way::kUnsupported, Way::kNotFound, Way::kIo, Way::kDisconnected}) {
    CAPTURE(static_cast<int>(first));
    const bool barred = first == Way::kPermission || first == Way::kUnsupported || first == Way::kNotFound;
    constexpr Way kOk = Way::kOk, kIo = Way::kIo;
    int first_tries = 0, second_tries = 0;
    SharedFakeClock clock;
    const auto look = [] { return SeenDevice{TransportKind::kFtdi, "/dev/bus/usb/001/004"}; };
    const auto works =
        make_either_opener(way("libusb", first, first_tries), way("tty", kOk, second_tries), look, clock);
    const auto transport = works->connect();
    CHECK(first_tries == 1);
    CHECK(second_tries == (barred ? 1 : 0));
    CHECK(transport.has_value() == (first == Way::kOk || barred));
    if (transport) CHECK((*transport)->where() == (barred ? "tty" : "libusb"));
    // If both fail, the message is that of the preferred transport.
    const auto fails =
        make_either_opener(way("libusb", first, first_tries), way("tty", kIo, second_tries), look, clock);
    const auto none = fails->connect();
    if (first != Way::kOk) CHECK(none.error().message == "libusb");
  }
}

// An opener with both transports, and the results that the test sets for them.
struct BothWays {
  SharedFakeClock clock;
  Way over_libusb = Way::kOk, over_tty = Way::kOk;
  std::optional<SeenDevice> seen;
  int libusb_tries = 0, tty_tries = 0;
  std::unique_ptr<Opener> opener = make_either_opener(
      way("libusb", over_libusb, libusb_tries), way("tty", over_tty, tty_tries), [this] { return seen; }, clock);
  // The transport used; empty: none.
  std::string taken() {
    const auto transport = opener->connect();
    return transport ? (*transport)->where() : std::string{};
  }
  void plug(std::string node, TransportKind kind = TransportKind::kFtdi) { seen = SeenDevice{kind, std::move(node)}; }
};

TEST_CASE("a replugged chip is reserved for libusb for one second, and opened by its tty after that") {
  for (const Way late : {Way::kNotFound, Way::kPermission}) {  // no event yet; its node has no permissions yet
    BothWays ways;
    ways.plug("/dev/bus/usb/001/004");
    CHECK(ways.taken() == "libusb");
    ways.plug("/dev/bus/usb/001/005");
    ways.over_libusb = late;
    CHECK(ways.taken().empty());
    ways.clock.advance_ns(kAnnouncementNs - 1);
    CHECK(ways.taken().empty());
    CHECK(ways.tty_tries == 0);
    SUBCASE("libusb reports it in time") {
      ways.over_libusb = Way::kOk;
      CHECK(ways.taken() == "libusb");
    }
    SUBCASE("libusb never reports it") {
      ways.clock.advance_ns(1);
      CHECK(ways.taken() == "tty");
      // After the next replug libusb comes first again.
      ways.plug("/dev/bus/usb/001/006");
      CHECK(ways.taken().empty());
      ways.over_libusb = Way::kOk;
      CHECK(ways.taken() == "libusb");
    }
  }
}

TEST_CASE("a chip plugged in after the start is reserved for libusb for one second too") {
  BothWays ways;
  ways.over_libusb = Way::kNotFound;
  CHECK(ways.taken().empty());
  CHECK(ways.tty_tries == 0);  // nothing is there
  ways.clock.advance_ns(3600 * kNsPerS);
  ways.plug("/dev/bus/usb/001/004");
  CHECK(ways.taken().empty());
  CHECK(ways.tty_tries == 0);
  ways.clock.advance_ns(kAnnouncementNs);
  CHECK(ways.taken() == "tty");
}

TEST_CASE("a serial device plugged in after the start is opened and waited for by its tty") {
  BothWays ways;
  ways.over_libusb = Way::kNotFound;
  ways.over_tty = Way::kNotFound;
  CHECK(ways.taken().empty());
  const int libusb_waits = waits_of("libusb"), tty_waits = waits_of("tty");
  ways.opener->wait(0);
  CHECK(waits_of("libusb") == libusb_waits + 1);  // which gets events of every USB device
  ways.plug("/dev/bus/usb/001/004", TransportKind::kTty);
  ways.over_libusb = Way::kOk;  // libusb opens it, but not as a serial line
  CHECK(ways.taken().empty());  // its tty appears later
  ways.opener->wait(0);
  CHECK(waits_of("tty") == tty_waits + 1);
  ways.over_tty = Way::kOk;
  CHECK(ways.taken() == "tty");
  CHECK(ways.libusb_tries == 1);
}

// A widget without its thread.
struct Bench {
  SharedFakeClock clock;
  std::shared_ptr<MockUsb> usb = std::make_shared<MockUsb>(std::make_unique<mock::EnttecProModel>(), "mock:enttec-pro");
  std::unique_ptr<Opener> opener = mock::make_mock_opener(usb, clock);
  std::unique_ptr<Transport> transport;

  Bench() { REQUIRE(connect() == "connected"); }
  std::string connect() {
    transport.reset();
    auto opened = opener->connect();
    if (!opened) return opened.error().message;
    transport = std::move(*opened);
    return "connected";
  }
  // With an expired deadline: calls that need time time out at once.
  Status write(std::size_t byte_count) { return transport->write(Bytes(byte_count), clock.now_ns()); }
  Bytes read() {
    Bytes bytes(64);
    const auto count = transport->read(bytes, clock.now_ns());
    REQUIRE(count.has_value());
    bytes.resize(*count);
    return bytes;
  }
};

TEST_CASE("every fault of a model happens on its command") {
  Bench bench;
  MockUsb& usb = *bench.usb;
  REQUIRE(bench.write(10).has_value());

  REQUIRE(usb.obey("garbage 7E00FF"));
  CHECK(bench.read() == Bytes{0x7E, 0x00, 0xFF});
  REQUIRE(usb.obey("limit-reads 2"));
  REQUIRE(usb.obey("garbage 010203"));
  CHECK(bench.read() == Bytes{1, 2});
  CHECK(bench.read() == Bytes{3});
  REQUIRE(usb.obey("limit-reads 0"));

  REQUIRE(usb.obey("slow 300"));
  REQUIRE(usb.obey("garbage 0A"));
  CHECK(bench.read().empty());
  bench.clock.advance_ns(299 * kNsPerMs);
  CHECK(bench.read().empty());
  bench.clock.advance_ns(kNsPerMs);
  CHECK(bench.read() == Bytes{0x0A});
  REQUIRE(usb.obey("slow 0"));

  REQUIRE(usb.obey("cut-write 4"));
  CHECK(bench.write(10).error().code == ErrorCode::kTimeout);
  CHECK(bench.write(10).has_value());  // only that one write

  REQUIRE(usb.obey("stall on"));
  CHECK(bench.write(10).error().code == ErrorCode::kTimeout);
  CHECK(bench.write(10).error().code == ErrorCode::kTimeout);
  REQUIRE(usb.obey("stall off"));
  CHECK(bench.write(10).has_value());

  REQUIRE(usb.obey("unplug-after 3"));
  CHECK(bench.write(3).has_value());
  CHECK(bench.write(4).error().code == ErrorCode::kDisconnected);
  CHECK(bench.connect().find("not plugged in") != std::string::npos);
  REQUIRE(usb.obey("plug"));
  CHECK(bench.connect() == "connected");

  REQUIRE(usb.obey("unplug"));
  CHECK(bench.write(1).error().code == ErrorCode::kDisconnected);
  REQUIRE(usb.obey("serial EN999999"));
  REQUIRE(usb.obey("plug"));
  CHECK(bench.connect().find("EN999999") != std::string::npos);  // another device, not accepted
  REQUIRE(usb.obey("unplug"));
  REQUIRE(usb.obey("serial EN172589"));
  REQUIRE(usb.obey("plug"));
  CHECK(bench.connect() == "connected");
}

TEST_SUITE_END();

}  // namespace
}  // namespace footlight::drivers
