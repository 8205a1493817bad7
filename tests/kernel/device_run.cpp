#include "tests/kernel/device_run.h"

#include <algorithm>
#include <csignal>

#include <doctest/doctest.h>

#include "drivers/net/net.h"
#include "sim/system_clock.h"
#include "tests/support/must.h"

namespace footlight::testing {
namespace {

std::vector<std::string> arguments_of(const std::string& endpoint, const std::vector<std::string>& options) {
  std::vector<std::string> words{"run", "--in", "sacn:1%lo", "--out", endpoint, "--json", "--socket", "none"};
  words.insert(words.end(), options.begin(), options.end());
  return as_user(std::move(words));
}

}  // namespace

DeviceRun::DeviceRun(const std::string& endpoint, const std::vector<std::string>& options)
    : program_(arguments_of(endpoint, options)) {
  program_.wait_for(R"("event":"ready")");
  drivers::SacnSinkOptions sender;
  sender.name = "sacn:1%lo";
  sender.universes = {{1, 1}};
  sender.interface_names = {"lo"};
  sender_ = must(drivers::make_sacn_sink(sender));
}

void DeviceRun::send(const Snapshot& snapshot) {
  const FrameView frame{.universe = 1, .slots = snapshot};
  must(sender_->send(SystemClock().now_ns(), {&frame, 1}));
}

void DeviceRun::fail() {
  program_.signal(SIGTERM);
  const Outcome outcome = program_.wait();
  FAIL(outcome.err << outcome.out.substr(outcome.out.size() - std::min<std::size_t>(outcome.out.size(), 3000)));
}

}  // namespace footlight::testing
