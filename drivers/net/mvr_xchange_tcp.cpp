#include "drivers/net/mvr_xchange_tcp.h"

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <memory>
#include <utility>

#include <fmt/format.h>
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include "drivers/net/udp.h"

namespace footlight::drivers {
namespace {

constexpr std::size_t kReadBytes = 64u << 10;
constexpr std::size_t kStepBytesMax = 4u << 20;  // of one connection in one step, so that the others have their turn
constexpr DurationNs kAcceptRestNs = 200 * kNsPerMs;
constexpr std::size_t kFaultsMax = 100;

sockaddr_in socket_address(const MvrAddress& address) {
  sockaddr_in out = {};
  out.sin_family = AF_INET;
  out.sin_port = htons(address.port);
  out.sin_addr.s_addr = htonl(address.ipv4);
  return out;
}

bool would_block(int error_number) { return error_number == EAGAIN || error_number == EWOULDBLOCK; }

std::string seconds_text(DurationNs ns) { return fmt::format("{} s", ns / kNsPerS); }

// What read() returned: bytes, nothing yet, the end, or an errno.
struct Got {
  std::size_t size = 0;
  bool nothing = false;
  bool end = false;
  int error_number = 0;
};

Got read_some(int fd, std::span<std::uint8_t> buffer) {
  while (true) {
    const ssize_t size = ::recv(fd, buffer.data(), buffer.size(), 0);
    if (size > 0) return {.size = static_cast<std::size_t>(size)};
    if (size == 0) return {.end = true};
    if (errno == EINTR) continue;
    if (would_block(errno)) return {.nothing = true};
    return {.error_number = errno};
  }
}

Got send_some(int fd, std::span<const std::uint8_t> bytes) {
  while (true) {
    const ssize_t size = ::send(fd, bytes.data(), bytes.size(), MSG_NOSIGNAL);
    if (size >= 0) return {.size = static_cast<std::size_t>(size)};
    if (errno == EINTR) continue;
    if (would_block(errno)) return {.nothing = true};
    return {.error_number = errno};
  }
}

Result<Fd> open_socket() {
  Fd socket(::socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error("MVR-xchange", "open a TCP socket", errno));
  return socket;
}

void set_option(const Fd& socket, int level, int option) {
  const int on = 1;
  (void)::setsockopt(socket.get(), level, option, &on, sizeof on);
}

}  // namespace

std::string text_of(const MvrAddress& address) {
  return fmt::format("{}:{}", text_of_ipv4(address.ipv4), address.port);
}

Result<MvrAddress> find_mvr_address(std::string_view text) {
  const std::size_t colon = text.rfind(':');
  const std::string host(text.substr(0, colon));
  MvrAddress address;
  const std::string_view digits = colon == std::string_view::npos ? "" : text.substr(colon + 1);
  const auto [next, fault] = std::from_chars(digits.data(), digits.data() + digits.size(), address.port);
  if (host.empty() || fault != std::errc() || next != digits.data() + digits.size() || address.port == 0) {
    return fail(ErrorCode::kBadInput, "{}: expected the address of a station, such as 10.0.0.7:42424", text);
  }
  addrinfo hints = {};
  hints.ai_family = AF_INET;
  hints.ai_socktype = SOCK_STREAM;
  addrinfo* found = nullptr;
  const int error = ::getaddrinfo(host.c_str(), nullptr, &hints, &found);
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> owner(found, [](addrinfo* list) {
    if (list != nullptr) ::freeaddrinfo(list);
  });
  if (error != 0 || found == nullptr) {
    return fail(ErrorCode::kNotFound,
                "{}: the name {} has no IPv4 address ({}); use the address of the station, such as "
                "10.0.0.7:42424",
                text, host, ::gai_strerror(error));
  }
  sockaddr_in ipv4 = {};
  std::memcpy(&ipv4, found->ai_addr, sizeof ipv4);
  address.ipv4 = ntohl(ipv4.sin_addr.s_addr);
  return address;
}

Result<std::unique_ptr<MvrServer>> MvrServer::open(const MvrAddress& listen, MvrStation& station) {
  FL_ASSIGN(Fd socket, open_socket());
  set_option(socket, SOL_SOCKET, SO_REUSEADDR);  // a port whose last connections are still closing is free
  const sockaddr_in wanted = socket_address(listen);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&wanted), sizeof wanted) != 0 ||
      ::listen(socket.get(), 16) != 0) {
    if (errno == EADDRINUSE) {
      return fail(ErrorCode::kIo, "MVR-xchange: TCP port {} is taken; find its program with 'ss -tlpn', or use another",
                  listen.port);
    }
    return tl::unexpected(net_error("MVR-xchange", fmt::format("listen on {}", text_of(listen)), errno));
  }
  sockaddr_in bound = {};
  socklen_t size = sizeof bound;
  (void)::getsockname(socket.get(), reinterpret_cast<sockaddr*>(&bound), &size);
  return std::unique_ptr<MvrServer>(new MvrServer(std::move(socket), ntohs(bound.sin_port), station));
}

