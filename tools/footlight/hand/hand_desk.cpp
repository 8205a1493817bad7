#include "tools/footlight/hand/hand_desk.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <future>
#include <optional>
#include <string_view>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fixtures/model/rig.h"
#include "sim/core/check.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/hand/hand_targets.h"
#include "tools/footlight/hand/scene_file.h"
#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

constexpr std::chrono::seconds kPatience{2};
constexpr std::size_t kTasksMax = 16;  // more are dropped: someone plays with a button

Error no_pump() {
  return {ErrorCode::kTimeout,
          "nothing drives levels now, since the rig is being changed or has no address; try again"};
}

// Whether a command may change what is remembered.
bool concerns_memory(const HandCommand& command) {
  return command.action == HandAction::kBlackout || command.action == HandAction::kLift ||
         command.action == HandAction::kHold;
}

}  // namespace

bool HandDesk::remember_in(std::string path) {
  memory_path_ = std::move(path);
  struct stat found = {};
  if (memory_path_.empty() || lstat(memory_path_.c_str(), &found) != 0) return false;  // a link counts, too
  (void)apply_now({.action = HandAction::kBlackout, .levels = {}});
  return true;
}

// The job has run when this returns without an error. After an error it may still run, so it owns what it uses.
Status HandDesk::on_pump(std::function<void()> job) {
  const auto done = std::make_shared<std::promise<void>>();
  const auto finished = done->get_future();
  {
    const std::lock_guard lock(pump_mutex_);
    if (pump_ == nullptr) return tl::unexpected(no_pump());
    pump_->call([job = std::move(job), done] {
      job();
      done->set_value();
    });
  }
  if (finished.wait_for(kPatience) == std::future_status::ready) return {};
  return fail(ErrorCode::kTimeout, "the bridge is busy or stops; try again");
}

Status HandDesk::keep_time(const HandCommand& command, TimeNs now_ns) {
  if (command.beats_a_minute != 0) return tempo_->set(command.beats_a_minute, now_ns);
  tempo_->tap(now_ns);
  return {};
}

Result<int> HandDesk::apply(const HandCommand& command) {
  if (command.action == HandAction::kTempo) {
    FL_TRY(keep_time(command, clock_.now_ns()));
    return 0;
  }
  const auto result = std::make_shared<Result<int>>(0);
  const auto given_up = std::make_shared<std::atomic<bool>>(false);
  const bool remembers = concerns_memory(command);
  const Status ran = on_pump([this, command, result, given_up, remembers] {
    *result = apply_now(command);
    if (remembers && given_up->load()) remember_later();
  });
  if (!ran) {
    given_up->store(true);
    if (remembers) (void)remember();  // it may have run after it was asked for
    return tl::unexpected(ran.error());
  }
  FL_TRY(*result);
  if (remembers) FL_TRY(remember());
  return *result;
}

// Makes the file say what is on now. It is called after each change, in any order: the last call sees the last change.
Status HandDesk::remember() {
  if (memory_path_.empty()) return {};
  const std::lock_guard lock(memory_mutex_);
  if (!dark_.load()) {
    if (unlink(memory_path_.c_str()) == 0 || errno == ENOENT) return {};
    return fail(ErrorCode::kIo, "blackout is off, but {} cannot be removed ({}): the next start of this bridge is dark",
                memory_path_, std::strerror(errno));
  }
  constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
  const int fd = open(memory_path_.c_str(), kFlags, 0600);
  if (fd < 0) {
    return fail(ErrorCode::kIo,
                "done, but {} cannot be written ({}), so a restart of the bridge may end it; make its folder writable, "
                "or remove what is there",
                memory_path_, std::strerror(errno));
  }
  constexpr std::string_view kText =
      "Blackout of 'footlight blackout'. While this file exists, the bridge starts dark.\n";
  (void)!write(fd, kText.data(), kText.size());  // for readers only: that the file exists is what counts
  close(fd);
  return {};
}

Result<HandReport> HandDesk::report() {
  const auto report = std::make_shared<HandReport>();
  FL_TRY(on_pump([this, report] {
    report->beats_a_minute = tempo_->beats_a_minute();
    if (source_ == nullptr) return;
    *report = {source_->blacked_out(), source_->holding(), source_->fade_count(), report->beats_a_minute,
               source_->held()};
  }));
  return std::move(*report);
}

Result<int> HandDesk::apply_now(const HandCommand& command) {
  // Without a source nothing is set: there is nothing to release or to end.
  const bool ends = command.action == HandAction::kReleaseAll || command.action == HandAction::kLift;
  if (source_ == nullptr && ends) return 0;
  if (pump_ == nullptr) return tl::unexpected(no_pump());
  if (source_ == nullptr) {
    universes_ = pump_->universes();
    auto source = std::make_unique<HandSource>(universes_);
    FL_ASSIGN(const int slots, source->apply(command, clock_.now_ns()));
    source_ = std::move(source);
    source_->show_in(shown_);
    pump_->add_source(*source_, {.may_override = true});
    dark_.store(source_->blacked_out() || source_->holding());
    return slots;
  }
  FL_ASSIGN(const int slots, source_->apply(command, clock_.now_ns()));
  dark_.store(source_->blacked_out() || source_->holding());
  return slots;
}

