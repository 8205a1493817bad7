#include "tools/footlight/status/http_server.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <optional>
#include <vector>

#include <arpa/inet.h>
#include <microhttpd.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/time.h>
#include <sys/un.h>
#include <unistd.h>

#include "sim/core/clock.h"
#include "sim/core/no_signals.h"
#include "sim/system_clock.h"

namespace footlight::tools {
namespace {

constexpr std::size_t kConnectionsMax = 16;
constexpr unsigned kSilenceMaxS = 10;
constexpr std::size_t kConnectionBytesMax = 16u << 10;
constexpr std::size_t kAnswerBytesMax = 64u << 20;
constexpr std::string_view kUnix = "unix:";

std::optional<sockaddr_un> unix_address(const std::string& path) {
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  if (path.empty() || path.size() >= sizeof address.sun_path) return std::nullopt;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  return address;
}

std::optional<sockaddr_in> inet_address(const std::string& where) {
  const std::size_t colon = where.rfind(':');
  if (colon == std::string::npos) return std::nullopt;
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  std::uint16_t port = 0;
  const char* const end = where.data() + where.size();
  const auto [rest, trouble] = std::from_chars(where.data() + colon + 1, end, port);
  if (trouble != std::errc{} || rest != end) return std::nullopt;
  address.sin_port = htons(port);
  if (inet_pton(AF_INET, where.substr(0, colon).c_str(), &address.sin_addr) != 1) return std::nullopt;
  return address;
}

template <class Address>
const sockaddr* plain(const Address& address) {
  return reinterpret_cast<const sockaddr*>(&address);
}

bool has_listener(const sockaddr_un& address) {
  const int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  const bool connected = fd >= 0 && connect(fd, plain(address), sizeof address) == 0;
  const bool busy = !connected && errno == EAGAIN;
  if (fd >= 0) close(fd);
  return connected || busy;
}

Error system_error(std::string_view option, const std::string& where, int number) {
  const bool forbidden = number == EACCES || number == EPERM;
  const char* const next = number == EADDRINUSE      ? "another program uses it; choose another one"
                           : number == EADDRNOTAVAIL ? "this machine has no such address; see 'ip address'"
                           : number == ENOENT        ? "create the folder first"
                                                     : "choose a folder with write permission";
  return {forbidden ? ErrorCode::kPermission : ErrorCode::kIo,
          fmt::format("{} {}: {}; {}", option, where, std::strerror(number), next)};
}

}  // namespace

struct HttpServer::Daemon {
  HttpHandler handler;
  std::string socket_path;  // of a Unix socket; removed at the end if it is still this one
  dev_t device = 0;
  ino_t inode = 0;
  MHD_Daemon* mhd = nullptr;
  std::vector<int> connections;  // of the server's thread, oldest first

  ~Daemon() {
    if (mhd != nullptr) MHD_stop_daemon(mhd);
    struct stat now = {};
    const bool ours =
        !socket_path.empty() && lstat(socket_path.c_str(), &now) == 0 && now.st_dev == device && now.st_ino == inode;
    if (ours) unlink(socket_path.c_str());
  }

  // If all places are in use, the oldest connection is closed, so that slow clients cannot block others.
  static void on_connection(void* self, MHD_Connection* connection, void**, MHD_ConnectionNotificationCode code) {
    auto& fds = static_cast<Daemon*>(self)->connections;
    const int fd = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    if (code == MHD_CONNECTION_NOTIFY_CLOSED) {
      std::erase(fds, fd);
      return;
    }
    if (fds.size() >= kConnectionsMax) {
      shutdown(fds.front(), SHUT_RDWR);
      fds.erase(fds.begin());
    }
    fds.push_back(fd);
  }

  static void on_completed(void*, MHD_Connection*, void** state, MHD_RequestTerminationCode) {
    delete static_cast<std::string*>(*state);  // NOLINT(cppcoreguidelines-owning-memory)
    *state = nullptr;
  }

  bool is_owner(MHD_Connection* connection) const {
    if (socket_path.empty()) return false;
    const int fd = MHD_get_connection_info(connection, MHD_CONNECTION_INFO_CONNECTION_FD)->connect_fd;
    ucred peer = {};
    socklen_t size = sizeof peer;
    if (getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) return false;
    return peer.uid == 0 || peer.uid == geteuid();
  }

