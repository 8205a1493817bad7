#include "tools/footlight/hand/hand_desk.h"

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <future>

#include <unistd.h>

namespace footlight::tools {
namespace {

constexpr std::chrono::seconds kPatience{2};

}  // namespace

bool HandDesk::remember_in(std::string path) {
  memory_path_ = std::move(path);
  if (memory_path_.empty() || access(memory_path_.c_str(), F_OK) != 0) return false;
  (void)take({.action = HandAction::kBlackout});
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
  FL_TRY(on_pump([this, command, result] { *result = take(command); }));
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

Result<int> HandDesk::take(const HandCommand& command) {
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

}  // namespace footlight::tools
