// A healthy machine laid out in a folder, then one fault at a time: only the check for it may report
// it.
#include "tools/footlight/doctor/doctor_checks.h"

#include <stdlib.h>

#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <set>

#include <doctest/doctest.h>
#include <nlohmann/json.hpp>

#include "drivers/gpio/gpio_chip.h"
#include "drivers/udev_rules.h"
#include "tests/support/temp_folder.h"
#include "tests/tools/footlight/run_footlight.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;
using namespace std::string_literals;

constexpr const char* kRouteTitle = "Iface Destination Gateway Flags RefCnt Use Metric Mask MTU Window IRTT\n";
constexpr const char* kUdpTitle =
    "   sl  local_address rem_address   st tx_queue rx_queue tr tm->when retrnsmt   uid  timeout inode ref pointer "
    "drops\n";

class Machine {
 public:
  Machine() {
    view.find.sys_root = path("sys");
    view.find.dev_root = path("dev");
    view.find.proc_root = path("proc");
    view.find.node_access = [this](const std::string& node) {
      if (!fs::exists(node)) return ENOENT;
      return forbidden.contains(fs::path(node).filename().string()) ? EACCES : 0;
    };
    view.etc_root = path("etc");
    view.lib_roots = {path("local"), path("lib")};
    view.user_id = 1000;
    view.user_name = "anna";
    view.groups = {"anna", "plugdev", "dialout", "gpio"};
    view.realtime_max = 40;

    const std::string usb = "sys/bus/usb/devices/1-2/";
    write(usb + "idVendor", "0403");
    write(usb + "idProduct", "6001");
    write(usb + "busnum", "1");
    write(usb + "devnum", "4");
    write(usb + "manufacturer", "ENTTEC");
    write(usb + "product", "DMX USB PRO");
    write(usb + "serial", "EN172589");
    fs::create_directories(root_ / usb / "1-2:1.0/ttyUSB0");
    fs::create_symlink("../../../../bus/usb/drivers/ftdi_sio", root_ / usb / "1-2:1.0/driver");
    write("dev/bus/usb/001/004", "");
    write("sys/class/hidraw/hidraw0/device/uevent", "DRIVER=hid-generic\nHID_ID=0003:000016D0:00000830\n");
    write("dev/hidraw0", "");
    write("sys/bus/gpio/devices/gpiochip0/label", "pinctrl");
    write("dev/gpiochip0", "");
    write("etc/udev/rules.d/70-footlight.rules", drivers::udev_rules_text());
    write("etc/group", "root:x:0:\nplugdev:x:46:\ndialout:x:20:\ngpio:x:997:\n");
    write("lib/udev/rules.d/85-brltty.rules", "# ENV{PRODUCT}==\"0403/6001/*\", GOTO=\"brltty_start\"\n");
    write("sys/class/net/lo/flags", "0x9\n");
    write("sys/class/net/eth0/flags", "0x1003\n");
    write("proc/net/route", std::string(kRouteTitle) + "eth0 00000000 0100000A 0003 0 0 0 00000000 0 0 0\n");
    write("proc/net/udp", kUdpTitle);
    write("proc/sys/net/ipv4/igmp_max_memberships", "20\n");
    write("proc/sys/net/ipv4/conf/all/rp_filter", "0\n");
    write("proc/sys/net/ipv4/conf/eth0/rp_filter", "0\n");
    write("proc/sys/net/core/rmem_max", "4194304\n");
    write("proc/sys/net/core/wmem_default", "212992\n");
    write("proc/self/status", "Name:\tfootlight\nCapEff:\t0000000000000000\n");
    write("sys/devices/system/clocksource/clocksource0/current_clocksource", "tsc\n");
    write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "schedutil\n");
    write("etc/systemd/system/footlight.service", "[Service]\n");
    write("etc/systemd/system/multi-user.target.wants/footlight.service", "[Service]\n");
    fs::create_directories(root_ / "sys/fs/cgroup/system.slice/footlight.service");
  }

  void write(const std::string& file, const std::string& text) const {
    fs::create_directories((root_ / file).parent_path());
    std::ofstream(root_ / file, std::ios::binary) << text;
  }
  void remove(const std::string& file) const { fs::remove_all(root_ / file); }
  // A process, with a file or socket open.
  void run(int process, const std::string& name, const std::string& open = "/dev/null") const {
    const std::string folder = "proc/" + std::to_string(process);
    write(folder + "/comm", name + "\n");
    fs::create_directories(root_ / folder / "fd");
    fs::create_symlink(open, root_ / folder / "fd/7");
  }
  void plug_bare_cable() const {
    const std::string usb = "sys/bus/usb/devices/1-3/";
    for (const auto& [name, text] : std::map<std::string, std::string>{
             {"idVendor", "0403"}, {"idProduct", "6001"}, {"busnum", "1"}, {"devnum", "7"}, {"serial", "A50285BI"}})
      write(usb + name, text);
    fs::create_directories(root_ / usb / "1-3:1.0/ttyUSB7");
    fs::create_symlink("../../../../bus/usb/drivers/ftdi_sio", root_ / usb / "1-3:1.0/driver");
    write("dev/bus/usb/001/007", "");
    write("dev/ttyUSB7", "");
  }
  // The program that had the widget open: after SIGKILL the driver is not bound again.
  void kill_program() const {
    write("sys/bus/usb/drivers/ftdi_sio/bind", "");
    remove("sys/bus/usb/devices/1-2/1-2:1.0/driver");
    remove("sys/bus/usb/devices/1-2/1-2:1.0/ttyUSB0");
  }
  // The GPIO chip that ftdi_sio makes of the spare pins of a serial chip.
  void add_spare_pins() const {
    fs::create_directories(root_ / "sys/bus/usb/devices/1-2/1-2:1.0/gpiochip1");
    fs::create_symlink("../../usb/devices/1-2/1-2:1.0/gpiochip1", root_ / "sys/bus/gpio/devices/gpiochip1");
    write("dev/gpiochip1", "");
  }
  [[nodiscard]] std::string path(const std::string& file) const { return (root_ / file).string(); }
  [[nodiscard]] std::map<std::string, Outcome> check() const {
    std::map<std::string, Outcome> outcomes;
    for (const Check& check : doctor_checks()) outcomes[check.id] = check.run(view);
    return outcomes;
  }

  DoctorView view;
  std::set<std::string> forbidden;  // names of nodes that this user may not use

 private:
  testing::TempFolder folder_;
  const fs::path root_ = folder_.path();
};