  static MHD_Result on_request(void* self, MHD_Connection* connection, const char* url, const char* method, const char*,
                               const char* upload, std::size_t* upload_size, void** state) {
    const auto& daemon = *static_cast<const Daemon*>(self);
    // Called once with the headers, then for each part of a body, then for the answer.
    if (*state == nullptr) {
      *state = new std::string();  // NOLINT(cppcoreguidelines-owning-memory): freed in on_completed()
      return MHD_YES;
    }
    std::string& body = *static_cast<std::string*>(*state);
    if (*upload_size != 0) {
      if (body.size() + *upload_size > kHttpBodyBytesMax) return MHD_NO;
      body.append(upload, *upload_size);
      *upload_size = 0;
      return MHD_YES;
    }
    HttpRequest request;
    request.method = std::string_view(method) == MHD_HTTP_METHOD_HEAD ? MHD_HTTP_METHOD_GET : method;
    request.path = url;
    request.body = body;
    request.from_owner = daemon.is_owner(connection);
    if (const char* universes = MHD_lookup_connection_value(connection, MHD_GET_ARGUMENT_KIND, "universes")) {
      request.universes = universes;
    }
    const HttpAnswer answer = daemon.handler(request);
    MHD_Response* const response = MHD_create_response_from_buffer(
        answer.body.size(), const_cast<char*>(answer.body.data()), MHD_RESPMEM_MUST_COPY);
    if (response == nullptr) return MHD_NO;
    MHD_add_response_header(response, MHD_HTTP_HEADER_CONTENT_TYPE, answer.type.c_str());
    const MHD_Result queued = MHD_queue_response(connection, static_cast<unsigned>(answer.status), response);
    MHD_destroy_response(response);
    return queued;
  }
};

Result<std::unique_ptr<HttpServer>> HttpServer::listen(std::string_view option, const std::string& where,
                                                       HttpHandler handler) {
  auto daemon = std::make_unique<Daemon>();
  daemon->handler = std::move(handler);
  const bool is_unix = where.rfind(kUnix, 0) == 0;
  const std::string path = is_unix ? where.substr(kUnix.size()) : "";
  const auto local = unix_address(path);
  const auto inet = inet_address(where);
  if (is_unix ? !local : !inet) {
    return fail(ErrorCode::kBadInput,
                "{} {}: expected an IPv4 address and a port (127.0.0.1:9477), or unix: and a file name of at most 107 "
                "bytes (unix:/run/footlight/metrics.sock)",
                option, where);
  }
  const int fd = socket(is_unix ? AF_UNIX : AF_INET, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return tl::unexpected(system_error(option, where, errno));
  const int on = 1;
  setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on);
  const auto bind_it = [&] {
    return is_unix ? bind(fd, plain(*local), sizeof *local) : bind(fd, plain(*inet), sizeof *inet);
  };
  int bound = bind_it();
  struct stat there = {};
  const bool taken = bound != 0 && is_unix && errno == EADDRINUSE;
  if (taken && lstat(path.c_str(), &there) == 0 && !S_ISSOCK(there.st_mode)) {
    close(fd);
    return fail(ErrorCode::kBadInput, "{} {}: this file exists and is not a socket; choose another name", option, path);
  }
  if (taken && !has_listener(*local)) {
    unlink(path.c_str());  // left by a program that was killed
    bound = bind_it();
  }
  if (bound == 0 && is_unix) {
    daemon->socket_path = path;
    if (lstat(path.c_str(), &there) == 0) {
      daemon->device = there.st_dev;
      daemon->inode = there.st_ino;
    }
    chmod(path.c_str(), 0666);
  }
  if (bound != 0 || ::listen(fd, static_cast<int>(kConnectionsMax)) != 0) {
    const int number = errno;
    close(fd);
    return tl::unexpected(system_error(option, where, number));
  }
  const NoSignals for_the_thread;
  daemon->mhd = MHD_start_daemon(MHD_USE_AUTO_INTERNAL_THREAD, 0, nullptr, nullptr, &Daemon::on_request, daemon.get(),
                                 MHD_OPTION_LISTEN_SOCKET, fd, MHD_OPTION_CONNECTION_LIMIT,
                                 static_cast<unsigned>(2 * kConnectionsMax), MHD_OPTION_CONNECTION_TIMEOUT,
                                 kSilenceMaxS, MHD_OPTION_CONNECTION_MEMORY_LIMIT, kConnectionBytesMax,
                                 MHD_OPTION_NOTIFY_CONNECTION, &Daemon::on_connection, daemon.get(),
                                 MHD_OPTION_NOTIFY_COMPLETED, &Daemon::on_completed, nullptr, MHD_OPTION_END);
  if (daemon->mhd == nullptr) {
    close(fd);
    return fail(ErrorCode::kIo, "{} {}: the server cannot start; see 'ulimit -n'", option, where);
  }
  return std::unique_ptr<HttpServer>(new HttpServer(std::move(daemon)));
}

HttpServer::HttpServer(std::unique_ptr<Daemon> daemon) : daemon_(std::move(daemon)) {}
HttpServer::~HttpServer() = default;

int HttpServer::port() const {
  const MHD_DaemonInfo* const info = MHD_get_daemon_info(daemon_->mhd, MHD_DAEMON_INFO_LISTEN_FD);
  sockaddr_in address = {};
  socklen_t size = sizeof address;
  if (getsockname(info->listen_fd, reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return address.sin_family == AF_INET ? ntohs(address.sin_port) : 0;
}

Result<HttpAnswer> http_request(const std::string& socket_path, std::string_view method, std::string_view target,
                                DurationNs patience_ns, std::string_view body) {
  const auto address = unix_address(socket_path);
  if (!address) return fail(ErrorCode::kBadInput, "{}: expected a file name of at most 107 bytes", socket_path);
  struct Closer {
    int fd;
    ~Closer() {
      if (fd >= 0) close(fd);
    }
  } const connection{socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0)};
  SystemClock clock;
  const TimeNs end_ns = clock.now_ns() + patience_ns;
  // False: timeout. The limits of the system apply to one call each.
  const auto limit_next_call = [&] {
    const DurationNs left_ns = end_ns - clock.now_ns();
    if (left_ns < kNsPerUs) return false;  // 0 would mean no limit
    timeval left = {};
    left.tv_sec = left_ns / kNsPerS;
    left.tv_usec = left_ns % kNsPerS / kNsPerUs;
    setsockopt(connection.fd, SOL_SOCKET, SO_RCVTIMEO, &left, sizeof left);
    setsockopt(connection.fd, SOL_SOCKET, SO_SNDTIMEO, &left, sizeof left);
    return true;
  };
  const auto refused = [&](int number) {
    const ErrorCode code = number == ENOENT                            ? ErrorCode::kNotFound
                           : number == EACCES || number == EPERM       ? ErrorCode::kPermission
                           : number == EAGAIN                          ? ErrorCode::kTimeout
                           : number == ECONNREFUSED || number == EPIPE ? ErrorCode::kDisconnected
                                                                       : ErrorCode::kIo;
    return fail(code, "{}: {}; check that 'footlight run' is running, as this user", socket_path,
                std::strerror(number));
  };
  if (!limit_next_call()) return refused(EAGAIN);
  if (connect(connection.fd, plain(*address), sizeof *address) != 0) return refused(errno);
  const std::string request =
      fmt::format("{} {} HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{}", method,
                  target, body.size(), body);
  for (std::size_t sent = 0; sent < request.size();) {
    if (!limit_next_call()) return refused(EAGAIN);
    const ssize_t now = send(connection.fd, request.data() + sent, request.size() - sent, MSG_NOSIGNAL);
    if (now <= 0) return refused(errno);
    sent += static_cast<std::size_t>(now);
  }
  std::string text;
  char buffer[16 * 1024];
  ssize_t count = 0;
  while (true) {
    if (!limit_next_call()) return refused(EAGAIN);
    count = recv(connection.fd, buffer, sizeof buffer, 0);
    if (count <= 0) break;
    text.append(buffer, static_cast<std::size_t>(count));
    if (text.size() > kAnswerBytesMax) break;
  }
  if (count < 0) return refused(errno);
  const std::size_t headers_end = text.find("\r\n\r\n");
  HttpAnswer answer;
  const std::string_view version = "HTTP/1.1 ";
  const char* const number = text.data() + version.size();
  if (headers_end == std::string::npos || text.rfind(version, 0) != 0 ||
      std::from_chars(number, text.data() + text.size(), answer.status).ec != std::errc{}) {
    return fail(ErrorCode::kProtocol, "{}: not an HTTP answer; another program may listen there", socket_path);
  }
  answer.body = text.substr(headers_end + 4);
  return answer;
}

}  // namespace footlight::tools
