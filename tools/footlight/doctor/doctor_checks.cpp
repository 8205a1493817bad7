#include "tools/footlight/doctor/doctor_checks.h"

#include <grp.h>
#include <pwd.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <sstream>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "drivers/gpio/gpio_chip.h"
#include "drivers/gpio/gpio_list.h"
#include "drivers/net/net.h"
#include "drivers/open_files.h"
#include "drivers/permission.h"
#include "drivers/wait/real_time.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

// --- Reading
// -----------------------------------------------------------------------------------------------------------

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::string line_of(const fs::path& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  while (!line.empty() && (line.back() == '\n' || line.back() == ' ')) line.pop_back();
  return line;
}

bool is_there(const fs::path& path) {
  std::error_code error;
  return fs::exists(path, error);
}

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    names.push_back(entry->path().filename().string());
  std::sort(names.begin(), names.end());
  return names;
}

std::optional<std::uint64_t> number_of(std::string_view text, int base = 10) {
  if (text.starts_with("0x")) {
    text.remove_prefix(2);
    base = 16;
  }
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

std::optional<std::uint64_t> number_in(const fs::path& path) { return number_of(line_of(path)); }

std::vector<std::string> words_of(const std::string& line) {
  std::istringstream stream(line);
  return {std::istream_iterator<std::string>(stream), {}};
}

// Where rules and units of that kind lie: the administrator's, then those of packages.
std::vector<fs::path> folders_of(const DoctorView& view, const char* kind) {
  std::vector<fs::path> folders = {fs::path(view.etc_root) / kind};
  for (const std::string& root : view.lib_roots) folders.push_back(fs::path(root) / kind);
  return folders;
}

// The process id of the first process of that name; empty if none runs.
std::string process_of(const DoctorView& view, std::string_view name) {
  for (const std::string& process : drivers::processes(view.find.proc_root))
    if (drivers::process_name(view.find.proc_root, process) == name) return process;
  return {};
}

// Interfaces except "lo", with their flags (if.h).
struct Interface {
  std::string name;
  std::uint64_t flags = 0;
  [[nodiscard]] bool is_up() const { return (flags & 0x1) != 0; }
  [[nodiscard]] bool is_multicast() const { return (flags & 0x1000) != 0; }
};

std::vector<Interface> interfaces_of(const DoctorView& view) {
  std::vector<Interface> interfaces;
  const fs::path folder = fs::path(view.find.sys_root) / "class/net";
  for (const std::string& name : names_in(folder)) {
    const auto flags = number_in(folder / name / "flags");
    if (name != "lo" && flags) interfaces.push_back({name, *flags});
  }
  return interfaces;
}

std::string first_interface_up(const DoctorView& view) {
  for (const Interface& interface : interfaces_of(view))
    if (interface.is_up()) return interface.name;
  return "eth0";
}

bool has_capability(const DoctorView& view, unsigned bit) {
  std::istringstream status(text_of(fs::path(view.find.proc_root) / "self/status"));
  for (std::string line; std::getline(status, line);) {
    if (!line.starts_with("CapEff:")) continue;
    const auto words = words_of(line);
    const auto mask = words.size() > 1 ? number_of(words[1], 16) : std::nullopt;
    return mask && ((*mask >> bit) & 1) != 0;
  }
  return false;
}
constexpr unsigned kCapNetAdmin = 12, kCapSysNice = 23;  // capability.h

Outcome ok(std::string seen) { return {Verdict::kOk, std::move(seen), {}}; }
Outcome warn(std::string seen, std::string fix = {}) { return {Verdict::kWarn, std::move(seen), std::move(fix)}; }
Outcome failed(std::string seen, std::string fix = {}) { return {Verdict::kFail, std::move(seen), std::move(fix)}; }
Outcome skipped(std::string seen) { return {Verdict::kSkipped, std::move(seen), {}}; }

// --- Devices
// -----------------------------------------------------------------------------------------------------------

// The options of the drivers' own search.
drivers::FindOptions options_of(const DoctorView& view) {
  drivers::FindOptions options = view.find;
  options.etc_root = view.etc_root;
  options.lib_roots = view.lib_roots;
  options.groups = view.groups;
  options.user_name = view.user_name;
  return options;
}

Outcome check_devices(const DoctorView& view) {
  const drivers::DeviceList list = drivers::find_devices(options_of(view));
  std::vector<std::string> ready;
  for (const drivers::FoundDevice& device : list.devices) {
    switch (device.readiness) {
      case drivers::Readiness::kReady: ready.push_back(device.endpoint); break;
      case drivers::Readiness::kNotDmx: break;
      case drivers::Readiness::kBusy:
        return warn(fmt::format("{}: {}", device.model_name, device.reason), device.remedy);
      default: return failed(fmt::format("{}: {}", device.model_name, device.reason), device.remedy);
    }
  }
  if (ready.empty()) return skipped("no DMX device is plugged in");
  return ok(fmt::format("ready: {}", fmt::join(ready, ", ")));
}

// The driver that opens devices with these ids through hidraw; nullptr: none.
const drivers::DriverInfo* hid_driver_of(std::uint64_t vendor, std::uint64_t product) {
  for (const drivers::DriverInfo* driver : drivers::drivers())
    for (const drivers::UsbModelId& model : driver->usb_ids)
      if (model.transport == drivers::TransportKind::kHid && model.vendor == vendor && model.product == product)
        return driver;
  return nullptr;
}

Outcome check_hidraw(const DoctorView& view) {
  std::vector<std::string> ready;
  const fs::path folder = fs::path(view.find.sys_root) / "class/hidraw";
  for (const std::string& name : names_in(folder)) {
    // HID_ID=0003:000016D0:00000830: bus, vendor, product.
    const std::string uevent = text_of(folder / name / "device/uevent");
    const std::size_t at = uevent.find("HID_ID=");
    if (at == std::string::npos || uevent.size() < at + 29) continue;
    const auto vendor = number_of(std::string_view(uevent).substr(at + 12, 8), 16);
    const auto product = number_of(std::string_view(uevent).substr(at + 21, 8), 16);
    const drivers::DriverInfo* const driver = vendor && product ? hid_driver_of(*vendor, *product) : nullptr;
    if (driver == nullptr) continue;
    const std::string node = fmt::format("{}/{}", view.find.dev_root, name);
    const int error = drivers::node_access(view.find, node);
    if (error == EACCES || error == EPERM) {
      drivers::FoundDevice device;
      device.driver_id = driver->id;
      const drivers::Advice advice = drivers::advise_on_permission(device, node, error, options_of(view));
      return failed(advice.reason, advice.remedy);
    }
    if (error != 0) return failed(fmt::format("{}: {}", node, std::strerror(error)));
    ready.push_back(node);
  }
  if (ready.empty()) return skipped("no DMX device of the HID class is plugged in");
  if (!drivers::built_with_hid())
    return warn("this build has no HID support",
                "sudo apt install libhidapi-dev, then build again with -DFOOTLIGHT_HID=ON");
  return ok(fmt::format("usable: {}", fmt::join(ready, ", ")));
}

Outcome check_gpio(const DoctorView& view) {
  std::vector<drivers::FoundGpioChip> chips = drivers::find_gpio_chips(view.find);
  // The spare pins of a serial chip cause no warning; they are listed if they can be opened.
  std::erase_if(chips, [](const drivers::FoundGpioChip& chip) {
    return drivers::is_part_of_serial_chip(chip) && chip.readiness == drivers::Readiness::kNoPermission;
  });
  if (chips.empty()) return skipped("this machine has no GPIO chip");
  if (!drivers::built_with_gpio())
    return warn("this build has no GPIO support",
                "sudo apt install libgpiod-dev, then build again with -DFOOTLIGHT_GPIO=ON");
  std::vector<std::string> usable;
  for (const drivers::FoundGpioChip& chip : chips) {
    if (chip.readiness == drivers::Readiness::kReady)
      usable.push_back(chip.node);
    else
      return warn(fmt::format("{}; strobe inputs need it", chip.reason),
                  chip.remedy == drivers::gpio_install_command()
                      ? fmt::format("read udev/71-footlight-gpio.rules, then: {}", chip.remedy)
                      : chip.remedy);
  }
  return ok(fmt::format("usable: {}", fmt::join(usable, ", ")));
}

Outcome check_udev_rules(const DoctorView& view) {
  switch (drivers::rules_state(options_of(view))) {
    case drivers::RulesState::kCurrent: return ok("installed and current");
    case drivers::RulesState::kMissing:
      return warn("not installed; without them only root can open USB devices", drivers::udev_install_command());
    case drivers::RulesState::kOutdated: break;
  }
  return warn("installed, but from another version; devices added since then cannot be opened",
              drivers::udev_install_command());
}

Outcome check_ftdi_sio(const DoctorView& view) {
  std::vector<std::string> held;
  for (const drivers::FoundDevice& device : drivers::find_devices(options_of(view)).devices) {
    if (!device.rebind.empty())
      return warn(fmt::format("not bound to {}, as after a kill of the program that used it. footlight can open it "
                              "anyway and binds the "
                              "driver when it closes it; other programs need its tty",
                              device.endpoint.empty() ? fmt::format("the FTDI chip in socket {}", device.port_path)
                                                      : device.endpoint),
                  fmt::format("{}, or plug it in again", device.rebind));
    if (device.kernel_driver != "ftdi_sio" || device.driver_id.empty()) continue;
    if (device.readiness == drivers::Readiness::kBusy)
      return failed(fmt::format("{}: its tty is {}", device.endpoint, device.reason), device.remedy);
    held.push_back(device.endpoint);
  }
  if (held.empty()) return ok("bound to no DMX device");
  return ok(fmt::format("bound to {}, and detached while they are in use", fmt::join(held, ", ")));
}

Outcome check_modem_manager(const DoctorView& view) {
  const std::string process = process_of(view, "ModemManager");
  if (process.empty()) return ok("not running");
  if (drivers::installed_udev_rules(options_of(view)).find("ID_MM_DEVICE_IGNORE") != std::string::npos)
    return ok("running; footlight's udev rules exclude DMX devices");
  return warn(
      fmt::format("running (process {}); it sends modem commands to every new serial adapter, also to DMX devices",
                  process),
      drivers::udev_install_command());
}

// brltty's rules name bare serial chips. If they are active, its daemon takes the adapter from other programs.
Outcome check_brltty(const DoctorView& view) {
  std::set<std::string> seen;
  for (const fs::path& folder : folders_of(view, "udev/rules.d")) {
    for (const std::string& name : names_in(folder)) {
      // A file in /etc replaces the one of the same name in /usr/lib.
      if (name.find("brltty") == std::string::npos || !seen.insert(name).second) continue;
      std::istringstream rules(text_of(folder / name));
      for (std::string line; std::getline(rules, line);) {
        if (line.empty() || line.front() == '#') continue;
        for (const char* const ids : {"0403/6001", "0403/6015", "1a86/7523", "10c4/ea60"}) {
          if (line.find(ids) == std::string::npos) continue;
          return warn(fmt::format("{} claims every adapter with the USB ids {} for braille displays",
                                  (folder / name).string(), ids),
                      fmt::format("if braille displays are not used: sudo ln -sf /dev/null /etc/udev/rules.d/{} && "
                                  "sudo udevadm control --reload",
                                  name));
        }
      }
    }
  }
  return ok(seen.empty() ? "not installed" : "claims no adapter with the ids of a bare serial chip");
}

// The udev rules give the ttys of DMX devices to plugdev. The group dialout is needed only if a tty is open to that
// group alone.
bool needs_tty_group(const DoctorView& view) {
  const drivers::DeviceList list = drivers::find_devices(options_of(view));
  return std::any_of(list.devices.begin(), list.devices.end(), [&](const drivers::FoundDevice& device) {
    return !device.tty.empty() && drivers::node_access(view.find, device.node) != 0 &&
           drivers::node_access(view.find, device.tty) != 0 &&
           drivers::owner_of(options_of(view), device.tty).group == "dialout";
  });
}

bool has_gpio_chip(const DoctorView& view) {
  const auto chips = drivers::find_gpio_chips(view.find);
  return !std::all_of(chips.begin(), chips.end(), drivers::is_part_of_serial_chip);
}

Outcome check_groups(const DoctorView& view) {
  if (view.user_id == 0) return ok("root needs none; a service should have its own user");
  std::set<std::string> there;
  std::istringstream groups(text_of(fs::path(view.etc_root) / "group"));
  for (std::string line; std::getline(groups, line);) there.insert(line.substr(0, line.find(':')));
  std::vector<std::string> missing;
  std::vector<std::string> needed = {drivers::kRulesGroup};
  if (needs_tty_group(view)) needed.emplace_back("dialout");
  if (has_gpio_chip(view)) needed.emplace_back("gpio");
  for (const std::string& group : needed)
    if (there.contains(group) && std::find(view.groups.begin(), view.groups.end(), group) == view.groups.end())
      missing.push_back(group);
  if (missing.empty()) return ok(fmt::format("{} is in all required groups", view.user_name));
  if (std::all_of(missing.begin(), missing.end(),
                  [&](const std::string& group) { return drivers::is_listed_in(options_of(view), group); }))
    return warn(fmt::format("this session began before {} joined {}: log out and in again", view.user_name,
                            fmt::join(missing, ", ")),
                fmt::format("newgrp {}", missing.front()));
  return warn(fmt::format("{} is not in {}; the udev rules give access at the machine itself, but not over ssh and in "
                          "services",
                          view.user_name, fmt::join(missing, ", ")),
              fmt::format("sudo usermod -aG {} {}, then log in again", fmt::join(missing, ","), view.user_name));
}

// --- Network
// -----------------------------------------------------------------------------------------------------------

Outcome check_interfaces(const DoctorView& view) {
  std::vector<std::string> good, no_multicast;
  for (const Interface& interface : interfaces_of(view)) {
    if (!interface.is_up()) continue;
    (interface.is_multicast() ? good : no_multicast).push_back(interface.name);
  }
  if (!no_multicast.empty())
    return warn(
        fmt::format("{} up without multicast, which sACN needs", fmt::join(no_multicast, ", ")),
        fmt::format("sudo ip link set dev {} multicast on, or use unicast: sacn:1@10.0.0.7", no_multicast.front()));
  if (good.empty())
    return warn("no interface except lo is up: sACN and Art-Net stay on this machine",
                "ip link; sudo ip link set dev eth0 up");
  return ok(fmt::format("up with multicast: {}", fmt::join(good, ", ")));
}

std::uint32_t swapped(std::uint64_t word) { return __builtin_bswap32(static_cast<std::uint32_t>(word)); }

Outcome check_multicast_route(const DoctorView& view) {
  constexpr std::uint32_t kSacnNet = 0xEFFF0000;  // 239.255.0.0/16
  std::istringstream table(text_of(fs::path(view.find.proc_root) / "net/route"));
  std::string line;
  std::getline(table, line);  // names of the columns
  std::string through;
  std::uint32_t mask_best = 0;
  while (std::getline(table, line)) {
    const auto words = words_of(line);
    if (words.size() < 8) continue;
    const auto destination = number_of(words[1], 16), mask = number_of(words[7], 16), flags = number_of(words[3], 16);
    if (!destination || !mask || !flags || (*flags & 1) == 0) continue;
    const std::uint32_t net_mask = swapped(*mask);
    if ((kSacnNet & net_mask) != swapped(*destination)) continue;
    if (!through.empty() && net_mask <= mask_best) continue;
    through = words[0];
    mask_best = net_mask;
  }
  if (through.empty())
    return warn("no route to 239.255.0.0/16: sACN without a named interface cannot be sent",
                fmt::format("name the interface (sacn:1-9%{0}), or: sudo ip route add 239.0.0.0/8 dev {0}",
                            first_interface_up(view)));
  return ok(fmt::format("239.255.0.0/16 leaves through {}{}", through,
                        mask_best == 0 ? " (the default route); sacn:1-9%NAME selects another one" : ""));
}

Outcome check_igmp(const DoctorView& view) {
  const auto memberships = number_in(fs::path(view.find.proc_root) / "sys/net/ipv4/igmp_max_memberships");
  if (!memberships) return skipped("igmp_max_memberships cannot be read");
  // Sources open one socket for every 20 groups, the kernel's default.
  if (*memberships >= 20) return ok(fmt::format("{} groups per socket; more universes use more sockets", *memberships));
  return warn(
      fmt::format("{} groups per socket, the kernel's default is 20: many universes need many sockets", *memberships),
      "sudo sysctl -w net.ipv4.igmp_max_memberships=20");
}

Outcome check_rp_filter(const DoctorView& view) {
  const fs::path folder = fs::path(view.find.proc_root) / "sys/net/ipv4/conf";
  const std::uint64_t all = number_in(folder / "all/rp_filter").value_or(0);
  std::vector<std::string> strict;
  std::size_t up = 0;
  for (const Interface& interface : interfaces_of(view)) {
    if (!interface.is_up()) continue;
    ++up;
    // The higher of the two is used; 1 is strict, 2 is loose (ip-sysctl.rst).
    if (std::max(all, number_in(folder / interface.name / "rp_filter").value_or(0)) == 1)
      strict.push_back(interface.name);
  }
  if (strict.empty() || up < 2) return ok("drops no DMX");
  return warn(
      fmt::format(
          "strict on {}: with several interfaces, frames are dropped silently if the route back to their sender "
          "is through another interface",
          fmt::join(strict, ", ")),
      "sudo sysctl -w net.ipv4.conf.all.rp_filter=2");
}

Outcome check_firewall(const DoctorView& view) {
  constexpr const char* kPorts = "sACN arrives on UDP port 5568, Art-Net on 6454";
  if (text_of(fs::path(view.etc_root) / "ufw/ufw.conf").find("ENABLED=yes") != std::string::npos)
    return warn(fmt::format("ufw is active; {}", kPorts), "sudo ufw allow 5568/udp && sudo ufw allow 6454/udp");
  if (!process_of(view, "firewalld").empty())
    return warn(fmt::format("firewalld is running; {}", kPorts),
                "sudo firewall-cmd --permanent --add-port=5568/udp --add-port=6454/udp && sudo firewall-cmd --reload");
  if (!line_of(fs::path(view.find.proc_root) / "net/ip_tables_names").empty())
    return warn(fmt::format("iptables has tables; {}", kPorts), "sudo iptables -L INPUT -n");
  return ok("neither ufw nor firewalld; rules of nftables are not visible to this user");
}

Outcome check_snooping(const DoctorView& view) {
  const fs::path folder = fs::path(view.find.sys_root) / "class/net";
  for (const Interface& interface : interfaces_of(view)) {
    const fs::path bridge = folder / interface.name / "bridge";
    if (number_in(bridge / "multicast_snooping").value_or(0) != 1) continue;
    if (number_in(bridge / "multicast_querier").value_or(0) == 1) continue;
    return warn(fmt::format("the bridge {} snoops IGMP without a querier; unless another device queries, groups expire "
                            "after some minutes, and sACN stops",
                            interface.name),
                fmt::format("echo 1 | sudo tee /sys/class/net/{}/bridge/multicast_querier", interface.name));
  }
  return ok(
      "no problem on bridges of this machine. External switches cannot be checked: if sACN stops after some minutes, "
      "they need a querier, or use unicast (sacn:1@10.0.0.7)");
}

// "olad (812)" for the process that has the socket open; "a process of another user" if it is not visible.
std::string owner_of_socket(const DoctorView& view, const std::string& inode) {
  const std::string wanted = fmt::format("socket:[{}]", inode);
  for (const std::string& process : drivers::processes(view.find.proc_root)) {
    const std::vector<std::string> files = drivers::open_files(view.find.proc_root, process);
    if (std::find(files.begin(), files.end(), wanted) != files.end())
      return fmt::format("{} ({})", drivers::process_name(view.find.proc_root, process), process);
  }
  return "a process of another user";
}

Outcome check_udp_ports(const DoctorView& view) {
  std::set<std::string> users;
  bool readable = false;
  for (const char* const file : {"net/udp", "net/udp6"}) {
    std::istringstream table(text_of(fs::path(view.find.proc_root) / file));
    std::string line;
    std::getline(table, line);  // names of the columns
    readable = readable || !line.empty();
    while (std::getline(table, line)) {
      const auto words = words_of(line);
      if (words.size() < 10) continue;
      const auto port = number_of(std::string_view(words[1]).substr(words[1].find(':') + 1), 16);
      if (port == drivers::kSacnPort || port == drivers::kArtnetPort)
        users.insert(fmt::format("{} by {}", *port, owner_of_socket(view, words[9])));
    }
  }
  if (!readable) return skipped("the table of sockets cannot be read");
  if (users.empty()) return ok("5568 (sACN) and 6454 (Art-Net) are free");
  return warn(fmt::format("in use: {}. Multicast and broadcast reach all programs that share a port, unicast only one",
                          fmt::join(users, "; ")),
              "stop the program if it is not needed, or send unicast to another UDP port: sacn:1@10.0.0.7:5569");
}

// Bytes of a socket buffer that one sACN datagram of 638 bytes takes, with the kernel's bookkeeping. 2304 is a datagram
// in a buffer of 2 KiB with 256 bytes of bookkeeping.
constexpr std::uint64_t kDatagramBytes = 2'304;
constexpr std::uint64_t kFramesHz = 44;
constexpr std::uint64_t kStallMs = 150;
constexpr std::uint64_t kReceiveBufferRequestedBytes = 4 << 20;  // drivers/net/udp.cpp
constexpr std::uint64_t kUniversesGood = 512;
constexpr std::uint64_t kUniversesLeast = 9;

Outcome check_receive_buffers(const DoctorView& view) {
  const auto max_bytes = number_in(fs::path(view.find.proc_root) / "sys/net/core/rmem_max");
  if (!max_bytes) return skipped("rmem_max cannot be read");
  const bool privileged = has_capability(view, kCapNetAdmin);
  const std::uint64_t universes = universes_through_a_stall(privileged ? kReceiveBufferRequestedBytes : *max_bytes);
  const std::string seen = fmt::format("{} bytes{} hold {} universes of 44 Hz through a stall of {} ms", *max_bytes,
                                       privileged ? " (this user may exceed it)" : "", universes, kStallMs);
  if (universes >= kUniversesGood) return ok(seen);
  const std::string fix =
      "echo net.core.rmem_max=4194304 | sudo tee /etc/sysctl.d/70-footlight.conf && sudo sysctl --system";
  return universes < kUniversesLeast ? failed(seen, fix) : warn(seen, fix);
}

Outcome check_send_buffers(const DoctorView& view) {
  const auto bytes = number_in(fs::path(view.find.proc_root) / "sys/net/core/wmem_default");
  if (!bytes) return skipped("wmem_default cannot be read");
  const std::uint64_t universes = *bytes / kDatagramBytes;
  const std::string seen = fmt::format("{} bytes hold {} universes at once", *bytes, universes);
  if (universes >= kUniversesLeast) return ok(seen);
  return warn(seen, "sudo sysctl -w net.core.wmem_default=212992");
}

// --- Time
// --------------------------------------------------------------------------------------------------------------

Outcome check_real_time(const DoctorView& view) {
  constexpr auto kNeeded = static_cast<std::uint64_t>(drivers::kRealTimePriority);
  if (has_capability(view, kCapSysNice)) return ok("allowed by privilege");
  if (view.realtime_max >= kNeeded) return ok(fmt::format("priority {} allowed", view.realtime_max));
  const std::string fix = fmt::format(
      "echo '@plugdev - rtprio {0}' | sudo tee /etc/security/limits.d/70-footlight.conf, then log in again; in a unit: "
      "LimitRTPRIO={0}",
      kNeeded);
  if (view.realtime_max > 0)
    return warn(fmt::format("priority {} allowed, {} needed", view.realtime_max, kNeeded), fix);
  return warn("not allowed: a busy machine may delay frames", fix);
}

Outcome check_clock_source(const DoctorView& view) {
  const fs::path folder = fs::path(view.find.sys_root) / "devices/system/clocksource/clocksource0";
  const std::string current = line_of(folder / "current_clocksource");
  if (current.empty()) return skipped("cannot be read");
  if (current != "hpet" && current != "acpi_pm" && current != "jiffies" && current != "pit") return ok(current);
  const bool has_tsc = line_of(folder / "available_clocksource").find("tsc") != std::string::npos;
  return warn(fmt::format("{}: reading the time is slow", current),
              has_tsc ? "echo tsc | sudo tee /sys/devices/system/clocksource/clocksource0/current_clocksource"
                      : "find out why the kernel rejected a better one: sudo dmesg | grep -i clocksource");
}

Outcome check_timers(const DoctorView& view) {
  if (view.clock_resolution_ns <= kNsPerUs) return ok(fmt::format("{} ns", view.clock_resolution_ns));
  return warn(fmt::format("{} us: the kernel has no high-resolution timers, frames are late by up to that time",
                          view.clock_resolution_ns / kNsPerUs),
              "boot without highres=off, or use a kernel with CONFIG_HIGH_RES_TIMERS");
}

Outcome check_governor(const DoctorView& view) {
  const fs::path folder = fs::path(view.find.sys_root) / "devices/system/cpu";
  std::set<std::string> governors;
  bool by_processor = false;  // intel_pstate and amd-pstate: "powersave" only prefers low clocks
  for (const std::string& name : names_in(folder)) {
    const std::string governor = line_of(folder / name / "cpufreq/scaling_governor");
    if (!name.starts_with("cpu") || governor.empty()) continue;
    governors.insert(governor);
    const std::string driver = line_of(folder / name / "cpufreq/scaling_driver");
    by_processor =
        by_processor || driver == "intel_pstate" || driver.starts_with("amd-pstate-epp") || driver == "amd_pstate_epp";
  }
  if (governors.empty()) return skipped("the clock of the processor is not visible, as in virtual machines");
  if (governors.contains("powersave") && !by_processor)
    return warn("powersave: the processor stays at its lowest clock",
                "echo schedutil | sudo tee /sys/devices/system/cpu/cpu*/cpufreq/scaling_governor");
  return ok(fmt::format("{}", fmt::join(governors, ", ")));
}

// --- Service
// -----------------------------------------------------------------------------------------------------------

Outcome check_unit(const DoctorView& view) {
  constexpr const char* kUnit = "footlight.service";
  const fs::path own = fs::path(view.etc_root) / "systemd/system";
  const auto units = folders_of(view, "systemd/system");
  if (std::none_of(units.begin(), units.end(), [&](const fs::path& folder) { return is_there(folder / kUnit); }))
    return skipped("not installed as a service");
  const bool enabled = is_there(own / "multi-user.target.wants" / kUnit);
  const bool running = is_there(fs::path(view.find.sys_root) / "fs/cgroup/system.slice" / kUnit);
  if (!running)
    return warn(fmt::format("installed{}, but not running", enabled ? " and enabled" : ""),
                "systemctl status footlight; sudo systemctl enable --now footlight");
  if (!enabled)
    return warn("running, but not enabled, so it will not start with the machine", "sudo systemctl enable footlight");
  return ok("enabled and running");
}

constexpr Check kChecks[] = {
    {"devices", "DMX devices", check_devices},
    {"hidraw", "HID devices", check_hidraw},
    {"gpio", "GPIO chips", check_gpio},
    {"udev-rules", "udev rules", check_udev_rules},
    {"groups", "groups", check_groups},
    {"ftdi-sio", "ftdi_sio", check_ftdi_sio},
    {"modem-manager", "ModemManager", check_modem_manager},
    {"brltty", "brltty", check_brltty},
    {"interfaces", "network interfaces", check_interfaces},
    {"multicast-route", "multicast route", check_multicast_route},
    {"igmp", "multicast groups", check_igmp},
    {"igmp-snooping", "IGMP snooping", check_snooping},
    {"rp-filter", "reverse path filter", check_rp_filter},
    {"firewall", "firewall", check_firewall},
    {"udp-ports", "UDP ports", check_udp_ports},
    {"receive-buffers", "receive buffers", check_receive_buffers},
    {"send-buffers", "send buffers", check_send_buffers},
    {"real-time", "real-time priority", check_real_time},
    {"clock-source", "clock source", check_clock_source},
    {"timers", "timer resolution", check_timers},
    {"governor", "CPU governor", check_governor},
    {"service", "systemd service", check_unit},
};

}  // namespace

