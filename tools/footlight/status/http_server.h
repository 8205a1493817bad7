// A small HTTP/1.1 server for status pages, on a Unix socket or on a TCP port, with its own thread.
//
// It limits its load: 16 connections at a time, of which the oldest is closed for a new one; 16 KiB of memory each, and
// 256 KiB for the body of a POST; 10 s of silence. It never blocks the thread of the pump.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <string_view>

#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

struct HttpRequest {
  std::string_view method;  // "GET", "POST"; HEAD is answered as GET
  std::string_view path;    // "/metrics"
  std::string universes;    // the query parameter of that name; empty: none
  std::string_view body;    // of a POST
  bool from_owner = false;  // over a Unix socket, by the user that runs this program or by root
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

// Called on the server's thread.
inline constexpr std::size_t kHttpBodyBytesMax = 256u << 10;  // a connection with more is closed
using HttpHandler = std::function<HttpAnswer(const HttpRequest&)>;

class HttpServer {
 public:
  // `where`: "unix:/run/footlight/run.sock" or "127.0.0.1:9477". Messages begin with `option`, the option it came from.
  // A socket file without a listener is replaced; a file of another kind is refused. All users who can reach a Unix
  // socket's folder may connect. Errors: kBadInput (another form, or a file of another kind exists), kPermission, kIo
  // (the port is in use, or another program listens on that socket).
  [[nodiscard]] static Result<std::unique_ptr<HttpServer>> listen(std::string_view option, const std::string& where,
                                                                  HttpHandler handler);
  // Ends the thread and removes the socket file, unless another file has its name by now.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // The TCP port, for port 0 the one chosen by the system. 0 for a Unix socket.
  [[nodiscard]] int port() const;

 private:
  struct Daemon;
  explicit HttpServer(std::unique_ptr<Daemon> daemon);
  std::unique_ptr<Daemon> daemon_;
};

// The client of a Unix socket: one request on its own connection. Blocks for at most `patience_ns` in total, however
// slowly the answer arrives. Errors: kNotFound (no such socket), kDisconnected (no listener), kPermission, kTimeout,
// kProtocol.
[[nodiscard]] Result<HttpAnswer> http_request(const std::string& socket_path, std::string_view method,
                                              std::string_view target, DurationNs patience_ns = 2 * kNsPerS,
                                              std::string_view body = {});

}  // namespace footlight::tools
