// The hand of a running bridge (sim/hand.h): takes commands from any thread and keeps the source in the pump.
//
// The source joins the pump with the first command. Before that there is nothing: no port, no thread, no deadline.
//
// A blackout or a hold is remembered in a file beside the bridge's socket, "SOCKET.blackout". A bridge that starts and
// finds the file starts dark, so that a crash during a blackout does not bring the light back. 'footlight blackout off'
// removes the file.
//
// Ports of controls (OSC, MIDI) reach it as their HandTaker. What they cause on a disk, reading a scene and remembering
// a blackout, is done by a thread that begins with the first such task.
//
// A desk may change its pump: a window has another one when live inputs come or go (leave(), join()). What is set
// stays.
//
// Threads: apply() and report() any but the pump's; the rest as stated.
#pragma once

#include <atomic>
#include <condition_variable>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <thread>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/notice.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "sim/pump.h"
#include "sim/tempo.h"

namespace footlight::tools {

struct HandReport {
  bool blackout = false;
  bool hold = false;
  std::size_t fades = 0;
  double beats_a_minute = kTempoDefault;  // of made-up inputs
  std::vector<HandSource::Held> held;
};

class HandDesk final : public HandTaker {
 public:
  // Both outlive the desk. The desk outlives every run of the pump.
  HandDesk(Pump& pump, Clock& clock, NoticeReceiver on_notice = {})
      : pump_(&pump), clock_(clock), on_notice_(std::move(on_notice)) {}
  // Without a pump, until join(). `shown`: as HandSource::show_in(); it outlives the desk.
  HandDesk(Clock& clock, NoticeReceiver on_notice, HandShown* shown)
      : clock_(clock), on_notice_(std::move(on_notice)), shown_(shown) {}
  ~HandDesk() override;
  HandDesk(const HandDesk&) = delete;
  HandDesk& operator=(const HandDesk&) = delete;

  // The tempo that commands and controls set. Before anything is applied; null, as at first: it has one of its own.
  void share_tempo(std::shared_ptr<Tempo> tempo) {
    if (tempo != nullptr) tempo_ = std::move(tempo);
  }

  // Takes everything to a pump that runs, and its ports of controls with it. leave() waits until that pump has let go
  // of all; nothing is applied before the next join(). Both for one thread that is no pump's. The ports outlive the
  // stay.
  void join(Pump& pump, std::span<Source* const> ports);
  void leave(std::span<Source* const> ports);

  // Before the pump runs. `path`: of the file that remembers a blackout; "": none. True if the bridge starts dark.
  bool remember_in(std::string path);
  // Returns the number of slots. Errors: those of HandSource::apply(); kTimeout: the pump does not answer; kIo: done,
  // but a blackout cannot be remembered.
  [[nodiscard]] Result<int> apply(const HandCommand& command);
  [[nodiscard]] Result<HandReport> report();

  // The pump's thread, between two ticks: its universes have changed.
  void follow_pump();
  // The pump's thread, also within a tick.
  Status take(const HandCommand& command, TimeNs now_ns) override;
  void recall(const SceneCall& call) override;
  [[nodiscard]] bool blacked_out() const override { return source_ != nullptr && source_->blacked_out(); }

 private:
  [[nodiscard]] Status on_pump(std::function<void()> job);
  [[nodiscard]] Status remember();
  void remember_later();
  void need_worker();
  Result<int> apply_now(const HandCommand& command);
  [[nodiscard]] Status keep_time(const HandCommand& command, TimeNs now_ns);
  void do_later(std::function<void()> task);
  void work();
  [[nodiscard]] Status recall_now(const SceneCall& call);
  void report_trouble(const Error& error) const;

  std::mutex pump_mutex_;  // guards pump_ but on the pump's thread, which alone clears it
  Pump* pump_ = nullptr;
  Clock& clock_;
  const NoticeReceiver on_notice_;  // any thread
  HandShown* const shown_ = nullptr;
  std::shared_ptr<Tempo> tempo_ = std::make_shared<Tempo>();
  std::string memory_path_;
  std::mutex memory_mutex_;         // guards the file
  std::atomic<bool> dark_ = false;  // blackout or a hold is on; set on the pump's thread, before the file is written
  std::unique_ptr<HandSource> source_;          // of the pump's thread
  std::shared_ptr<const Universes> universes_;  // of the source

  std::mutex tasks_mutex_;  // guards what follows
  std::condition_variable tasks_wake_;
  std::deque<std::function<void()>> tasks_;
  bool remembers_ = false;  // remember() is to be called; done also at the end
  bool ending_ = false;
  std::thread worker_;  // of tasks; begins with the first
};

}  // namespace footlight::tools