std::string_view name_of(Verdict verdict) {
  switch (verdict) {
    case Verdict::kOk: return "ok";
    case Verdict::kWarn: return "warn";
    case Verdict::kFail: return "fail";
    case Verdict::kSkipped: return "skipped";
  }
  return "";
}

std::span<const Check> doctor_checks() { return kChecks; }

std::uint64_t universes_through_a_stall(std::uint64_t rmem_max_bytes) {
  // The kernel doubles the requested size (socket(7), SO_RCVBUF).
  const std::uint64_t bytes = 2 * std::min(rmem_max_bytes, kReceiveBufferRequestedBytes);
  return bytes * 1'000 / (kDatagramBytes * kFramesHz * kStallMs);
}

DoctorView this_machine() {
  DoctorView view;
  view.user_id = ::geteuid();
  if (const passwd* user = ::getpwuid(view.user_id)) view.user_name = user->pw_name;
  std::vector<gid_t> ids(static_cast<std::size_t>(std::max(::getgroups(0, nullptr), 0)));
  const int count = ::getgroups(static_cast<int>(ids.size()), ids.data());
  ids.resize(static_cast<std::size_t>(std::max(count, 0)));
  ids.push_back(::getegid());
  for (const gid_t id : ids)
    if (const group* entry = ::getgrgid(id)) view.groups.emplace_back(entry->gr_name);
  rlimit limit{};
  if (::getrlimit(RLIMIT_RTPRIO, &limit) == 0) view.realtime_max = limit.rlim_max;
  timespec resolution{};
  if (::clock_getres(CLOCK_MONOTONIC, &resolution) == 0)
    view.clock_resolution_ns = static_cast<DurationNs>(resolution.tv_sec) * kNsPerS + resolution.tv_nsec;
  return view;
}

}  // namespace footlight::tools
