#include "tests/kernel/vhci_socket.h"

#include <arpa/inet.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <doctest/doctest.h>
#include <fmt/format.h>

#include "tests/kernel/guest.h"

namespace footlight::testing {
namespace {

using drivers::mock::SetupPacket;

constexpr std::uint32_t kSubmit = 1, kUnlink = 2, kSubmitAnswer = 3, kUnlinkAnswer = 4;
constexpr int kFullSpeed = 2;
constexpr const char* kPlatform = "/sys/devices/platform";
constexpr const char* kFolder = "/sys/devices/platform/vhci_hcd.0/";  // the only one with the attributes

// For both directions and every command: 12 words, the high octet first; the last two of a request are a setup packet.
constexpr std::size_t kHeaderWords = 12;
using Header = std::array<std::uint32_t, kHeaderWords>;

TimeNs steady_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// The number of controllers that the kernel was built with. Each has a root hub.
int controller_count() {
  int count = 0;
  while (std::filesystem::exists(fmt::format("{}/vhci_hcd.{}", kPlatform, count))) ++count;
  REQUIRE(count > 0);
  return count;
}

// The sockets of all root hubs.
int kernel_socket_count() {
  int count = 0;
  std::ifstream(std::string(kFolder) + "nports") >> count;
  return count;
}

bool write_file(const std::string& path, const std::string& text) {
  const int fd = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
  if (fd < 0) return false;
  const bool written = ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  ::close(fd);
  return written;
}

}  // namespace

VhciSocket::VhciSocket(drivers::mock::UsbModel& model, int socket)
    : model_(model),
      controller_(socket % controller_count()),
      hub_port_(socket / controller_count() + 1),
      kernel_socket_(controller_ * (kernel_socket_count() / controller_count()) + hub_port_ - 1),
      wake_fd_(::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK)) {
  REQUIRE(wake_fd_ >= 0);
}

VhciSocket::~VhciSocket() {
  unplug();
  ::close(wake_fd_);
}

void VhciSocket::plug() {
  REQUIRE(fd_ < 0);
  int ends[2];
  REQUIRE(::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) == 0);
  {
    const std::lock_guard lock(mutex_);
    is_unplugged_ = false;
    in_flight_.clear();
    model_.power_on();
  }
  // The kernel frees the socket of an unplugged device with a delay.
  const std::string words = fmt::format("{} {} {} {}", kernel_socket_, ends[1], kernel_socket_ + 1, kFullSpeed);
  const TimeNs give_up_ns = steady_now_ns() + 60 * kNsPerS;
  while (!write_file(std::string(kFolder) + "attach", words)) {
    REQUIRE(steady_now_ns() < give_up_ns);
    ::poll(nullptr, 0, 5);
  }
  ::close(ends[1]);
  fd_ = ends[0];
  thread_ = std::thread([this] { serve(); });
}

void VhciSocket::unplug() {
  if (fd_ < 0) return;
  {
    const std::lock_guard lock(mutex_);
    is_unplugged_ = true;
    for (const Transfer& transfer : in_flight_) answer_submit(transfer, -ESHUTDOWN, {});
    in_flight_.clear();
  }
  // First from the USB core, which then refuses transfers itself. Those that come while vhci_hcd shuts down the
  // connection would run into their timeout of 5 s.
  if (const std::string device = device_folder(); !device.empty()) write_file(device + "/remove", "1");
  write_file(std::string(kFolder) + "detach", std::to_string(kernel_socket_));
  thread_.join();  // the kernel closes its end
  ::close(fd_);
  fd_ = -1;
}

std::string VhciSocket::device_folder() const {
  for (const auto& hub : std::filesystem::directory_iterator(fmt::format("{}/vhci_hcd.{}", kPlatform, controller_))) {
    const std::string name = hub.path().filename();
    if (!name.starts_with("usb")) continue;
    const auto folder = hub.path() / fmt::format("{}-{}", name.substr(3), hub_port_);
    if (std::filesystem::exists(folder)) return folder;
  }
  return {};
}

std::string VhciSocket::port_path() const {
  std::string name;
  const bool configured = eventually([&] {
    const std::filesystem::path folder = device_folder();
    name = folder.filename();
    return !name.empty() && std::filesystem::exists(folder / (name + ":1.0"));
  });
  REQUIRE_MESSAGE(configured, "the kernel configures no device in vhci socket " << kernel_socket_);
  return name;
}

void VhciSocket::wake() {
  changed_.notify_all();
  const std::uint64_t one = 1;
  (void)!::write(wake_fd_, &one, sizeof one);
}

void VhciSocket::serve() {
  while (true) {
    const TimeNs next_ns = complete_in_time();
    const DurationNs left_ns = std::clamp<DurationNs>(next_ns - steady_now_ns(), 0, kNsPerS);
    const timespec left{.tv_sec = left_ns / kNsPerS, .tv_nsec = left_ns % kNsPerS};
    pollfd fds[2] = {{fd_, POLLIN, 0}, {wake_fd_, POLLIN, 0}};
    if (::ppoll(fds, 2, &left, nullptr) < 0) continue;
    std::uint64_t count = 0;
    if (fds[1].revents != 0) (void)!::read(wake_fd_, &count, sizeof count);
    if (fds[0].revents != 0 && !take_request()) return;
  }
}

bool VhciSocket::receive(void* into, std::size_t size) {
  return size == 0 || ::recv(fd_, into, size, MSG_WAITALL) == static_cast<ssize_t>(size);
}

