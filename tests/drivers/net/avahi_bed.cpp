#include "tests/drivers/net/avahi_bed.h"

#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "tests/support/temp_folder.h"

namespace footlight::testing {
namespace {

constexpr const char* kAvahiDaemon = "/usr/sbin/avahi-daemon";
constexpr const char* kBusDaemon = "/usr/bin/dbus-daemon";

constexpr const char* kBusConfig = R"(<!DOCTYPE busconfig PUBLIC "-//freedesktop//DTD D-Bus Bus Configuration 1.0//EN"
 "http://www.freedesktop.org/standards/dbus/1.0/busconfig.dtd">
<busconfig>
  <listen>unix:path={}</listen>
  <auth>EXTERNAL</auth>
  <policy context="default">
    <allow user="*"/>
    <allow own="*"/>
    <allow send_type="method_call"/>
    <allow send_type="signal"/>
    <allow send_type="method_return"/>
    <allow send_type="error"/>
    <allow receive_type="method_call"/>
    <allow receive_type="signal"/>
    <allow receive_type="method_return"/>
    <allow receive_type="error"/>
  </policy>
</busconfig>
)";

constexpr const char* kAvahiConfig = R"([server]
host-name=testbed
use-ipv4=yes
use-ipv6=no
enable-dbus=yes
[publish]
publish-hinfo=no
publish-workstation=no
)";

struct Started {
  pid_t pid = -1;
  bool ready = false;
};

// An empty /run for this process alone: the daemon keeps its PID there, and refuses to be the second one, beside one of
// the machine or of another test.
void take_own_run() {
  const bool own = ::unshare(CLONE_NEWNS) == 0 && ::mount(nullptr, "/", nullptr, MS_REC | MS_PRIVATE, nullptr) == 0 &&
                   ::mount("tmpfs", "/run", "tmpfs", 0, nullptr) == 0 && ::mkdir("/run/avahi-daemon", 0755) == 0;
  if (!own) std::perror("no /run of its own");
}

// Starts a program, and reads its output until a text appears, for at most 20 s.
Started start(const std::vector<std::string>& words, std::string_view until) {
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return {};
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = ::getpid();
  const pid_t pid = ::fork();
  if (pid == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (::getppid() != parent) ::_exit(1);
    ::dup2(ends[1], STDOUT_FILENO);
    ::dup2(ends[1], STDERR_FILENO);
    if (words[0] == kAvahiDaemon) take_own_run();
    ::execvp(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(ends[1]);
  std::string text;
  bool ready = false;
  pollfd one = {ends[0], POLLIN, 0};
  while (!ready && ::poll(&one, 1, 20'000) > 0) {
    char buffer[4096];
    const ssize_t size = ::read(ends[0], buffer, sizeof buffer);
    if (size <= 0) break;
    text.append(buffer, static_cast<std::size_t>(size));
    ready = text.find(until) != std::string::npos;
  }
  // The reading end stays open, so that the program can go on writing.
  if (!ready) fmt::print(stderr, "{} does not start: {}\n", words[0], text);
  return {pid, ready};
}

// One for all tests of a program: libdbus reads the address of the bus once.
const TempFolder& folder() {
  static const TempFolder only;
  return only;
}

void stop(pid_t& pid) {
  if (pid <= 0) return;
  ::kill(pid, SIGTERM);
  ::waitpid(pid, nullptr, 0);
  pid = -1;
}

}  // namespace

bool AvahiBed::is_installed() { return ::access(kAvahiDaemon, X_OK) == 0 && ::access(kBusDaemon, X_OK) == 0; }

AvahiBed::AvahiBed() {
  const std::string address = "unix:path=" + folder().file("bus");
  ::unlink(folder().file("bus").c_str());
  folder().write("bus.conf", fmt::format(kBusConfig, folder().file("bus")));
  folder().write("avahi.conf", kAvahiConfig);
  const Started bus =
      start({kBusDaemon, "--config-file=" + folder().file("bus.conf"), "--nofork", "--nopidfile", "--print-address=1"},
            address);
  bus_ = bus.pid;
  if (!bus.ready) return;
  ::setenv("DBUS_SYSTEM_BUS_ADDRESS", address.c_str(), 1);
  runs_ = start_daemon();
}

bool AvahiBed::start_daemon() {
  const Started daemon = start({kAvahiDaemon, "-f", folder().file("avahi.conf"), "--no-drop-root", "--no-chroot",
                                "--no-rlimits", "--no-proc-title"},
                               "Server startup complete");
  daemon_ = daemon.pid;
  return daemon.ready;
}

void AvahiBed::stop_daemon() { stop(daemon_); }

AvahiBed::~AvahiBed() {
  stop(daemon_);
  stop(bus_);
}

}  // namespace footlight::testing
