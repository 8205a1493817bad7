// A station of MVR-xchange on 127.0.0.1 that answers on a thread and offers one file.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include <fmt/format.h>
#include <poll.h>

#include "drivers/net/mvr_xchange_tcp.h"
#include "sim/system_clock.h"
#include "tests/support/must.h"

namespace footlight::testing {

class DeskThread {
 public:
  // commit: without the file's UUID, which is always the same.
  explicit DeskThread(const std::string& content, drivers::MvrCommit commit,
                      const char* uuid = "4aa291a1-1a62-45fe-aabc-e90e5e2399a8")
      : station_("Desk", uuid) {
    commit.file_uuid = "11111111-2222-4333-8444-555555555555";
    station_.offer(std::move(commit), std::make_shared<std::vector<std::uint8_t>>(content.begin(), content.end()));
    server_ = must(drivers::MvrServer::open({0x7F000001, 0}, station_));
    thread_ = std::jthread([this](const std::stop_token& stop) {
      SystemClock clock;
      std::vector<pollfd> waiting;
      while (!stop.stop_requested()) {
        server_->step(clock.now_ns());
        server_->add_descriptors(waiting);
        (void)::poll(waiting.data(), waiting.size(), 20);
        waiting.clear();
      }
    });
  }
  [[nodiscard]] std::string address() const { return fmt::format("127.0.0.1:{}", server_->port()); }
  // Ends the thread; what happened.
  std::vector<drivers::MvrEvent> end() {
    thread_.request_stop();
    thread_.join();
    return station_.take_events();
  }

 private:
  drivers::MvrStation station_;
  std::unique_ptr<drivers::MvrServer> server_;
  std::jthread thread_;
};

}  // namespace footlight::testing