bool VhciSocket::take_request() {
  Header words;
  if (!receive(words.data(), sizeof words)) return false;
  const auto* const setup = reinterpret_cast<const std::uint8_t*>(&words[10]);
  const std::uint32_t command = ntohl(words[0]);
  Transfer transfer;
  transfer.sequence = ntohl(words[1]);
  if (command == kUnlink) {
    take_unlink(transfer.sequence, ntohl(words[5]));
    return true;
  }
  if (command != kSubmit) return false;
  transfer.to_host = ntohl(words[3]) != 0;
  transfer.endpoint = static_cast<std::uint8_t>(ntohl(words[4]) | (transfer.to_host ? 0x80u : 0u));
  transfer.size = ntohl(words[6]);
  if (!transfer.to_host) {
    transfer.bytes.resize(transfer.size);
    if (!receive(transfer.bytes.data(), transfer.size)) return false;
  }
  take_submit(std::move(transfer), setup);
  return true;
}

void VhciSocket::take_submit(Transfer transfer, const std::uint8_t* setup) {
  const std::lock_guard lock(mutex_);
  if (is_unplugged_) return answer_submit(transfer, -ESHUTDOWN, {});
  const TimeNs now_ns = steady_now_ns();
  if ((transfer.endpoint & 0x7F) != 0) {
    const int latency_ms = transfer.to_host ? model_.in_latency_ms(transfer.endpoint) : 0;
    transfer.due_ns = latency_ms < 0 ? kTimeNever : now_ns + latency_ms * kNsPerMs;
    in_flight_.push_back(std::move(transfer));
    return;
  }
  (void)model_.pass_time(now_ns);
  const auto word_at = [&](int i) { return static_cast<std::uint16_t>(setup[i] | setup[i + 1] << 8); };
  const auto bytes = model_.control({setup[0], setup[1], word_at(2), word_at(4), word_at(6)}, transfer.bytes);
  answer_submit(transfer, bytes ? 0 : -EPIPE, bytes.value_or(Bytes{}));
  changed_.notify_all();
}

void VhciSocket::take_unlink(std::uint32_t sequence, std::uint32_t victim) {
  const std::lock_guard lock(mutex_);
  const auto found = std::find_if(in_flight_.begin(), in_flight_.end(),
                                  [&](const Transfer& transfer) { return transfer.sequence == victim; });
  const int status = found == in_flight_.end() ? 0 : -ECONNRESET;  // 0: it has ended before
  if (found != in_flight_.end()) in_flight_.erase(found);
  send_answer(kUnlinkAnswer, sequence, status, 0, {});
}

TimeNs VhciSocket::complete_in_time() {
  const std::lock_guard lock(mutex_);
  const TimeNs now_ns = steady_now_ns();
  (void)model_.pass_time(now_ns);
  // The data of one transfer may end another one that is before it in the list.
  while (end_some(now_ns)) changed_.notify_all();
  TimeNs next_ns = model_.pass_time(now_ns);
  for (const Transfer& transfer : in_flight_)
    if (transfer.to_host) next_ns = std::min(next_ns, transfer.due_ns);
  return next_ns;
}

// True: at least one has ended.
bool VhciSocket::end_some(TimeNs now_ns) {
  std::uint64_t waiting = 0;  // endpoints: a transfer waits for the earlier ones
  bool ended_one = false;
  for (auto transfer = in_flight_.begin(); transfer != in_flight_.end();) {
    const std::uint64_t endpoint = std::uint64_t{1} << (transfer->endpoint & 0x1F) << (transfer->to_host ? 32 : 0);
    if ((waiting & endpoint) == 0 && run(*transfer, now_ns)) {
      transfer = in_flight_.erase(transfer);
      ended_one = true;
      continue;
    }
    waiting |= endpoint;
    ++transfer;
  }
  return ended_one;
}

// False: not yet.
bool VhciSocket::run(Transfer& transfer, TimeNs now_ns) {
  if (transfer.to_host) {
    if (!model_.has_data(transfer.endpoint) && transfer.due_ns > now_ns) return false;
    answer_submit(transfer, 0, model_.data_in(transfer.endpoint, transfer.size));
    return true;
  }
  const std::size_t count = std::min(model_.room(transfer.endpoint), transfer.bytes.size() - transfer.given);
  model_.data_out(transfer.endpoint, std::span(transfer.bytes).subspan(transfer.given, count));
  transfer.given += count;
  if (transfer.given < transfer.bytes.size()) return false;
  answer_submit(transfer, 0, {});
  return true;
}

void VhciSocket::answer_submit(const Transfer& transfer, int status, const Bytes& bytes) {
  const std::size_t count = transfer.to_host ? std::min<std::size_t>(bytes.size(), transfer.size) : 0;
  const std::size_t sent = status == 0 ? transfer.bytes.size() : 0;
  const auto actual_size = static_cast<std::uint32_t>(transfer.to_host ? count : sent);
  send_answer(kSubmitAnswer, transfer.sequence, status, actual_size,
              Bytes(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count)));
}

void VhciSocket::send_answer(std::uint32_t command, std::uint32_t sequence, int status, std::uint32_t actual_size,
                             const Bytes& bytes) {
  Header words{};
  words[0] = htonl(command);
  words[1] = htonl(sequence);
  words[5] = htonl(static_cast<std::uint32_t>(status));
  words[6] = htonl(actual_size);
  Bytes packet(sizeof words + bytes.size());
  std::memcpy(packet.data(), words.data(), sizeof words);
  std::copy(bytes.begin(), bytes.end(), packet.begin() + sizeof words);
  (void)!::send(fd_, packet.data(), packet.size(), MSG_NOSIGNAL);  // fails only while it is unplugged
}

}  // namespace footlight::testing
