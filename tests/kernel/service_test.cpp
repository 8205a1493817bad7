// The unit as installed, under the systemd that is this machine's first process.
#include <csignal>
#include <fstream>
#include <sstream>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "drivers/mock/eurolite_model.h"
#include "drivers/net/artnet_packet.h"
#include "tests/kernel/guest.h"
#include "tests/kernel/vhci_socket.h"
#include "tests/support/usb_port_test.h"

namespace footlight::testing {
namespace {

std::string property(const std::string& name) {
  std::string text = must_shell("systemctl show --value -p " + name + " footlight");
  while (!text.empty() && text.back() == '\n') text.pop_back();
  return text;
}

// ArtDmx by unicast to this machine, from its own address ("127.0.0.5").
void send_artnet(const std::string& from, int wire_universe, const Snapshot& snapshot) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  REQUIRE(fd >= 0);
  sockaddr_in address{};
  address.sin_family = AF_INET;
  REQUIRE(::inet_pton(AF_INET, from.c_str(), &address.sin_addr) == 1);
  REQUIRE(::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  address.sin_port = htons(drivers::kArtnetPort);
  REQUIRE(::inet_pton(AF_INET, "127.0.0.1", &address.sin_addr) == 1);
  std::uint8_t packet[drivers::kArtnetDmxBytesMax];
  const std::size_t size = drivers::build_artnet_dmx(
      {.port_address = drivers::artnet_port_address(wire_universe), .slots = snapshot}, packet);
  CHECK(::sendto(fd, packet, size, 0, reinterpret_cast<const sockaddr*>(&address), sizeof address) ==
        static_cast<ssize_t>(size));
  ::close(fd);
}

// The service with a show file from an Art-Net universe to a plugged-in device; stopped in the destructor.
class Service {
 public:
  Service() {
    set_up_well();
    socket_.plug();
    (void)socket_.port_path();
    must_shell("udevadm settle; mkdir -p /etc/footlight; systemctl reset-failed footlight 2> /dev/null || :");
    show(1);
    must_shell("systemctl start footlight");
  }
  ~Service() { shell("systemctl stop footlight"); }
  Service(const Service&) = delete;
  Service& operator=(const Service&) = delete;

  static void show(int wire_universe) {
    std::ofstream("/etc/footlight/show.toml")
        << fmt::format("[[in]]\nendpoint = \"artnet:{}=1\"\n[[out]]\nendpoint = \"eurolite-pro\"\n", wire_universe);
  }
  // Sends the snapshot until it is on the device's line.
  bool shows(const std::string& from, int wire_universe, const Snapshot& snapshot) {
    const auto shown = [&] { return model_.line(0).frame == line_frame_of(snapshot); };
    return eventually([&] {
      send_artnet(from, wire_universe, snapshot);
      return socket_.wait_for(shown, std::chrono::milliseconds(200));
    });
  }
  // Sends it once.
  bool shows_at_once(const std::string& from, int wire_universe, const Snapshot& snapshot) {
    send_artnet(from, wire_universe, snapshot);
    return socket_.wait_for([&] { return model_.line(0).frame == line_frame_of(snapshot); }, kPatience);
  }

 private:
  drivers::mock::EuroliteModel model_;
  VhciSocket socket_{model_};
};

TEST_CASE("systemd starts the unit, the unit reports ready, and it drives a USB device from its sandbox") {
  Service service;
  CHECK(property("ActiveState") == "active");
  CHECK(property("Type") == "notify");  // so systemctl start has waited for READY=1
  CHECK(service.shows("127.0.0.1", 1, some_snapshot(3)));
  must_shell("systemctl stop footlight");
  CHECK(property("Result") == "success");
  CHECK(property("ExecMainStatus") == "0");
}

TEST_CASE("no unicast Art-Net frame of 64 senders is lost in the sandbox") {
  Service service;
  REQUIRE(service.shows("127.0.0.1", 1, Snapshot(512, 0)));
  Snapshot expected(512, 0);
  for (int i = 0; i < 64; ++i) {
    CAPTURE(i);
    // Each has the highest levels so far, so it wins whether or not those before it are still present.
    expected[static_cast<std::size_t>(i)] = 255;
    REQUIRE(service.shows_at_once(fmt::format("127.0.0.{}", 2 + i % 4), 1, expected));
  }
}

TEST_CASE("a bridge that hangs is restarted by the watchdog, and drives its device again") {
  Service service;
  REQUIRE(service.shows("127.0.0.1", 1, some_snapshot(3)));
  const std::string pid = property("MainPID");
  must_shell("kill -STOP " + pid);
  CHECK(eventually([&] { return property("NRestarts") == "1" && property("ActiveState") == "active"; }));
  CHECK(property("MainPID") != pid);
  CHECK(service.shows("127.0.0.1", 1, some_snapshot(4)));
}

TEST_CASE("systemctl reload reads the show file again, in the same process") {
  Service service;
  REQUIRE(service.shows("127.0.0.1", 1, some_snapshot(3)));
  const std::string pid = property("MainPID");
  Service::show(7);
  must_shell("systemctl reload footlight");
  CHECK(service.shows("127.0.0.1", 7, some_snapshot(4)));
  CHECK(property("MainPID") == pid);
}

TEST_CASE("the service runs without a capability, as a user that is not root, behind a filter of system calls") {
  Service service;
  std::ifstream status("/proc/" + property("MainPID") + "/status");
  std::stringstream all;
  all << status.rdbuf();
  const std::string text = all.str();
  CAPTURE(text);
  CHECK(text.find("\nUid:\t0\t") == std::string::npos);
  CHECK(text.find("\nCapEff:\t0000000000000000\n") != std::string::npos);
  CHECK(text.find("\nNoNewPrivs:\t1\n") != std::string::npos);
  CHECK(text.find("\nSeccomp:\t2\n") != std::string::npos);
}

}  // namespace
}  // namespace footlight::testing