MvrServer::MvrServer(Fd listener, std::uint16_t port, MvrStation& station)
    : station_(station), listener_(std::move(listener)), port_(port) {}

void MvrServer::add_descriptors(std::vector<pollfd>& waiting) const {
  if (!accept_rests_) waiting.push_back({listener_.get(), POLLIN, 0});
  for (const Connection& connection : connections_) {
    const bool sends = !connection.answering.to_send().empty();
    waiting.push_back({connection.socket.get(), static_cast<short>(sends ? POLLOUT : POLLIN), 0});
  }
}

void MvrServer::accept_all(TimeNs now_ns) {
  if (accept_rests_ && now_ns < accept_ns_) return;
  accept_rests_ = false;
  for (std::size_t i = 0; i < kMvrConnectionsMax; ++i) {
    sockaddr_in from = {};
    socklen_t size = sizeof from;
    Fd socket(::accept4(listener_.get(), reinterpret_cast<sockaddr*>(&from), &size, SOCK_NONBLOCK | SOCK_CLOEXEC));
    if (!socket) {
      if (errno == EINTR || errno == ECONNABORTED) continue;
      if (would_block(errno)) return;
      accept_rests_ = true;  // no descriptors left: the connection stays in the queue, and poll() would return at once
      accept_ns_ = now_ns + kAcceptRestNs;
      return;
    }
    set_option(socket, IPPROTO_TCP, TCP_NODELAY);
    if (connections_.size() >= kMvrConnectionsMax) {
      const auto silent =
          std::min_element(connections_.begin(), connections_.end(),
                           [](const Connection& a, const Connection& b) { return a.moved_ns < b.moved_ns; });
      add_fault(*silent, "closed for a new one; too many connections");
      connections_.erase(silent);
    }
    connections_.push_back(
        {std::move(socket), {ntohl(from.sin_addr.s_addr), ntohs(from.sin_port)}, MvrAnswering(station_), now_ns});
  }
}

void MvrServer::add_fault(const Connection& connection, std::string_view text) {
  if (faults_.size() < kFaultsMax) faults_.push_back(fmt::format("{}: {}", text_of(connection.peer), text));
}

std::vector<std::string> MvrServer::take_faults() { return std::exchange(faults_, {}); }

bool MvrServer::step(Connection& connection, TimeNs now_ns) {
  std::array<std::uint8_t, kReadBytes> buffer;
  const int fd = connection.socket.get();
  for (std::size_t moved = 0; moved < kStepBytesMax;) {
    const bool sends = !connection.answering.to_send().empty();
    const Got got = sends ? send_some(fd, connection.answering.to_send()) : read_some(fd, buffer);
    if (got.nothing) break;
    if (got.end && connection.answering.idle()) return false;
    if (got.end || got.error_number != 0) {
      add_fault(connection, got.end ? "closed within a message" : std::strerror(got.error_number));
      return false;
    }
    moved += got.size;
    const bool begins = connection.answering.idle();
    const Status moves =
        sends ? connection.answering.sent(got.size) : connection.answering.receive(std::span(buffer).first(got.size));
    if (!moves) {
      add_fault(connection, moves.error().message);
      return false;
    }
    const bool ends = connection.answering.idle() || !connection.answering.to_send().empty();
    if (sends || begins || ends) connection.moved_ns = now_ns;
  }
  if (connection.answering.idle() || now_ns - connection.moved_ns < kMvrSilenceNs) return true;
  add_fault(connection, fmt::format("no whole message within {}", seconds_text(kMvrSilenceNs)));
  return false;
}

void MvrServer::step(TimeNs now_ns) {
  accept_all(now_ns);
  std::erase_if(connections_, [&](Connection& connection) { return !step(connection, now_ns); });
}

