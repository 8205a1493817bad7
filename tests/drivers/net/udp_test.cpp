// Sockets connected to each other, in a network namespace with only "lo".
#include "drivers/net/udp.h"

#include <doctest/doctest.h>

#include <array>
#include <cerrno>
#include <cstddef>
#include <functional>
#include <vector>

#include <linux/filter.h>
#include <linux/seccomp.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/drivers/net/private_network.h"

namespace footlight::drivers {
namespace {

constexpr std::uint16_t kPort = 6454;
constexpr std::uint32_t kThisMachine = 0x7F000001, kEverybodyHere = 0x7FFFFFFF;

Fd must_open(Result<Fd> socket) {
  REQUIRE_MESSAGE(socket.has_value(), (socket ? std::string() : socket.error().message));
  return std::move(*socket);
}

void send(const Fd& from, std::uint32_t ipv4, std::vector<std::uint8_t> bytes) {
  DatagramWriter writer;
  writer.add(bytes, ipv4, kPort);
  REQUIRE(writer.flush(from.get()).error_number == 0);
}

// The effect of systemd's RestrictAddressFamilies= on a family that it does not list. Permanent for the calling
// process.
bool forbid_ipv6() {
  sock_filter program[] = {
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, nr)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, SYS_socket, 0, 3),
      BPF_STMT(BPF_LD | BPF_W | BPF_ABS, offsetof(seccomp_data, args)),
      BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, AF_INET6, 0, 1),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ERRNO | EAFNOSUPPORT),
      BPF_STMT(BPF_RET | BPF_K, SECCOMP_RET_ALLOW),
  };
  const sock_fprog filter = {static_cast<unsigned short>(std::size(program)), program};
  return prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) == 0 && prctl(PR_SET_SECCOMP, SECCOMP_MODE_FILTER, &filter) == 0 &&
         ::socket(AF_INET6, SOCK_DGRAM, 0) < 0 && errno == EAFNOSUPPORT;
}

constexpr int kSkipped = 77;

// Runs `body` in a child process without IPv6 and checks its result: 0 on success, else the failed step.
void check_without_ipv6(const std::function<int()>& body) {
  const pid_t pid = fork();
  REQUIRE(pid >= 0);
  if (pid == 0) _exit(forbid_ipv6() ? body() : kSkipped);
  int status = 0;
  REQUIRE(waitpid(pid, &status, 0) == pid);
  if (WIFEXITED(status) && WEXITSTATUS(status) == kSkipped) {
    MESSAGE("skipped: this system does not let a process filter its own system calls");
    return;
  }
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

int read_all(const Fd& fd) {
  DatagramReader reader;
  int all = 0;
  for (int count = 0; (count = reader.read(fd.get())) > 0;) all += count;
  return all;
}

// One unicast datagram from each of 64 UDP ports, so with different hashes.
bool send_from_64_ports() {
  for (int i = 0; i < 64; ++i) {
    const auto stranger = open_sender({"test", 0});
    if (!stranger) return false;
    DatagramWriter writer;
    const std::array<std::uint8_t, 1> bytes = {2};
    writer.add(bytes, kThisMachine, kPort);
    if (writer.flush(stranger->get()).error_number != 0) return false;
  }
  return true;
}

}  // namespace

TEST_CASE("a listener gets the datagrams of all 64 senders beside a yielding sender in a sandbox without IPv6") {
  if (!testing::enter_private_network()) return;
  ReceiverSocket wanted;
  wanted.port_name = "test";
  wanted.udp_port = kPort;
  check_without_ipv6([&] {  // the yielding sender is first
    const auto yielding = open_yielding_sender({"test", 0}, kPort, {});
    if (!yielding) return 1;
    const auto listener = open_receiver(wanted);
    if (!listener) return 2;
    if (!send_from_64_ports()) return 3;
    if (read_all(*listener) != 64) return 4;
    return read_all(*yielding) == 0 ? 0 : 5;
  });
  check_without_ipv6([&] {  // the listener is first
    const auto listener = open_receiver(wanted);
    if (!listener) return 1;
    const auto yielding = open_yielding_sender({"test", 0}, kPort, {});
    if (yielding || yielding.error().code != ErrorCode::kIo) return 2;
    if (!send_from_64_ports()) return 3;
    return read_all(*listener) == 64 ? 0 : 4;
  });
}

