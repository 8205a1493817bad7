#include "drivers/gpio/gpio_list.h"

#include <dirent.h>
#include <fcntl.h>
#include <grp.h>
#include <linux/gpio.h>
#include <pwd.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <string_view>

#include <fmt/format.h>

#include "drivers/gpio/gpio_chip.h"

namespace footlight::drivers {
namespace {

constexpr std::string_view kChip = "gpiochip";
constexpr unsigned kReadWrite = 06;

// opendir() instead of std::filesystem: the emulated /sys of the tests redirects this call.
std::vector<unsigned> chip_numbers(const std::string& sys_root) {
  std::vector<unsigned> numbers;
  DIR* const dir = ::opendir((sys_root + "/bus/gpio/devices").c_str());
  if (dir == nullptr) return numbers;
  while (const dirent* entry = ::readdir(dir)) {
    const std::string_view name = entry->d_name;
    if (!name.starts_with(kChip)) continue;
    unsigned number = 0;
    const auto [end, error] = std::from_chars(name.data() + kChip.size(), name.data() + name.size(), number);
    if (error == std::errc{} && end == name.data() + name.size()) numbers.push_back(number);
  }
  ::closedir(dir);
  std::sort(numbers.begin(), numbers.end());
  return numbers;
}

// device: its link in /sys/bus/gpio/devices. The chip is in the folder of its parent device.
std::string driver_of(const std::string& device) {
  std::array<char, 4096> target;
  const ssize_t size = ::readlink((device + "/../driver").c_str(), target.data(), target.size());
  if (size <= 0) return {};
  const std::string_view path(target.data(), static_cast<std::size_t>(size));
  return std::string(path.substr(path.find_last_of('/') + 1));
}

std::string user_name(uid_t id) {
  const passwd* const user = ::getpwuid(id);
  return user != nullptr ? user->pw_name : std::to_string(id);
}

std::string group_name(gid_t id) {
  const group* const found = ::getgrgid(id);
  return found != nullptr ? found->gr_name : std::to_string(id);
}

std::string open_to(const FoundGpioChip& chip) {
  if ((chip.mode & kReadWrite) == kReadWrite) return "everybody";
  std::string who = "root";
  if (chip.owner != "root" && ((chip.mode >> 6) & kReadWrite) == kReadWrite) who += fmt::format(" and {}", chip.owner);
  if (((chip.mode >> 3) & kReadWrite) == kReadWrite) who += fmt::format(" and the group {}", chip.group);
  return who;
}

void query(FoundGpioChip& chip) {
  // Non-blocking: a regular file or a FIFO with that name must not block this call.
  const int fd = ::open(chip.node.c_str(), O_RDONLY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) return;
  gpiochip_info info{};
  if (::ioctl(fd, GPIO_GET_CHIPINFO_IOCTL, &info) == 0) {
    chip.label.assign(info.label, ::strnlen(info.label, sizeof info.label));
    chip.line_count = static_cast<int>(info.lines);
  }
  ::close(fd);
}

void judge(FoundGpioChip& chip, const FindOptions& options) {
  const auto verdict = [&](Readiness readiness, std::string reason, std::string remedy = {}) {
    chip.readiness = readiness;
    chip.reason = std::move(reason);
    chip.remedy = std::move(remedy);
  };
  struct stat node {};
  if (::stat(chip.node.c_str(), &node) != 0)
    return verdict(Readiness::kNoNode,
                   fmt::format("{} does not exist; start the container with access to it", chip.node));
  chip.owner = user_name(node.st_uid);
  chip.group = group_name(node.st_gid);
  chip.mode = node.st_mode & 07777u;
  chip.open_to = open_to(chip);
  const int error = node_access(options, chip.node);
  if (error != 0) {
    // If the machine has a group for it, joining the group is simpler than a new rule.
    const bool by_group = chip.group != "root" && ((chip.mode >> 3) & kReadWrite) == kReadWrite;
    return verdict(Readiness::kNoPermission,
                   fmt::format("{}: {}{}", chip.node, std::strerror(error),
                               by_group ? fmt::format("; members of {} may, from their next login", chip.group) : ""),
                   by_group ? fmt::format("sudo usermod -aG {} $USER", chip.group) : gpio_install_command());
  }
  query(chip);
  if (!built_with_gpio())
    verdict(Readiness::kUnsupported, "this build has no GPIO",
            "sudo apt install libgpiod-dev && cmake -B build -DFOOTLIGHT_GPIO=ON && cmake --build build");
}

}  // namespace

std::vector<FoundGpioChip> find_gpio_chips(const FindOptions& options) {
  std::vector<FoundGpioChip> chips;
  for (const unsigned number : chip_numbers(options.sys_root)) {
    FoundGpioChip chip;
    chip.name = fmt::format("{}{}", kChip, number);
    chip.node = fmt::format("{}/{}", options.dev_root, chip.name);
    chip.kernel_driver = driver_of(fmt::format("{}/bus/gpio/devices/{}", options.sys_root, chip.name));
    judge(chip, options);
    chips.push_back(std::move(chip));
  }
  return chips;
}

std::string gpio_install_command() {
  return "sudo cp udev/71-footlight-gpio.rules /etc/udev/rules.d/ && sudo udevadm control --reload && sudo udevadm "
         "trigger";
}

}  // namespace footlight::drivers
