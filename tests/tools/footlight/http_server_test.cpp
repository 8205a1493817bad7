#include "tools/footlight/http_server.h"

#include <atomic>
#include <cstring>
#include <filesystem>
#include <vector>

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "tests/tools/footlight/run_footlight.h"

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

// A client with bad manners.
class Rude {
 public:
  explicit Rude(int port) : fd_(socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0)) {
    sockaddr_in address = {};
    address.sin_family = AF_INET;
    address.sin_port = htons(static_cast<std::uint16_t>(port));
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    REQUIRE(connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  }
  ~Rude() { close(fd_); }
  Rude(Rude&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Rude(const Rude&) = delete;
  Rude& operator=(const Rude&) = delete;

  bool say(const std::string& text) {
    return send(fd_, text.data(), text.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(text.size());
  }
  // Everything up to the end that the server makes.
  std::string hear() {
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

TEST_CASE("a page is served over TCP, to a stranger") {
  const auto server = listen_at("127.0.0.1:0");
  Rude client(server->port());
  REQUIRE(client.say(kGet));
  const std::string answer = client.hear();
  CHECK(answer.rfind("HTTP/1.1 200", 0) == 0);
  CHECK(answer.find("\r\n\r\nGET 1-3 stranger") != std::string::npos);
}

TEST_CASE("a page is served over a Unix socket, to the owner, and the file goes with the server") {
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

TEST_CASE("a socket file that a killed program left is replaced, that of a living one is not") {
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
  CHECK(second.error().message.find("another program has it") != std::string::npos);
  CHECK(http_request(path, "GET", "/echo").has_value());
}

TEST_CASE("those who dawdle over a request cannot keep others out") {
  const auto server = listen_at("127.0.0.1:0");
  std::vector<Rude> slow;
  for (int i = 0; i < 60; ++i) {
    slow.emplace_back(server->port());
    (void)slow.back().say("GET /echo HTTP/1.1\r\nX-Slow: ");
    // Between them, always somebody who knows what he wants.
    Rude client(server->port());
    REQUIRE(client.say(kGet));
    CHECK(client.hear().rfind("HTTP/1.1 200", 0) == 0);
  }
}

TEST_CASE("a request without end is cut off, and the next one is answered") {
  const auto server = listen_at("127.0.0.1:0");
  {
    Rude client(server->port());
    std::string headers = "GET /echo HTTP/1.1\r\n";
    while (headers.size() < 200'000) headers += "X-More: " + std::string(1'000, 'x') + "\r\n";
    (void)client.say(headers);
    CHECK(client.hear().rfind("HTTP/1.1 200", 0) != 0);
  }
  {
    Rude client(server->port());
    (void)client.say("POST /echo HTTP/1.1\r\nHost: x\r\nContent-Length: 100000000\r\n\r\n" + std::string(100'000, 'x'));
    (void)client.say(std::string(100'000, 'x'));
  }
  {
    Rude client(server->port());
    (void)client.say(std::string("\x16\x03\x01\x02\x00\x01\x00\x01\xFC\x03\x03\r\n\r\n", 15));
    CHECK(client.hear().rfind("HTTP/1.1 200", 0) != 0);
  }
  Rude client(server->port());
  REQUIRE(client.say(kGet));
  CHECK(client.hear().rfind("HTTP/1.1 200", 0) == 0);
}

TEST_CASE("a place that is no place says what was expected") {
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
            .message.find("another program has it") != std::string::npos);
}

}  // namespace
}  // namespace footlight::tools