TEST_CASE("a send-only socket sends from its port with the machine's address, and receives nothing") {
  if (!testing::enter_private_network()) return;
  ReceiverSocket wanted;
  wanted.port_name = "test";
  wanted.udp_port = kPort;
  const auto body = [&] {
    const auto deaf = open_send_only({"test", 0}, kPort);
    if (!deaf) return 1;
    const auto second = open_send_only({"test", 0}, kPort);
    if (!second) return 2;
    if (!send_from_64_ports()) return 3;
    const auto stranger = open_sender({"test", 0});
    DatagramWriter writer;
    const std::array<std::uint8_t, 1> bytes = {2};
    writer.add(bytes, kEverybodyHere, kPort);
    if (!stranger || writer.flush(stranger->get()).error_number != 0) return 4;
    if (read_all(*deaf) != 0 || read_all(*second) != 0) return 5;
    wanted.bind_ipv4 = kThisMachine;
    wanted.udp_port = 9;
    const auto listener = open_receiver(wanted);
    if (!listener) return 6;
    writer.add(bytes, kThisMachine, 9);
    if (writer.flush(deaf->get()).error_number != 0) return 7;
    DatagramReader reader;
    if (reader.read(listener->get()) != 1) return 8;
    return reader[0].from_ipv4 == kThisMachine && reader[0].from_udp_port == kPort ? 0 : 9;
  };
  CHECK(body() == 0);
  check_without_ipv6(body);
}

TEST_CASE("a yielding sender receives unicast only if no other socket listens, and every broadcast") {
  if (!testing::enter_private_network()) return;
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, {}));
  const Fd other = must_open(open_sender({"test", 0}));
  DatagramReader reader;
  for (int i = 0; i < 8; ++i) send(other, kThisMachine, {1});
  CHECK(reader.read(yielding.get()) == 8);
  ReceiverSocket wanted;
  wanted.port_name = "test";
  wanted.udp_port = kPort;
  for (const bool listener_is_older : {false, true}) {
    CAPTURE(listener_is_older);
    Fd listener = must_open(open_receiver(wanted));
    const Fd second = listener_is_older ? must_open(open_yielding_sender({"test", 0}, kPort, {})) : Fd();
    for (int i = 0; i < 8; ++i) {
      const Fd stranger = must_open(open_sender({"test", 0}));  // its own UDP port: another hash
      send(stranger, kThisMachine, {2});
    }
    CHECK(reader.read(listener.get()) == 8);
    CHECK(reader.read(yielding.get()) == 0);
    send(other, kEverybodyHere, {3});
    CHECK(reader.read(listener.get()) == 1);
    CHECK(reader.read(yielding.get()) == 1);
  }
}

TEST_CASE("a yielding sender sends from the given port, and receives sender and destination addresses") {
  if (!testing::enter_private_network()) return;
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, {}));
  send(yielding, kThisMachine, {7});
  DatagramReader reader;
  REQUIRE(reader.read(yielding.get()) == 1);
  CHECK(reader[0].from_ipv4 == kThisMachine);
  CHECK(reader[0].from_udp_port == kPort);
  CHECK(reader[0].local_ipv4 == kThisMachine);
  CHECK(reader[0].interface_index == 1);
}

TEST_CASE("a yielding sender with a filter receives only the given numbers") {
  if (!testing::enter_private_network()) return;
  const std::array<std::uint16_t, 2> wanted = {0x2100, 0x8134};
  const Fd yielding = must_open(open_yielding_sender({"test", 0}, kPort, wanted));
  const Fd other = must_open(open_sender({"test", 0}));
  for (const int number : {0x2100, 0x0021, 0x5000, 0x8134, 0x2101}) {
    send(other, kThisMachine,
         {1, 2, 3, 4, 5, 6, 7, 8, static_cast<std::uint8_t>(number & 0xFF), static_cast<std::uint8_t>(number >> 8)});
  }
  send(other, kThisMachine, {1, 2, 3});
  DatagramReader reader;
  REQUIRE(reader.read(yielding.get()) == 2);
  CHECK(reader[0].bytes[9] == 0x21);
  CHECK(reader[1].bytes[9] == 0x81);
}

TEST_CASE("one unreachable receiver does not affect datagrams to the others") {
  if (!testing::enter_private_network()) return;
  const Fd sender = must_open(open_sender({"test", 0}));
  const std::vector<std::uint8_t> bytes = {1};
  DatagramWriter writer;
  writer.add(bytes, 0x0A000001, kPort);  // no route
  writer.add(bytes, kThisMachine, kPort);
  writer.add(bytes, 0x0A000002, kPort);
  std::vector<int> error_numbers;
  writer.flush_each(sender.get(), error_numbers);
  CHECK(error_numbers == std::vector<int>{ENETUNREACH, 0, ENETUNREACH});
  writer.flush_each(sender.get(), error_numbers);
  CHECK(error_numbers.empty());
}

}  // namespace footlight::drivers
