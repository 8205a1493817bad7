#include "tools/footlight/status/http_server.h"

#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <thread>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/run_footlight.h"
#include "tools/footlight/stop_signal.h"

namespace footlight::tools {
namespace {

HttpAnswer echo(const HttpRequest& request) {
  if (request.path != "/echo") return {.status = 404, .body = "no"};
  return {.body =
              fmt::format("{} {} {}", request.method, request.universes, request.from_owner ? "owner" : "stranger")};
}

std::unique_ptr<HttpServer> listen_at(const std::string& where) {
  auto server = HttpServer::listen("--metrics", where, echo);
  REQUIRE_MESSAGE(server.has_value(), (server ? "" : server.error().message));
  return std::move(*server);
}

// A client that does not follow the protocol.
class RawClient {
 public:
  explicit RawClient(int port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~RawClient() { close(fd_); }
  RawClient(RawClient&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  RawClient(const RawClient&) = delete;
  RawClient& operator=(const RawClient&) = delete;

  bool send_text(const std::string& text) {
    return send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  // Everything until the server closes.
  std::string read_all() {
    std::string text;
    char buffer[4096];
    for (ssize_t count = 0; (count = recv(fd_, buffer, sizeof buffer, 0)) > 0;) {
      text.append(buffer, static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  int fd_;
};

const std::string kGet = "GET /echo?universes=1-3 HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n";

TEST_CASE("a page is served over TCP to any client") {
  const auto server = listen_at("127.0.0.1:0");
  RawClient client(server->port());
  REQUIRE(client.send_text(kGet));
  const std::string answer = client.read_all();
  CHECK(answer.rfind("HTTP/1.1 200", 0) == 0);
  CHECK(answer.find("\r\n\r\nGET 1-3 stranger") != std::string::npos);
}

TEST_CASE("a page is served over a Unix socket to the owner, and the file is removed with the server") {
  const testing::TempFolder folder;
  const std::string path = folder.file("s.sock");
  {
    const auto server = listen_at("unix:" + path);
    CHECK(server->port() == 0);
    const auto answer = http_request(path, "POST", "/echo?universes=7");
    REQUIRE(answer.has_value());
    CHECK(answer->status == 200);
    CHECK(answer->body == "POST 7 owner");
    CHECK(http_request(path, "GET", "/other")->status == 404);
  }
  CHECK_FALSE(std::filesystem::exists(path));
  CHECK(http_request(path, "GET", "/echo").error().code == ErrorCode::kNotFound);
}

TEST_CASE("a socket file of a killed program is replaced, that of a running one is not") {
  const testing::TempFolder folder;
  const std::string path = folder.file("s.sock");
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int fd = socket(AF_UNIX, SOCK_STREAM, 0);
  REQUIRE(bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  close(fd);
  CHECK(http_request(path, "GET", "/echo").error().code == ErrorCode::kDisconnected);
  const auto first = listen_at("unix:" + path);
  const auto second = HttpServer::listen("--socket", "unix:" + path, echo);
  REQUIRE_FALSE(second.has_value());
  CHECK(second.error().message.find("another program uses it") != std::string::npos);
  CHECK(http_request(path, "GET", "/echo").has_value());
}

TEST_CASE("a file that is not a socket is refused as a socket path and stays unchanged") {
  const testing::TempFolder folder;
  const std::string path = folder.file("show.toml");
  std::ofstream(path) << "[[in]]\n";
  const std::string link = folder.file("link.sock");
  std::filesystem::create_symlink(path, link);
  for (const std::string& place : {path, link}) {
    const auto refused = HttpServer::listen("--socket", "unix:" + place, echo);
    REQUIRE_FALSE(refused.has_value());
    CHECK(refused.error().code == ErrorCode::kBadInput);
    CHECK(refused.error().message.find(place) != std::string::npos);
    CHECK(refused.error().message.find("not a socket") != std::string::npos);
  }
  std::string text;
  std::getline(std::ifstream(path), text);
  CHECK(text == "[[in]]");
  CHECK(std::filesystem::is_symlink(link));
}

TEST_CASE("a server does not remove another file that has taken its name") {
  const testing::TempFolder folder;
  const std::string path = folder.file("s.sock");
  auto first = listen_at("unix:" + path);
  std::filesystem::remove(path);
  const auto second = listen_at("unix:" + path);
  first.reset();
  CHECK(http_request(path, "GET", "/echo").has_value());
}

TEST_CASE("a request ends at its timeout, also if the answer comes byte by byte") {
  const testing::TempFolder folder;
  const std::string path = folder.file("s.sock");
  sockaddr_un address = {};
  address.sun_family = AF_UNIX;
  std::memcpy(address.sun_path, path.c_str(), path.size());
  const int listener = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  REQUIRE(bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  REQUIRE(listen(listener, 1) == 0);
  std::thread server([&] {
    const int fd = accept(listener, nullptr, nullptr);
    // Each byte arrives long before the timeout of one call.
    for (int i = 0; i < 500 && send(fd, "x", 1, MSG_NOSIGNAL) == 1; ++i) poll(nullptr, 0, 10);
    close(fd);
  });
  const auto answer = http_request(path, "GET", "/echo", 200 * kNsPerMs);
  server.join();
  close(listener);
  REQUIRE_FALSE(answer.has_value());
  CHECK(answer.error().code == ErrorCode::kTimeout);
}

TEST_CASE("a reload signal without a descriptor is an error, and waiting for it ends at once") {
  rlimit before = {};
  REQUIRE(getrlimit(RLIMIT_NOFILE, &before) == 0);
  const rlimit none = {.rlim_cur = 0, .rlim_max = before.rlim_max};
  REQUIRE(setrlimit(RLIMIT_NOFILE, &none) == 0);
  {
    ReloadSignal reload;
    REQUIRE(setrlimit(RLIMIT_NOFILE, &before) == 0);
    const Status opened = reload.opened();
    REQUIRE_FALSE(opened.has_value());
    CHECK(opened.error().code == ErrorCode::kIo);
    CHECK(opened.error().message.find("ulimit -n") != std::string::npos);
    CHECK(reload.wait() == ReloadSignal::Request::kNothing);
  }
}

TEST_CASE("slow clients cannot block others") {
  const auto server = listen_at("127.0.0.1:0");
  std::vector<RawClient> slow;
  for (int i = 0; i < 60; ++i) {
    slow.emplace_back(server->port());
    (void)slow.back().send_text("GET /echo HTTP/1.1\r\nX-Slow: ");
    // Between them, a client with a valid request.
    RawClient client(server->port());
    REQUIRE(client.send_text(kGet));
    CHECK(client.read_all().rfind("HTTP/1.1 200", 0) == 0);
  }
}

TEST_CASE("a request without end is cut off, and the next one is answered") {
  const auto server = listen_at("127.0.0.1:0");
  {
    RawClient client(server->port());
    std::string headers = "GET /echo HTTP/1.1\r\n";
    while (headers.size() < 200'000) headers += "X-More: " + std::string(1'000, 'x') + "\r\n";
    (void)client.send_text(headers);
    CHECK(client.read_all().rfind("HTTP/1.1 200", 0) != 0);
  }
  {
    RawClient client(server->port());
    (void)client.send_text("POST /echo HTTP/1.1\r\nHost: x\r\nContent-Length: 100000000\r\n\r\n" +
                           std::string(100'000, 'x'));
    (void)client.send_text(std::string(100'000, 'x'));
  }
  {
    RawClient client(server->port());
    (void)client.send_text(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xFC\x03\x03\r\n\r\n", 15));
    CHECK(client.read_all().rfind("HTTP/1.1 200", 0) != 0);
  }
  RawClient client(server->port());
  REQUIRE(client.send_text(kGet));
  CHECK(client.read_all().rfind("HTTP/1.1 200", 0) == 0);
}

TEST_CASE("an invalid address is refused with the expected form") {
  for (const char* where : {"9477", "localhost:9477", "127.0.0.1:", "127.0.0.1:99999", "127.0.0.1:94x", "unix:", ""}) {
    CAPTURE(where);
    const auto server = HttpServer::listen("--metrics", where, echo);
    REQUIRE_FALSE(server.has_value());
    CHECK(server.error().code == ErrorCode::kBadInput);
    CHECK(server.error().message.find("127.0.0.1:9477") != std::string::npos);
  }
  CHECK(HttpServer::listen("--socket", "unix:/no/such/folder/s", echo).error().message.find("folder") !=
        std::string::npos);
  const auto taken = listen_at("127.0.0.1:0");
  CHECK(HttpServer::listen("--metrics", fmt::format("127.0.0.1:{}", taken->port()), echo)
            .error()
            .message.find("another program uses it") != std::string::npos);
}

}  // namespace
}  // namespace footlight::tools