Result<std::unique_ptr<MvrClient>> MvrClient::open(std::string name, const MvrAddress& to, const MvrMessage& request,
                                                   TimeNs now_ns, MvrFileSink* sink) {
  FL_ASSIGN(Fd socket, open_socket());
  set_option(socket, IPPROTO_TCP, TCP_NODELAY);
  const sockaddr_in address = socket_address(to);
  if (::connect(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 &&
      errno != EINPROGRESS) {
    return tl::unexpected(net_error(name, fmt::format("connect to {}", text_of(to)), errno));
  }
  return std::unique_ptr<MvrClient>(new MvrClient(std::move(name), to, std::move(socket), request, now_ns, sink));
}

MvrClient::MvrClient(std::string name, const MvrAddress& to, Fd socket, const MvrMessage& request, TimeNs now_ns,
                     MvrFileSink* sink)
    : name_(std::move(name)), to_(to), socket_(std::move(socket)), asking_(request, sink), moved_ns_(now_ns) {}

void MvrClient::add_descriptors(std::vector<pollfd>& waiting) const {
  if (!socket_) return;
  const bool sends = !connected_ || !asking_.to_send().empty();
  waiting.push_back({socket_.get(), static_cast<short>(sends ? POLLOUT : POLLIN), 0});
}

tl::unexpected<Error> MvrClient::failed(const Error& error) {
  socket_.reset();
  const std::string address = text_of(to_);
  const std::string where = name_ == address ? address : fmt::format("{} ({})", name_, address);
  return fail(error.code, "{}: {}", where, error.message);
}

Result<bool> MvrClient::step(TimeNs now_ns) {
  if (!socket_) return true;
  if (!connected_) {
    pollfd one = {socket_.get(), POLLOUT, 0};
    if (::poll(&one, 1, 0) > 0) {
      int error_number = 0;
      socklen_t size = sizeof error_number;
      (void)::getsockopt(socket_.get(), SOL_SOCKET, SO_ERROR, &error_number, &size);
      if (error_number != 0) {
        return failed({error_number == ETIMEDOUT ? ErrorCode::kTimeout : ErrorCode::kDisconnected,
                       fmt::format("cannot connect: {}; does the station run, and is this its port?",
                                   std::strerror(error_number))});
      }
      connected_ = true;
      moved_ns_ = now_ns;
    }
  }
  if (connected_) {
    auto done = move_bytes(now_ns);
    if (!done) return failed(done.error());
    if (*done) socket_.reset();
    if (*done) return true;
  }
  if (asking_.file_bytes() > 0 && now_ns - file_ns_ >= kMvrFileNs) {
    return failed({ErrorCode::kTimeout,
                   fmt::format("the file is not whole after {}; nothing is kept", seconds_text(kMvrFileNs))});
  }
  const DurationNs limit_ns = connected_ ? kMvrSilenceNs : kMvrConnectNs;
  if (now_ns - moved_ns_ < limit_ns) return false;
  if (asking_.file_bytes() > 0) {
    return failed({ErrorCode::kTimeout, fmt::format("less than {} KiB more of the file within {}; nothing is kept",
                                                    kMvrSlowestBytes >> 10, seconds_text(limit_ns))});
  }
  const char* const missing = !connected_ ? "connection" : "answer";
  return failed({ErrorCode::kTimeout, fmt::format("no {} within {}", missing, seconds_text(limit_ns))});
}

Result<bool> MvrClient::move_bytes(TimeNs now_ns) {
  std::array<std::uint8_t, kReadBytes> buffer;
  for (std::size_t moved = 0; moved < kStepBytesMax;) {
    const bool sends = !asking_.to_send().empty();
    const Got got = sends ? send_some(socket_.get(), asking_.to_send()) : read_some(socket_.get(), buffer);
    if (got.nothing) return false;
    if (got.error_number != 0) {
      return fail(ErrorCode::kDisconnected, "the connection is lost: {}", std::strerror(got.error_number));
    }
    if (got.end) {
      FL_TRY(asking_.closed());
      return true;
    }
    moved += got.size;
    if (sends) {
      asking_.sent(got.size);
      continue;
    }
    const std::uint64_t file_bytes = asking_.file_bytes();
    FL_TRY(asking_.receive(std::span(buffer).first(got.size)));
    if (file_bytes == 0 && asking_.file_bytes() > 0) file_ns_ = moved_ns_ = now_ns;
    if (asking_.file_bytes() >= moved_bytes_ + kMvrSlowestBytes) {
      moved_ns_ = now_ns;
      moved_bytes_ = asking_.file_bytes();
    }
    if (asking_.done()) return true;
  }
  return false;
}

}  // namespace footlight::drivers
