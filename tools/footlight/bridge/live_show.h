// The ports of a show file, and how they change with the file while the pump runs.
//
//   LiveShow live(clock);
//   FL_TRY(live.open(show));
//   Pump pump(live.buffer(), ...);
//   live.add_to(pump);                        // before it starts
//   ... live.change_to(new_show, pump) ...    // any time, on a thread that is not the pump's
//
// A port with unchanged lines in the file stays open and is not touched. New ports are opened before the pump changes,
// so that a failed change has no effect. What cannot be open twice (a device or a file of a removed port) is closed
// first and then opened again, waiting for it if needed.
//
// Threads: one at a time; while the pump runs, not the pump's thread. Destroy it on the pump's thread, after the pump.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/notice.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/pump.h"
#include "sim/universes.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/bridge/output_guard.h"
#include "tools/footlight/bridge/show_file.h"

namespace footlight::tools {

// The result of a change.
struct ShowChange {
  int opened = 0;
  int closed = 0;
  int kept = 0;
  std::vector<std::string> troubles;  // devices that were closed and could not be opened again
};

class LiveShow {
 public:
  // `stopping`: returns true to end an open() that takes long.
  explicit LiveShow(Clock& clock, std::function<bool()> stopping = {}) : opener_(clock, std::move(stopping)) {
    opener_.hand_link = std::make_shared<HandLink>();
  }

  // From open() on, every output goes through this guard. Null: no guard, no cost.
  void guard_with(std::shared_ptr<OutputGuard> guard) { guard_ = std::move(guard); }
  // Opens every port. Errors: those of the ports, and of check_show().
  [[nodiscard]] Status open(const Show& show);
  [[nodiscard]] std::shared_ptr<Universes> buffer() const { return buffer_; }
  void add_to(Pump& pump);

  // Errors: as open(); then nothing has changed. kTimeout if the pump stops in between, which `stopping` reports.
  [[nodiscard]] Result<ShowChange> change_to(const Show& show, Pump& pump, const std::function<bool()>& stopping);

  [[nodiscard]] std::vector<const Source*> sources() const;
  [[nodiscard]] std::vector<const Sink*> sinks() const;

  // What the ports of controls speak to; set it while the pump does not run.
  [[nodiscard]] HandLink& hand_link() { return *opener_.hand_link; }
  // Of the patterns among its inputs.
  [[nodiscard]] const std::shared_ptr<Tempo>& tempo() const { return opener_.tempo; }
  // Called on the pump's thread after it has moved to another buffer, before its next tick. Set before the pump runs.
  std::function<void()> after_move;

 private:
  struct In {
    InPlan plan;
    std::shared_ptr<Source> port;
  };
  struct Out {
    OutPlan plan;
    std::shared_ptr<Sink> port;
  };

  struct Exchange;

  // The steps of change_to, in its order.
  [[nodiscard]] Status open_devices(Exchange& exchange);
  [[nodiscard]] Status exchange_ports(Exchange& exchange, Pump& pump);
  [[nodiscard]] Status open_late(Exchange& exchange, Pump& pump, const std::function<bool()>& stopping);

  [[nodiscard]] Status open_networks(Exchange& exchange);
  [[nodiscard]] Result<std::shared_ptr<Source>> open_in(const InPlan& plan);
  [[nodiscard]] Result<std::shared_ptr<Sink>> open_out(const OutPlan& plan, const std::vector<Universe>& universes);
  static void add_out(Pump& pump, const std::vector<Out>& outs, const Out& out);

  PortOpener opener_;
  std::shared_ptr<OutputGuard> guard_;
  std::vector<In> ins_;
  std::vector<Out> outs_;  // a standby comes after its main output
  std::shared_ptr<Universes> buffer_;
  MergeOptions merge_;
  std::vector<Universe> ltp_;
  std::vector<LtpSlots> ltp_slots_;
};

}  // namespace footlight::tools
