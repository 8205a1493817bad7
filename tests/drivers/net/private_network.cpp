#include "tests/drivers/net/private_network.h"

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

#include <arpa/inet.h>
#include <fcntl.h>
#include <net/if.h>
#include <net/route.h>
#include <netinet/in.h>
#include <poll.h>
#include <sched.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace footlight::testing {
namespace {

bool write_text(const char* path, const std::string& text) {
  const int fd = open(path, O_WRONLY);
  if (fd < 0) return false;
  const bool good = write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  close(fd);
  return good;
}

// Without privilege, a new user namespace gives the right to make a network namespace.
bool unshare_network() {
  if (unshare(CLONE_NEWNET) == 0) return true;
  const uid_t uid = getuid();
  const gid_t gid = getgid();
  if (unshare(CLONE_NEWUSER | CLONE_NEWNET) != 0) return false;
  write_text("/proc/self/setgroups", "deny");
  return write_text("/proc/self/uid_map", "0 " + std::to_string(uid) + " 1") &&
         write_text("/proc/self/gid_map", "0 " + std::to_string(gid) + " 1");
}

void set_ipv4(sockaddr& address, const char* text) {
  sockaddr_in ipv4 = {};
  ipv4.sin_family = AF_INET;
  inet_pton(AF_INET, text, &ipv4.sin_addr);
  std::memcpy(&address, &ipv4, sizeof ipv4);
}

bool prepare_loopback(bool multicast) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  if (fd < 0) return false;
  ifreq interface = {};
  std::strcpy(interface.ifr_name, "lo");
  const int flags = IFF_UP | IFF_RUNNING | IFF_LOOPBACK | (multicast ? IFF_MULTICAST : 0);
  interface.ifr_flags = static_cast<short>(flags);
  bool good = ioctl(fd, SIOCSIFFLAGS, &interface) == 0;
  rtentry route = {};
  set_ipv4(route.rt_dst, "239.255.0.0");
  set_ipv4(route.rt_genmask, "255.255.0.0");
  route.rt_flags = RTF_UP;
  char name[] = "lo";
  route.rt_dev = name;
  good = good && (!multicast || ioctl(fd, SIOCADDRT, &route) == 0);
  close(fd);
  return good;
}

// The namespaces of add_peer(): ours and the other machine's.
int home_fd = -1;
int peer_fd = -1;

// Waits until the interface on this machine carries datagrams: the kernel enables it in a thread of its own.
bool wait_until_running(const std::string& name) {
  const int fd = socket(AF_INET, SOCK_DGRAM, 0);
  ifreq interface = {};
  name.copy(interface.ifr_name, IFNAMSIZ - 1);
  bool running = false;
  for (int i = 0; i < 2'000 && !running; ++i) {
    running = ioctl(fd, SIOCGIFFLAGS, &interface) == 0 && (interface.ifr_flags & IFF_RUNNING) != 0;
    if (!running) poll(nullptr, 0, 1);
  }
  close(fd);
  return running;
}

bool run(const std::string& command) { return std::system((command + " 2>/dev/null").c_str()) == 0; }

}  // namespace

bool enter_private_network(bool loopback_multicast) {
  if (unshare_network() && prepare_loopback(loopback_multicast)) return true;
  std::fprintf(stderr, "SKIPPED: no private network namespace (%s); run as root or allow user namespaces\n",
               std::strerror(errno));
  return false;
}

bool add_interface(const char* name, const char* ipv4) {
  // rtnetlink would need a hundred lines here; iproute2 is installed wherever there are network namespaces.
  const std::string peer = std::string(name) + "p";
  const std::string command = std::string("ip link add ") + name + " type veth peer name " + peer +
                              " && ip address add " + ipv4 + "/24 brd + dev " + name + " && ip link set " + peer +
                              " up && ip link set " + name + " up";
  if (std::system((command + " 2>/dev/null").c_str()) == 0) return true;
  std::fprintf(stderr, "SKIPPED: cannot add an interface: %s\n", command.c_str());
  return false;
}

bool add_peer(const char* name, const char* ipv4, const std::vector<std::string>& peer_ipv4s) {
  for (int* const fd : {&home_fd, &peer_fd}) {
    if (*fd >= 0) close(*fd);
    *fd = -1;
  }
  home_fd = open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC);
  bool good = home_fd >= 0 && unshare(CLONE_NEWNET) == 0;
  peer_fd = good ? open("/proc/thread-self/ns/net", O_RDONLY | O_CLOEXEC) : -1;
  good = good && peer_fd >= 0 && setns(home_fd, CLONE_NEWNET) == 0;
  const std::string ours(name);
  const std::string peer = ours + "p";
  good = good && run("ip link add " + ours + " type veth peer name " + peer + " netns /proc/" +
                     std::to_string(getpid()) + "/fd/" + std::to_string(peer_fd) + " && ip address add " + ipv4 +
                     "/24 brd + dev " + ours + " && ip link set " + ours + " up");
  if (good) {
    const OnPeer on_peer;
    for (const std::string& address : peer_ipv4s) {
      good = good && run("ip address add " + address + "/24 brd + dev " + peer);
    }
    good = good && run("ip link set lo up && ip link set " + peer + " up") && wait_until_running(peer);
  }
  // The last command returns when the kernel has finished what it does after it reports that an interface runs.
  good = good && wait_until_running(ours) && run("ip link set " + ours + " up");
  if (!good) std::fprintf(stderr, "SKIPPED: cannot add a second network namespace: %s\n", std::strerror(errno));
  return good;
}

OnPeer::OnPeer() {
  if (setns(peer_fd, CLONE_NEWNET) != 0) std::abort();
}

OnPeer::~OnPeer() {
  if (setns(home_fd, CLONE_NEWNET) != 0) std::abort();
}

bool choke_interface(const char* name) {
  if (run(std::string("tc qdisc add dev ") + name + " root tbf rate 8kbit burst 1600 limit 100000000")) return true;
  std::fprintf(stderr, "SKIPPED: cannot slow an interface down (tc of iproute2, sch_tbf of the kernel)\n");
  return false;
}

void free_interface(const char* name) {
  const std::string command = std::string("tc qdisc delete dev ") + name + " root";
  if (std::system(command.c_str()) != 0) std::fprintf(stderr, "could not run: %s\n", command.c_str());
}

void remove_interface(const char* name) {
  const std::string command = std::string("ip link delete ") + name;
  if (std::system(command.c_str()) != 0) std::fprintf(stderr, "could not run: %s\n", command.c_str());
}

}  // namespace footlight::testing
