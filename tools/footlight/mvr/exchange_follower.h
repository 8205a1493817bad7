// The exchange of a window: it begins when the user asks for something, and ends when nobody has looked for a minute
// and nothing is exchanged. One thread.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/core/clock.h"
#include "tools/footlight/mvr/mvr_exchange.h"

namespace footlight::tools {

class ExchangeFollower {
 public:
  static constexpr DurationNs kUnseenNs = 60 * kNsPerS;  // after which nobody is looked for

  struct Rig {
    std::shared_ptr<const fixtures::ImportedRig> rig;
    std::string file_name;
  };
  explicit ExchangeFollower(MvrExchange::Options options = {}) : options_(std::move(options)) {}

  // Once a turn: carries out and resets what `view` asks for, writes into it what is, and returns what has come. What
  // is asked for while an exchange ends waits in `view` for the next one. folder: of received files. shared: the rig
  // that is shared now; called only then.
  [[nodiscard]] std::vector<MvrExchange::Event> turn(TimeNs now_ns, ExchangeView& view, const std::string& folder,
                                                     const std::function<Rig()>& shared);
  [[nodiscard]] bool runs() const { return exchange_ != nullptr; }
  // Until something is new, at most that long; for tests.
  void wait_for_news(DurationNs most_ns);

 private:
  void carry_out(ExchangeView& view, const std::string& folder, const std::function<Rig()>& shared);

  const MvrExchange::Options options_;
  std::unique_ptr<MvrExchange> exchange_;
  bool stops_ = false;  // exchange_ was told to end
  TimeNs seen_ns_ = 0;  // when the user looked or asked last
};

}  // namespace footlight::tools
