#include "tools/footlight/mvr/exchange_follower.h"

#include <iterator>
#include <optional>

namespace footlight::tools {

std::vector<MvrExchange::Event> ExchangeFollower::turn(TimeNs now_ns, ExchangeView& view, const std::string& folder,
                                                       const std::function<Rig()>& shared) {
  const bool begins = view.looks || view.share || view.add || view.receive;
  if (begins) seen_ns_ = now_ns;
  std::vector<MvrExchange::Event> events;
  if (exchange_ && exchange_->ended()) {
    events = exchange_->take_events();
    exchange_.reset();
    stops_ = false;
    // Nothing is any more. What the user asks for stays.
    view.on = view.makes = false;
    view.stations.clear();
    for (std::string* text : {&view.trouble, &view.receiving, &view.sharing}) text->clear();
  }
  if (!exchange_ && begins) exchange_ = std::make_unique<MvrExchange>(options_);
  if (!stops_) carry_out(view, folder, shared);
  if (!exchange_) return events;
  (void)exchange_->look(view);
  std::vector<MvrExchange::Event> come = exchange_->take_events();
  events.insert(events.end(), std::move_iterator(come.begin()), std::move_iterator(come.end()));
  const bool busy = !view.sharing.empty() || !view.receiving.empty() || view.makes;
  if (stops_ || busy || now_ns - seen_ns_ <= kUnseenNs) return events;
  exchange_->stop();
  stops_ = true;
  return events;
}

// Without an exchange there is nothing to stop.
void ExchangeFollower::carry_out(ExchangeView& view, const std::string& folder, const std::function<Rig()>& shared) {
  view.looks = false;
  const auto receive = std::exchange(view.receive, std::nullopt);
  const auto add = std::exchange(view.add, std::nullopt);
  const bool stop_receiving = std::exchange(view.stop_receiving, false);
  const bool share = std::exchange(view.share, false);
  const bool stop_sharing = std::exchange(view.stop_sharing, false);
  if (!exchange_) return;
  if (add) exchange_->add(*add);
  if (receive) exchange_->receive(*receive, folder);
  if (stop_receiving) exchange_->stop_receiving();
  if (share) {
    Rig rig = shared();
    exchange_->share(std::move(rig.rig), std::move(rig.file_name));
  }
  if (stop_sharing) exchange_->stop_sharing();
}

void ExchangeFollower::wait_for_news(DurationNs most_ns) {
  if (exchange_) exchange_->wait_for_news(most_ns);
}

}  // namespace footlight::tools