void HandDesk::follow_pump() {
  if (source_ == nullptr || universes_ == pump_->universes()) return;
  pump_->remove_source(*source_);
  universes_ = pump_->universes();
  source_->move_to(universes_);
  pump_->add_source(*source_, {.may_override = true});
}

void HandDesk::join(Pump& pump, std::span<Source* const> ports) {
  const std::lock_guard lock(pump_mutex_);
  FL_CHECK(pump_ == nullptr);
  pump_ = &pump;
  pump.call([this, list = std::vector<Source*>(ports.begin(), ports.end())] {
    if (source_ != nullptr) {
      universes_ = pump_->universes();
      source_->move_to(universes_);
      pump_->add_source(*source_, {.may_override = true});
    }
    for (Source* port : list) pump_->add_source(*port);
  });
}

void HandDesk::leave(std::span<Source* const> ports) {
  const auto done = std::make_shared<std::promise<void>>();
  const auto left = done->get_future();
  {
    const std::lock_guard lock(pump_mutex_);
    if (pump_ == nullptr) return;
    pump_->call([this, done, list = std::vector<Source*>(ports.begin(), ports.end())] {
      for (Source* port : list) pump_->remove_source(*port);
      if (source_ != nullptr) pump_->remove_source(*source_);
      const std::lock_guard cleared(pump_mutex_);
      pump_ = nullptr;
      done->set_value();
    });
  }
  left.wait();
}

// --- Ports of controls -----------------------------------------------------------------------------------------------

Status HandDesk::take(const HandCommand& command, TimeNs now_ns) {
  if (command.action == HandAction::kTempo) return keep_time(command, now_ns);
  if (source_ == nullptr) {
    // The pump takes sources between two ticks only.
    pump_->call([this, command] {
      const auto applied = apply_now(command);
      if (!applied) report_trouble(applied.error());
      if (applied && concerns_memory(command)) remember_later();
    });
    return {};
  }
  FL_TRY(source_->apply(command, now_ns));
  dark_.store(source_->blacked_out() || source_->holding());
  if (concerns_memory(command)) remember_later();
  return {};
}

void HandDesk::recall(const SceneCall& call) {
  do_later([this, call] {
    if (const Status recalled = recall_now(call); !recalled) report_trouble(recalled.error());
  });
}

Status HandDesk::recall_now(const SceneCall& call) {
  const std::string path = call.file.empty() ? scene_file_place() : call.file;
  FL_ASSIGN(const SceneFile file, load_scenes(path));
  FL_ASSIGN(const LevelScene* scene, file.find(call.name));
  std::optional<fixtures::Rig> rig;
  const RigOf rig_of = [&](const std::string& text) -> Result<const fixtures::Rig*> {
    if (call.rig.empty())
      return fail(ErrorCode::kBadInput, "{}: names a fixture, so the control map needs a rig", text);
    if (!rig) {
      FL_ASSIGN(rig, fixtures::load_rig(call.rig));
    }
    return &*rig;
  };
  HandCommand command;
  command.over_ns = call.over_ns;
  command.priority = call.priority;
  for (const SceneLevel& level : scene->levels) {
    const Status added = add_assignment(level.text, rig_of, command.levels);
    if (!added) return fail(added.error().code, "{}:{}: {}", path, level.at, added.error().message);
  }
  FL_TRY(apply(command));
  return {};
}

void HandDesk::report_trouble(const Error& error) const {
  if (on_notice_) on_notice_({.level = NoticeLevel::kWarning, .id = "control-refused", .text = error.message});
}

void HandDesk::do_later(std::function<void()> task) {
  {
    const std::lock_guard lock(tasks_mutex_);
    if (tasks_.size() >= kTasksMax) return;
    tasks_.push_back(std::move(task));
    need_worker();
  }
  tasks_wake_.notify_one();
}

void HandDesk::remember_later() {
  {
    const std::lock_guard lock(tasks_mutex_);
    remembers_ = true;
    need_worker();
  }
  tasks_wake_.notify_one();
}

void HandDesk::need_worker() {
  if (worker_.joinable()) return;
  const NoSignals for_the_thread;
  worker_ = std::thread([this] { work(); });
}

void HandDesk::work() {
  std::unique_lock lock(tasks_mutex_);
  while (true) {
    tasks_wake_.wait(lock, [this] { return ending_ || remembers_ || !tasks_.empty(); });
    if (remembers_) {
      remembers_ = false;
      lock.unlock();
      if (const Status done = remember(); !done) report_trouble(done.error());
      lock.lock();
      continue;
    }
    if (ending_) return;
    const std::function<void()> task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task();
    lock.lock();
  }
}

HandDesk::~HandDesk() {
  {
    const std::lock_guard lock(tasks_mutex_);
    ending_ = true;
  }
  tasks_wake_.notify_one();
  if (worker_.joinable()) worker_.join();
}

}  // namespace footlight::tools
