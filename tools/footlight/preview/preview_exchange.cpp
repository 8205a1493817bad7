// MVR-xchange in the preview: rigs from other stations, and the present one for them.
#include <filesystem>
#include <utility>

#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {
namespace {

constexpr DurationNs kUnseenNs = 60 * kNsPerS;  // after which nobody is looked for

}  // namespace

// Once a turn: what the menu asks for, and what has come.
void Preview::follow_exchange() {
  ExchangeView& view = exchange_view_;
  const bool looks = std::exchange(view.looks, false);
  if (looks) exchange_seen_ns_ = last_ns_;
  const auto receive = std::exchange(view.receive, std::nullopt);
  const auto add = std::exchange(view.add, std::nullopt);
  const bool stop_receiving = std::exchange(view.stop_receiving, false);
  const bool share = std::exchange(view.share, false);
  const bool stop_sharing = std::exchange(view.stop_sharing, false);
  if (exchange_ && exchange_->ended()) {
    exchange_.reset();
    view.on = false;
    view.stations.clear();
  }
  if (!exchange_ && (looks || share || add)) exchange_ = std::make_unique<MvrExchange>(MvrExchange::Options{});
  if (!exchange_) return;
  if (add) exchange_->add(*add);
  if (receive) exchange_->receive(*receive, folder_for_rigs());
  if (stop_receiving) exchange_->stop_receiving();
  if (share) {
    exchange_->share(std::make_shared<const fixtures::ImportedRig>(edited_->file().imported()),
                     std::filesystem::path(edited_->file().target()).stem().string() + ".mvr");
  }
  if (stop_sharing) exchange_->stop_sharing();
  (void)exchange_->look(view);
  for (MvrExchange::Event& event : exchange_->take_events()) {
    const bool wrong = event.kind == MvrExchange::Event::Kind::kError;
    tell(std::move(event.text), wrong);
    if (event.kind == MvrExchange::Event::Kind::kReceived && !asked_next_) ask_to_open({std::move(event.path), ""});
  }
  const bool busy = !view.sharing.empty() || !view.receiving.empty() || view.makes;
  if (!busy && last_ns_ - exchange_seen_ns_ > kUnseenNs) exchange_->stop();
}

// Of the rig's file; for --demo the current one.
std::string Preview::folder_for_rigs() const {
  const std::string folder = std::filesystem::path(edited_->file().target()).parent_path().string();
  return folder.empty() ? "." : folder;
}

}  // namespace footlight::tools