TEST_CASE("on a healthy machine no check warns") {
  const Machine machine;
  for (const auto& [id, outcome] : machine.check()) {
    CAPTURE(id);
    CAPTURE(outcome.seen);
    // Builds without libgpiod, libusb or hidapi warn about that.
    if (id == "gpio" && !drivers::built_with_gpio()) continue;
    if (id == "devices" && !drivers::built_with_usb()) continue;
    if (id == "hidraw" && !drivers::built_with_hid()) continue;
    CHECK(outcome.verdict == Verdict::kOk);
    CHECK(outcome.fix.empty());
    CHECK_FALSE(outcome.seen.empty());
  }
}

TEST_CASE("each fault is found by its own check only, with the expected fix") {
  struct Trouble {
    const char* id;  // of the check
    Verdict verdict;
    std::string seen;  // part of its text
    std::string fix;   // part of the fix; empty: there is none
    std::function<void(Machine&)> make;
    std::set<std::string> others = {};  // other checks that may also report it
  };
  const std::string route = kRouteTitle;
  const std::vector<Trouble> troubles = {
      {"devices", Verdict::kSkipped, "no DMX device", "", [](Machine& m) { m.remove("sys/bus/usb/devices/1-2"); }},
      {"devices", Verdict::kFail, "Permission denied", "udevadm", [](Machine& m) { m.forbidden.insert("004"); }},
      {"devices", Verdict::kFail, "does not exist", "", [](Machine& m) { m.remove("dev/bus/usb/001/004"); }},
      {"ftdi-sio",
       Verdict::kFail,
       "olad (process 812)",
       "fuser",
       [](Machine& m) { m.run(812, "olad", m.path("dev/ttyUSB0")); },
       {"devices"}},
      {"hidraw", Verdict::kFail, "hidraw0: Permission denied", "udevadm",
       [](Machine& m) { m.forbidden.insert("hidraw0"); }},
      {"hidraw", Verdict::kSkipped, "no DMX device of the HID class", "",
       [](Machine& m) { m.write("sys/class/hidraw/hidraw0/device/uevent", "HID_ID=0003:0000046D:0000C077\n"); }},
      {"hidraw", Verdict::kSkipped, "no DMX device", "",
       [](Machine& m) { m.write("sys/class/hidraw/hidraw0/device/uevent", "HID_ID=0003:00"); }},
      {"gpio", Verdict::kSkipped, "no GPIO chip", "", [](Machine& m) { m.remove("sys/bus/gpio"); }},
      {"gpio", Verdict::kWarn, "gpiochip0", "71-footlight-gpio.rules",
       [](Machine& m) { m.forbidden.insert("gpiochip0"); }},
      {"udev-rules", Verdict::kWarn, "not installed", "udevadm",
       [](Machine& m) { m.remove("etc/udev/rules.d/70-footlight.rules"); }},
      {"udev-rules", Verdict::kWarn, "another version", "udevadm",
       [](Machine& m) { m.write("etc/udev/rules.d/70-footlight.rules", "# ID_MM_DEVICE_IGNORE\n"); }},
      {"groups", Verdict::kWarn, "anna is not in plugdev, gpio", "usermod -aG plugdev,gpio anna",
       [](Machine& m) {
         m.view.groups = {"anna", "dialout"};
       }},
      {"groups", Verdict::kWarn, "began before anna joined plugdev", "newgrp plugdev",
       [](Machine& m) {
         m.view.groups = {"anna", "gpio"};
         m.write("etc/group", "plugdev:x:46:anna\n");
       }},
      {"groups", Verdict::kWarn, "anna is not in dialout", "usermod -aG dialout anna",
       [](Machine& m) {
         m.view.groups = {"anna", "plugdev", "gpio"};
         m.plug_bare_cable();
         m.forbidden = {"007", "ttyUSB7"};
         m.view.find.node_owner = [](const std::string&) { return drivers::NodeOwner{"dialout", 0660}; };
       }},
      {"devices",
       Verdict::kFail,
       "members of the group plugdev",
       "usermod -aG plugdev",
       [](Machine& m) {
         m.view.groups = {"anna", "dialout", "gpio"};
         m.forbidden.insert("004");
         m.view.find.node_owner = [](const std::string&) { return drivers::NodeOwner{"plugdev", 0660}; };
       },
       {"groups"}},
      {"hidraw",
       Verdict::kFail,
       "members of the group plugdev",
       "usermod -aG plugdev",
       [](Machine& m) {
         m.view.groups = {"anna", "dialout", "gpio"};
         m.forbidden.insert("hidraw0");
         m.view.find.node_owner = [](const std::string&) { return drivers::NodeOwner{"plugdev", 0660}; };
       },
       {"groups"}},
      {"ftdi-sio", Verdict::kWarn, "not bound to enttec-pro:EN172589",
       "echo 1-2:1.0 | sudo tee /sys/bus/usb/drivers/ftdi_sio/bind", [](Machine& m) { m.kill_program(); }},
      {"ftdi-sio", Verdict::kWarn, "not bound to the FTDI chip in socket 1-3", "echo 1-3:1.0",
       [](Machine& m) {
         m.write("sys/bus/usb/drivers/ftdi_sio/bind", "");
         m.plug_bare_cable();
         m.remove("sys/bus/usb/devices/1-3/1-3:1.0");
       }},
      {"modem-manager",
       Verdict::kWarn,
       "process 900",
       "udevadm",
       [](Machine& m) {
         m.run(900, "ModemManager");
         m.write("etc/udev/rules.d/70-footlight.rules", "# old\n");
       },
       {"udev-rules"}},
      {"brltty", Verdict::kWarn, "1a86/7523", "/etc/udev/rules.d/85-brltty.rules",
       [](Machine& m) {
         m.write("lib/udev/rules.d/85-brltty.rules", "ENV{PRODUCT}==\"1a86/7523/*\", GOTO=\"brltty_start\"\n");
       }},
      {"interfaces", Verdict::kWarn, "no interface except lo is up", "ip link",
       [](Machine& m) { m.write("sys/class/net/eth0/flags", "0x1002\n"); }},
      {"interfaces", Verdict::kWarn, "eth0 up without multicast", "multicast on",
       [](Machine& m) { m.write("sys/class/net/eth0/flags", "0x3\n"); }},
      {"multicast-route", Verdict::kWarn, "no route", "dev eth0",
       [&](Machine& m) { m.write("proc/net/route", route + "eth0 0000000A 00000000 0001 0 0 0 00FFFFFF 0 0 0\n"); }},
      {"multicast-route", Verdict::kWarn, "no route", "dev eth0",  // the route is down
       [&](Machine& m) { m.write("proc/net/route", route + "eth0 00000000 0100000A 0002 0 0 0 00000000 0 0 0\n"); }},
      {"igmp", Verdict::kWarn, "5 groups", "igmp_max_memberships=20",
       [](Machine& m) { m.write("proc/sys/net/ipv4/igmp_max_memberships", "5\n"); }},
      {"igmp-snooping", Verdict::kWarn, "br0", "multicast_querier",
       [](Machine& m) {
         m.write("sys/class/net/br0/flags", "0x1003\n");
         m.write("sys/class/net/br0/bridge/multicast_snooping", "1\n");
         m.write("sys/class/net/br0/bridge/multicast_querier", "0\n");
       }},
      {"rp-filter", Verdict::kWarn, "strict on eth0", "rp_filter=2",
       [](Machine& m) {
         m.write("sys/class/net/eth1/flags", "0x1003\n");
         m.write("proc/sys/net/ipv4/conf/eth0/rp_filter", "1\n");
       }},
      {"firewall", Verdict::kWarn, "ufw", "ufw allow 5568/udp",
       [](Machine& m) { m.write("etc/ufw/ufw.conf", "ENABLED=yes\nLOGLEVEL=low\n"); }},
      {"firewall", Verdict::kWarn, "firewalld", "firewall-cmd", [](Machine& m) { m.run(77, "firewalld"); }},
      {"firewall", Verdict::kWarn, "iptables", "iptables -L",
       [](Machine& m) { m.write("proc/net/ip_tables_names", "filter\n"); }},
      {"udp-ports", Verdict::kWarn, "5568 by olad (812)", "",
       [](Machine& m) {
         m.write("proc/net/udp", std::string(kUdpTitle) +
                                     "  1: 00000000:15C0 00000000:0000 07 00000000:00000000 00:00000000 00000000     0"
                                     "        0 4711 2 0000000000000000 0\n");
         m.run(812, "olad", "socket:[4711]");
       }},
      {"udp-ports", Verdict::kWarn, "6454 by a process of another user", "",
       [](Machine& m) {
         m.write("proc/net/udp6", std::string(kUdpTitle) +
                                      "  1: 00000000000000000000000000000000:1936 "
                                      "00000000000000000000000000000000:0000 07 00000000:00000000 00:00000000 00000000"
                                      "     0        0 4712 2 0000000000000000 0\n");
       }},
      {"receive-buffers", Verdict::kWarn, "28 universes", "rmem_max",
       [](Machine& m) { m.write("proc/sys/net/core/rmem_max", "212992\n"); }},
      {"receive-buffers", Verdict::kFail, "1 universes", "rmem_max",
       [](Machine& m) { m.write("proc/sys/net/core/rmem_max", "10000\n"); }},
      {"send-buffers", Verdict::kWarn, "2 universes", "wmem_default",
       [](Machine& m) { m.write("proc/sys/net/core/wmem_default", "4608\n"); }},
      {"real-time", Verdict::kWarn, "not allowed", "limits.d", [](Machine& m) { m.view.realtime_max = 0; }},
      {"real-time", Verdict::kWarn, "priority 10 allowed, 40 needed", "LimitRTPRIO=40",
       [](Machine& m) { m.view.realtime_max = 10; }},
      {"clock-source", Verdict::kWarn, "hpet", "dmesg",
       [](Machine& m) { m.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "hpet\n"); }},
      {"clock-source", Verdict::kWarn, "acpi_pm", "echo tsc",
       [](Machine& m) {
         m.write("sys/devices/system/clocksource/clocksource0/current_clocksource", "acpi_pm\n");
         m.write("sys/devices/system/clocksource/clocksource0/available_clocksource", "tsc hpet acpi_pm\n");
       }},
      {"timers", Verdict::kWarn, "4000 us", "highres", [](Machine& m) { m.view.clock_resolution_ns = 4'000'000; }},
      {"governor", Verdict::kWarn, "powersave", "scaling_governor",
       [](Machine& m) { m.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n"); }},
      {"governor", Verdict::kSkipped, "virtual machines", "", [](Machine& m) { m.remove("sys/devices/system/cpu"); }},
      {"service", Verdict::kSkipped, "not installed", "",
       [](Machine& m) { m.remove("etc/systemd/system/footlight.service"); }},
      {"service", Verdict::kWarn, "not running", "systemctl",
       [](Machine& m) { m.remove("sys/fs/cgroup/system.slice/footlight.service"); }},
      {"service", Verdict::kWarn, "will not start with the machine", "systemctl enable",
       [](Machine& m) { m.remove("etc/systemd/system/multi-user.target.wants"); }},
  };
  std::set<std::string> troubled;
  for (const Trouble& trouble : troubles) {
    CAPTURE(trouble.id);
    if (std::string(trouble.id) == "gpio" && !drivers::built_with_gpio()) continue;
    if (trouble.others.contains("devices") && !drivers::built_with_usb()) continue;
    Machine machine;
    const auto before = machine.check();
    trouble.make(machine);
    const auto after = machine.check();
    CAPTURE(after.at(trouble.id).seen);
    CAPTURE(after.at(trouble.id).fix);
    CHECK(after.at(trouble.id).verdict == trouble.verdict);
    CHECK(after.at(trouble.id).seen.find(trouble.seen) != std::string::npos);
    CHECK(after.at(trouble.id).fix.find(trouble.fix) != std::string::npos);
    troubled.insert(trouble.id);
    for (const auto& [id, outcome] : after) {
      CAPTURE(id);
      if (id != trouble.id && !trouble.others.contains(id)) CHECK(outcome.verdict == before.at(id).verdict);
    }
  }
  for (const Check& check : doctor_checks()) {
    CAPTURE(check.id);
    CHECK(troubled.contains(check.id));
  }
}

TEST_CASE("docs/doctor.md has a row for every check, and no other") {
  std::set<std::string> written;
  std::ifstream document(FOOTLIGHT_SOURCE_DIR "/docs/doctor.md");
  for (std::string line; std::getline(document, line);)
    if (line.starts_with("| `")) written.insert(line.substr(3, line.find('`', 3) - 3));
  std::set<std::string> checks;
  for (const Check& check : doctor_checks()) checks.insert(check.id);
  CHECK(written == checks);
}

TEST_CASE("privileges replace limits") {
  Machine machine;
  machine.view.realtime_max = 0;
  machine.write("proc/sys/net/core/rmem_max", "212992\n");
  CHECK(machine.check().at("real-time").verdict == Verdict::kWarn);
  CHECK(machine.check().at("receive-buffers").verdict == Verdict::kWarn);
  machine.write("proc/self/status", "CapEff:\t0000000000801000\n");  // CAP_SYS_NICE and CAP_NET_ADMIN
  CHECK(machine.check().at("real-time").verdict == Verdict::kOk);
  CHECK(machine.check().at("receive-buffers").verdict == Verdict::kOk);
}

TEST_CASE("harmless states are not reported as problems") {
  Machine machine;
  // Rules that were installed with the program, not copied; the rules exclude ModemManager; a file in /etc replaces
  // brltty's; one interface has only one route back.
  machine.remove("etc/udev/rules.d/70-footlight.rules");
  machine.write("local/udev/rules.d/70-footlight.rules", drivers::udev_rules_text());
  machine.run(900, "ModemManager");
  machine.write("lib/udev/rules.d/85-brltty.rules", "ENV{PRODUCT}==\"0403/6001/*\"\n");
  machine.write("etc/udev/rules.d/85-brltty.rules", "");
  machine.write("proc/sys/net/ipv4/conf/all/rp_filter", "1\n");
  machine.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_governor", "powersave\n");
  machine.write("sys/devices/system/cpu/cpu0/cpufreq/scaling_driver", "intel_pstate\n");
  machine.write("proc/net/route", std::string(kRouteTitle) +
                                      "eth7 000000EF 00000000 0001 0 0 0 000000FF 0 0 0\n"
                                      "eth0 00000000 0100000A 0003 0 0 0 00000000 0 0 0\n");
  machine.view.user_id = 0;
  machine.view.groups.clear();
  const auto outcomes = machine.check();
  for (const char* const id :
       {"udev-rules", "modem-manager", "brltty", "rp-filter", "governor", "groups", "multicast-route"}) {
    CAPTURE(id);
    CAPTURE(outcomes.at(id).seen);
    CHECK(outcomes.at(id).verdict == Verdict::kOk);
  }
  CHECK(outcomes.at("multicast-route").seen.find("eth7") !=
        std::string::npos);  // 239.0.0.0/8 is more specific than the default route
}

TEST_CASE("a member of plugdev needs no dialout if libusb works") {
  Machine machine;
  machine.view.groups = {"anna", "plugdev", "gpio"};
  CHECK(machine.check().at("groups").verdict == Verdict::kOk);
}

TEST_CASE("the spare pins of a serial chip cause no warning and need no group") {
  Machine machine;
  machine.remove("sys/bus/gpio/devices/gpiochip0");
  machine.add_spare_pins();
  machine.forbidden.insert("gpiochip1");
  machine.view.groups = {"anna", "plugdev"};
  CHECK(machine.check().at("gpio").verdict == Verdict::kSkipped);
  CHECK(machine.check().at("groups").verdict == Verdict::kOk);
}

TEST_CASE("an empty machine is checked without a crash") {
  Machine machine;
  for (const char* const folder : {"sys", "dev", "proc", "etc", "lib"}) machine.remove(folder);
  for (const auto& [id, outcome] : machine.check()) {
    CAPTURE(id);
    CHECK(outcome.verdict != Verdict::kFail);
  }
}

TEST_CASE("damaged tables are checked without a crash") {
  Machine machine;
  const std::string junk = "\xff\x00:zz 1 2 3 4 5 6 7 8 9 10 11\n:\nHID_ID=\n"s;
  for (const char* const file :
       {"proc/net/route", "proc/net/udp", "proc/net/udp6", "proc/self/status", "etc/group", "sys/class/net/eth0/flags",
        "proc/sys/net/core/rmem_max", "proc/sys/net/ipv4/igmp_max_memberships",
        "sys/class/hidraw/hidraw0/device/uevent", "etc/udev/rules.d/70-footlight.rules"})
    machine.write(file, junk);
  CHECK(machine.check().size() == doctor_checks().size());
}

TEST_CASE("the number of universes through a stall grows with the buffer, up to the size that the program requests") {
  CHECK(universes_through_a_stall(0) == 0);
  CHECK(universes_through_a_stall(212'992) == 28);
  CHECK(universes_through_a_stall(4 << 20) >= 512);
  CHECK(universes_through_a_stall(1 << 30) == universes_through_a_stall(4 << 20));
}

TEST_CASE("doctor --json prints one object per check, and its exit code is 1 if one has failed") {
  const auto outcome = testing::footlight({"doctor", "--json"});
  std::istringstream lines(outcome.out);
  std::size_t count = 0;
  bool any_failed = false;
  for (std::string line; std::getline(lines, line); ++count) {
    const auto object = nlohmann::json::parse(line);
    for (const char* const key : {"check", "title", "verdict", "seen", "fix"}) CHECK(object.contains(key));
    any_failed = any_failed || object["verdict"] == "fail";
  }
  CHECK(count == doctor_checks().size());
  CHECK(outcome.exit_code == (any_failed ? 1 : 0));
  const auto text = testing::footlight({"doctor"});
  CHECK(text.out.find("real-time priority") != std::string::npos);
  CHECK(text.out.find(" warnings, ") != std::string::npos);
}

}  // namespace
}  // namespace footlight::tools
