// Outputs of the window to real lamps: armed one by one, sent by a pump on its own thread (decision 0140).
//
//   FL_ASSIGN(const OutputPlan plan, plan_outputs(texts, *scene));
//   FL_ASSIGN(auto outputs, LiveOutputs::start(plan, open, clock));
//   outputs->follow(view);                              // rows to show
//   ... view.arm.push_back(view.rows[0].id); ...        // the user
//   outputs->give(universes, levels, sendable); outputs->follow(view);    // once a turn
//
// An output that is not armed is not open, so it can send nothing. Arming opens it, on a thread of its own. Disarming
// sends zeros and closes it, as the destructor does with all that are armed.
//
// Threads: all calls belong to one thread, the window's; none of them waits for a device but the destructor.
#pragma once

#include <cstddef>
#include <functional>
#include <future>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "drivers/registry.h"
#include "sim/core/clock.h"
#include "sim/core/endpoint.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/pump.h"
#include "sim/universes.h"
#include "tools/footlight/preview/edited_scene.h"
#include "tools/footlight/preview/output_feed.h"
#include "tools/footlight/preview/ui/outputs_view.h"

namespace footlight::tools {

struct PlannedOutput {
  Endpoint endpoint;
  std::vector<Universe> universes;  // of the show, ascending; of a log, those of the rig
};
// The endpoint of a device with one connector for another universe: "enttec-pro:EN1=3". Nothing: it is none.
[[nodiscard]] std::optional<std::string> moved_endpoint(const Endpoint& endpoint, Universe to);
struct OutputPlan {
  std::vector<PlannedOutput> outputs;
  std::vector<Universe> universes;    // of the rig, ascending: outputs for them can be added
  std::vector<std::string> warnings;  // universes that are left out, and why
};
// kBadInput for an endpoint that is an input or has its own window, and for one that is named twice.
[[nodiscard]] Status check_outputs(std::span<const std::string> texts);
// Opens nothing. Errors: those of check_outputs(); kBadInput for a rig whose levels are not those of real lamps, and
// for an output without any universe in which the rig has an address.
[[nodiscard]] Result<OutputPlan> plan_outputs(std::span<const std::string> texts, const PreviewScene& scene);

// What `footlight devices` lists, for the panel.
[[nodiscard]] std::vector<PluggedDevice> plugged_devices(const drivers::DeviceList& list);

class LiveOutputs {
 public:
  // Opens an output. Called on a thread of its own, several at a time.
  using Open = std::function<Result<std::unique_ptr<Sink>>(const PlannedOutput&)>;

  // The clock must be thread-safe and outlive this. Errors: those of the waiter.
  [[nodiscard]] static Result<std::unique_ptr<LiveOutputs>> start(OutputPlan plan, Open open, Clock& clock);
  // Sends zeros to all that are armed, and closes them.
  ~LiveOutputs();
  LiveOutputs(const LiveOutputs&) = delete;
  LiveOutputs& operator=(const LiveOutputs&) = delete;

  // As OutputFeed::give().
  void give(std::span<const Universe> universes, std::span<const std::uint8_t> levels,
            std::span<const Universe> sendable);
  // One more output, not armed. kBadInput if it is there already, or carries a universe that the plan of start() did
  // not have.
  Status add(PlannedOutput planned);
  // Makes an output that is off another one, with the same id. Errors: those of add(); kBadInput if it is on;
  // kNotFound if it has left the list.
  Status replace(OutputId id, PlannedOutput planned);
  // Carries out what the view asks of its rows, and makes it show what is.
  void follow(OutputsView& view);

  // Does nothing with one that is not kOff. All of these do nothing with one that has left the list.
  void arm(OutputId id);
  void disarm(OutputId id);
  // Out of the list: at once where it is off, else after it has ended dark and is closed, in a follow().
  void remove(OutputId id);
  // None is in the list any more.
  [[nodiscard]] bool empty() const { return outputs_.empty(); }
  void black_out();
  void lift();
  // As of OutputFeed. follow() asks for the first one.
  void need_hold(bool on);
  void hold(bool held);
  [[nodiscard]] Darkness darkness() const { return feed_->darkness(); }

  // Events since the last call, such as an output that was armed or is lost. At most the last 64.
  [[nodiscard]] std::vector<std::string> notices();

 private:
  struct Output {
    OutputId id = 0;
    PlannedOutput plan;
    ArmState state = ArmState::kOff;
    bool cancelled = false;  // kOpening: it was disarmed meanwhile
    bool removing = false;   // it leaves the list as soon as it is off
    std::string trouble;
    std::future<Result<std::unique_ptr<Sink>>> opening;
    std::shared_ptr<Sink> sink;  // while it is armed; used by the pump's thread
    std::future<void> closing;
  };

  LiveOutputs() = default;
  [[nodiscard]] Status check(const PlannedOutput& planned) const;
  void keep(PlannedOutput planned);
  [[nodiscard]] Output* find(OutputId id);
  void take_opened(Output& output);
  void note(std::string text);

  Clock* clock_ = nullptr;
  Open open_;
  std::vector<Output> outputs_;  // in the order in which they were added
  OutputId next_id_ = 0;
  std::vector<Universe> sendable_;  // of the last give()
  std::unique_ptr<OutputFeed> feed_;
  std::unique_ptr<Universes> universes_;
  std::unique_ptr<Waiter> waiter_;
  std::unique_ptr<Pump> pump_;
  bool needs_hold_ = false;           // as of the last follow()
  Darkness noted_ = Darkness::kNone;  // the last darkness of which there was a notice
  std::mutex mutex_;
  std::vector<std::string> notices_;  // guarded by mutex_
  std::jthread thread_;
};

// After a follow(): once the last output has left the list, nothing is left of them, neither a blackout nor the
// universes that they could carry. True if that was now.
bool end_without_outputs(std::unique_ptr<LiveOutputs>& outputs, OutputsView& view);

}  // namespace footlight::tools
