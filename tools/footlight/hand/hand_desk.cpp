#include "tools/footlight/hand/hand_desk.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <future>
#include <optional>

#include <unistd.h>

#include "fixtures/model/rig.h"
#include "sim/core/no_signals.h"
#include "tools/footlight/hand/hand_targets.h"
#include "tools/footlight/hand/scene_file.h"
#include "tools/footlight/paths.h"

namespace footlight::tools {
namespace {

constexpr std::chrono::seconds kPatience{2};
constexpr std::size_t kTasksMax = 16;  // more are dropped: someone plays with a button

}  // namespace

bool HandDesk::remember_in(std::string path) {
  memory_path_ = std::move(path);
  if (memory_path_.empty() || access(memory_path_.c_str(), F_OK) != 0) return false;
  (void)apply_now({.action = HandAction::kBlackout, .levels = {}});
  return true;
}

// The job has run when this returns without an error. After an error it may still run, so it owns what it uses.
Status HandDesk::on_pump(std::function<void()> job) {
  const auto done = std::make_shared<std::promise<void>>();
  const auto finished = done->get_future();
  pump_.call([job = std::move(job), done] {
    job();
    done->set_value();
  });
  if (finished.wait_for(kPatience) == std::future_status::ready) return {};
  return fail(ErrorCode::kTimeout, "the bridge is busy or stops; try again");
}

Result<int> HandDesk::apply(const HandCommand& command) {
  const auto result = std::make_shared<Result<int>>(0);
  FL_TRY(on_pump([this, command, result] { *result = apply_now(command); }));
  FL_TRY(*result);
  FL_TRY(mark(command));
  return *result;
}

Status HandDesk::mark(const HandCommand& command) const {
  if (memory_path_.empty()) return {};
  if (command.action == HandAction::kLift) {
    if (unlink(memory_path_.c_str()) == 0 || errno == ENOENT) return {};
    return fail(ErrorCode::kIo, "blackout is off, but {} cannot be removed ({}): the next start of this bridge is dark",
                memory_path_, std::strerror(errno));
  }
  if (command.action != HandAction::kBlackout && command.action != HandAction::kHold) return {};
  std::ofstream file(memory_path_);
  file << "Blackout of 'footlight blackout'. While this file exists, the bridge starts dark.\n";
  file.close();
  if (file) return {};
  return fail(ErrorCode::kIo, "done, but {} cannot be written: a restart of the bridge would end it", memory_path_);
}

Result<HandReport> HandDesk::report() {
  const auto report = std::make_shared<HandReport>();
  FL_TRY(on_pump([this, report] {
    if (source_ == nullptr) return;
    *report = {source_->blacked_out(), source_->holding(), source_->fade_count(), source_->held()};
  }));
  return std::move(*report);
}

Result<int> HandDesk::apply_now(const HandCommand& command) {
  // Without a source nothing is set: there is nothing to release or to end.
  const bool ends = command.action == HandAction::kReleaseAll || command.action == HandAction::kLift;
  if (source_ == nullptr && ends) return 0;
  if (source_ == nullptr) {
    universes_ = pump_.universes();
    auto source = std::make_unique<HandSource>(universes_);
    FL_ASSIGN(const int slots, source->apply(command, clock_.now_ns()));
    source_ = std::move(source);
    pump_.add_source(*source_, {.may_override = true});
    return slots;
  }
  return source_->apply(command, clock_.now_ns());
}

void HandDesk::follow_pump() {
  if (source_ == nullptr || universes_ == pump_.universes()) return;
  pump_.remove_source(*source_);
  universes_ = pump_.universes();
  source_->move_to(universes_);
  pump_.add_source(*source_, {.may_override = true});
}

// --- Ports of controls -----------------------------------------------------------------------------------------------

Status HandDesk::take(const HandCommand& command, TimeNs now_ns) {
  if (source_ == nullptr) {
    // The pump takes sources between two ticks only.
    pump_.call([this, command] {
      if (const auto applied = apply_now(command); !applied) report_trouble(applied.error());
    });
  } else if (const auto applied = source_->apply(command, now_ns); !applied) {
    return tl::unexpected(applied.error());
  }
  if (command.action == HandAction::kBlackout || command.action == HandAction::kLift) {
    do_later([this, command] {
      if (const Status marked = mark(command); !marked) report_trouble(marked.error());
    });
  }
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
  FL_ASSIGN(const Scene* scene, file.find(call.name));
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
    if (!worker_.joinable()) {
      const NoSignals for_the_thread;
      worker_ = std::thread([this] { work(); });
    }
  }
  tasks_wake_.notify_one();
}

void HandDesk::work() {
  std::unique_lock lock(tasks_mutex_);
  while (true) {
    tasks_wake_.wait(lock, [this] { return ending_ || !tasks_.empty(); });
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
