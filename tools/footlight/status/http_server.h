// A small HTTP/1.1 server for status pages: on a Unix socket or on a TCP port, with a thread of its own.
//
// It is made for being asked too much: 16 connections at a time, of which the oldest gives its place to a new one; 16
// KiB of memory each; 10 s of silence. What goes on in it never reaches the thread of the pump.
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
  std::string universes;    // the query's value of that name; empty: none
  bool from_owner = false;  // over a Unix socket, by the user that runs this program or by root
};

struct HttpAnswer {
  int status = 200;
  std::string type = "text/plain; charset=utf-8";
  std::string body;
};

// Called on the server's thread.
using HttpHandler = std::function<HttpAnswer(const HttpRequest&)>;

class HttpServer {
 public:
  // `where`: "unix:/run/footlight/run.sock" or "127.0.0.1:9477", as `option` took it, which begins the messages. A
  // socket file that nobody listens to any more is replaced; a file of another kind is refused. All who can reach a
  // Unix socket's folder may connect. Errors: kBadInput (not of these forms, or a file of another kind is there),
  // kPermission, kIo (port taken, or another program listens to that socket).
  [[nodiscard]] static Result<std::unique_ptr<HttpServer>> listen(std::string_view option, const std::string& where,
                                                                  HttpHandler handler);
  // Ends the thread and takes the socket file away, unless another file has its name by now.
  ~HttpServer();
  HttpServer(const HttpServer&) = delete;
  HttpServer& operator=(const HttpServer&) = delete;

  // The TCP port; that which the system chose for port 0. 0 for a Unix socket.
  [[nodiscard]] int port() const;

 private:
  struct Daemon;
  explicit HttpServer(std::unique_ptr<Daemon> daemon);
  std::unique_ptr<Daemon> daemon_;
};

// The other end of a Unix socket: one request on a connection of its own. Blocks for at most `patience_ns` over all,
// however slowly the answer comes. Errors: kNotFound
// (no such socket), kDisconnected (nobody listens), kPermission, kTimeout, kProtocol.
[[nodiscard]] Result<HttpAnswer> http_request(const std::string& socket_path, std::string_view method,
                                              std::string_view target, DurationNs patience_ns = 2 * kNsPerS);

}  // namespace footlight::tools
