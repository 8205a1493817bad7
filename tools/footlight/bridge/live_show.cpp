#include "tools/footlight/bridge/live_show.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <future>

#include "tools/footlight/bridge/bridge.h"

namespace footlight::tools {
namespace {

// Both need the same device or file exclusively.
bool collide(const Endpoint& a, const Endpoint& b) {
  return a.kind == b.kind && a.kind != EndpointKind::kNetwork && a.scheme == b.scheme && a.target == b.target;
}

// Universes of the show file and of the endpoints. The universes of a log are known when it is open.
std::vector<Universe> named_universes(const Show& show) {
  std::vector<Universe> universes;
  for (Universe universe = kUniverseMin; universe <= show.universe_count; ++universe) universes.push_back(universe);
  const auto add = [&](const Endpoint& endpoint) {
    const auto carried = endpoint.show_universes();
    universes.insert(universes.end(), carried.begin(), carried.end());
  };
  for (const InPlan& plan : show.ins) add(plan.endpoint);
  for (const OutPlan& plan : show.outs) add(plan.endpoint);
  return universes;
}

Status check_ltp(const Show& show, const std::vector<Universe>& universes) {
  const auto check = [&universes](const char* key, Universe universe) -> Status {
    if (std::binary_search(universes.begin(), universes.end(), universe)) return {};
    return fail(ErrorCode::kBadInput, "[merge]: {} names universe {}, which no port carries", key, universe);
  };
  for (const Universe universe : show.ltp) FL_TRY(check("ltp", universe));
  for (const LtpSlots& ltp : show.ltp_slots) {
    if (!ltp.from_rig) FL_TRY(check("ltp_slots", ltp.universe));
  }
  return {};
}

void set_modes(Pump& pump, const std::vector<Universe>& universes, const std::vector<LtpSlots>& slots) {
  for (const Universe universe : universes) pump.set_mode(universe, MergeMode::kLtp);
  const auto buffer = pump.universes();
  for (const LtpSlots& ltp : slots) {
    if (buffer->index_of(ltp.universe) >= 0) pump.set_slot_modes(ltp.universe, ltp.slots);
  }
}

// Runs `job` on the pump's thread and waits for it. After an error it never runs: a job that has not started when the
// pump stops is cancelled, because it refers to local variables.
Status on_pump(Pump& pump, std::function<void()> job, const std::function<bool()>& stopping) {
  enum class State { kWaiting, kBegun, kCancelled };
  struct Call {
    std::atomic<State> state = State::kWaiting;
    std::promise<void> done;
  };
  const auto call = std::make_shared<Call>();
  const auto finished = call->done.get_future();
  pump.call([job = std::move(job), call] {
    State expected = State::kWaiting;
    if (!call->state.compare_exchange_strong(expected, State::kBegun)) return;
    job();
    call->done.set_value();
  });
  while (finished.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    State expected = State::kWaiting;
    if (stopping() && call->state.compare_exchange_strong(expected, State::kCancelled)) {
      return fail(ErrorCode::kTimeout, "the bridge stopped meanwhile");
    }
  }
  return {};
}

// A network port, not the demo show.
bool network(const InPlan& plan) { return !plan.demo && plan.endpoint.kind == EndpointKind::kNetwork; }
bool network(const OutPlan& plan) { return plan.endpoint.kind == EndpointKind::kNetwork; }
bool network(const auto& entry) { return network(entry.plan); }

}  // namespace

Result<std::shared_ptr<Source>> LiveShow::open_in(const InPlan& plan) {
  if (plan.demo) {
    FL_ASSIGN(std::shared_ptr<Source> demo, open_demo_source(plan.options));
    return demo;
  }
  FL_ASSIGN(std::shared_ptr<Source> source, opener_.open_source(plan.endpoint, plan.options));
  return source;
}

Result<std::shared_ptr<Sink>> LiveShow::open_out(const OutPlan& plan, const std::vector<Universe>& universes) {
  FL_ASSIGN(std::unique_ptr<Sink> sink, opener_.open_sink(plan.endpoint, universes, plan.options));
  if (guard_ != nullptr) sink = guard_sink(std::move(sink), guard_);
  return std::shared_ptr<Sink>(std::move(sink));
}

Status LiveShow::open(const Show& show) {
  std::vector<Universe> universes = named_universes(show);
  for (const InPlan& plan : show.ins) {
    FL_ASSIGN(std::shared_ptr<Source> source, open_in(plan));
    universes.insert(universes.end(), source->universes().begin(), source->universes().end());
    ins_.push_back({plan, std::move(source)});
  }
  universes = sorted_once(std::move(universes));
  FL_TRY(check_ltp(show, universes));
  for (const OutPlan& plan : show.outs) {
    FL_ASSIGN(std::shared_ptr<Sink> sink, open_out(plan, universes));
    outs_.push_back({plan, std::move(sink)});
  }
  FL_ASSIGN(buffer_, Universes::make(universes));
  merge_ = show.merge;
  ltp_ = show.ltp;
  ltp_slots_ = show.ltp_slots;
  return {};
}

void LiveShow::add_out(Pump& pump, const std::vector<Out>& outs, const Out& out) {
  SinkRole role;
  for (const Out& other : outs) {
    if (&other != &out && other.plan.endpoint.text == out.plan.standby_for) role.standby_for = other.port.get();
  }
  pump.add_sink(*out.port, role);
}

void LiveShow::add_to(Pump& pump) {
  set_modes(pump, ltp_, ltp_slots_);
  for (const In& in : ins_) pump.add_source(*in.port);
  for (const Out& out : outs_) add_out(pump, outs_, out);
}

// A change of the show in progress. Ports move from the old show to the new one; pointers are into ins and outs.
struct LiveShow::Exchange {
  const Show& show;
  std::vector<In> ins;  // of the new show
  std::vector<Out> outs;
  std::vector<In> old_ins;  // of the old show; after keep_same() those that will be closed
  std::vector<Out> old_outs;
  std::vector<In*> added_ins, late_ins;  // opened before the old ones are closed, and after
  std::vector<Out*> added_outs, late_outs;
  std::vector<Universe> universes;
  std::shared_ptr<Universes> buffer;
  bool moves = false;  // to another buffer or other merge rules
  ShowChange change;

  void keep_same();
  void find_late();
};

// Keeps one old port for each equal line of the file. A standby is kept only with its main output.
void LiveShow::Exchange::keep_same() {
  for (In& in : ins) {
    const auto same = std::find_if(old_ins.begin(), old_ins.end(), [&](const In& old) { return old.plan == in.plan; });
    if (same == old_ins.end()) continue;
    in.port = std::move(same->port);
    old_ins.erase(same);
    ++change.kept;
  }
  for (Out& out : outs) {
    const auto primary_opens = std::any_of(outs.begin(), outs.end(), [&](const Out& other) {
      return other.plan.endpoint.text == out.plan.standby_for && other.port == nullptr;
    });
    const auto same =
        std::find_if(old_outs.begin(), old_outs.end(), [&](const Out& old) { return old.plan == out.plan; });
    if (same == old_outs.end() || primary_opens) continue;
    out.port = std::move(same->port);
    old_outs.erase(same);
    ++change.kept;
  }
}

// Ports that need a device or a file that an old port still has, and their standbys.
void LiveShow::Exchange::find_late() {
  const auto must_wait = [&](const Endpoint& endpoint) {
    return std::any_of(old_ins.begin(), old_ins.end(),
                       [&](const In& old) { return !old.plan.demo && collide(old.plan.endpoint, endpoint); }) ||
           std::any_of(old_outs.begin(), old_outs.end(),
                       [&](const Out& old) { return collide(old.plan.endpoint, endpoint); });
  };
  for (In& in : ins) {
    if (in.port != nullptr) continue;
    const bool waits = !in.plan.demo && must_wait(in.plan.endpoint);
    (waits ? late_ins : added_ins).push_back(&in);
  }
  for (Out& out : outs) {
    if (out.port != nullptr) continue;
    const bool primary_late = std::any_of(late_outs.begin(), late_outs.end(), [&](const Out* late) {
      return late->plan.endpoint.text == out.plan.standby_for;
    });
    const bool waits = primary_late || must_wait(out.plan.endpoint);
    (waits ? late_outs : added_outs).push_back(&out);
  }
}

// Opens devices and files, which may take long.
Status LiveShow::open_devices(Exchange& exchange) {
  exchange.universes = named_universes(exchange.show);
  for (In* in : exchange.added_ins) {
    if (network(*in)) continue;
    FL_ASSIGN(in->port, open_in(in->plan));
  }
  for (const In& in : exchange.ins) {
    if (in.port == nullptr) continue;
    exchange.universes.insert(exchange.universes.end(), in.port->universes().begin(), in.port->universes().end());
  }
  exchange.universes = sorted_once(std::move(exchange.universes));
  FL_TRY(check_ltp(exchange.show, exchange.universes));
  for (Out* out : exchange.added_outs) {
    if (network(*out)) continue;
    FL_ASSIGN(out->port, open_out(out->plan, exchange.universes));
  }
  const Show& show = exchange.show;
  const auto numbers = buffer_->numbers();
  exchange.moves = !std::equal(exchange.universes.begin(), exchange.universes.end(), numbers.begin(), numbers.end()) ||
                   !(show.merge == merge_) || show.ltp != ltp_ || show.ltp_slots != ltp_slots_;
  exchange.buffer = buffer_;
  if (exchange.moves) {
    FL_ASSIGN(exchange.buffer, Universes::make(exchange.universes));
  }
  return {};
}

Status LiveShow::open_networks(Exchange& exchange) {
  for (In* in : exchange.added_ins) {
    if (in->port != nullptr) continue;
    FL_ASSIGN(in->port, open_in(in->plan));
  }
  for (Out* out : exchange.added_outs) {
    if (out->port != nullptr) continue;
    FL_ASSIGN(out->port, open_out(out->plan, exchange.universes));
  }
  return {};
}

// On the pump's thread, because network ports refer to each other. They are opened last; from then on, frames wait in
// their sockets. After that nothing can fail. New sources are added before old ones are removed, so that no frame is
// missed. Old sinks are removed before new ones are added, so that receivers do not apply the end of the old stream to
// the new one.
Status LiveShow::exchange_ports(Exchange& exchange, Pump& pump) {
  const auto close_networks = [](const auto& entries) {
    for (auto* entry : entries)
      if (network(*entry)) entry->port.reset();
  };
  if (Status opened = open_networks(exchange); !opened) {
    close_networks(exchange.added_ins);
    close_networks(exchange.added_outs);
    return opened;
  }
  if (exchange.moves) {
    pump.move_to(exchange.buffer, exchange.show.merge);
    set_modes(pump, exchange.show.ltp, exchange.show.ltp_slots);
    if (after_move) after_move();
  }
  for (const In* in : exchange.added_ins) pump.add_source(*in->port);
  for (const In& old : exchange.old_ins) pump.remove_source(*old.port);
  for (auto old = exchange.old_outs.rbegin(); old != exchange.old_outs.rend(); ++old) pump.remove_sink(*old->port);
  for (const Out* out : exchange.added_outs) add_out(pump, exchange.outs, *out);
  ins_ = exchange.ins;
  outs_ = exchange.outs;
  for (In& old : exchange.old_ins)
    if (network(old)) old.port.reset();
  for (Out& old : exchange.old_outs)
    if (network(old)) old.port.reset();
  return {};
}

// Opens the late ports. One that does not open is waited for.
Status LiveShow::open_late(Exchange& exchange, Pump& pump, const std::function<bool()>& stopping) {
  std::vector<Source*> sources;
  std::vector<const Sink*> sinks;
  for (In* in : exchange.late_ins) {
    InPlan plan = in->plan;
    plan.options.wait_for_device = true;
    auto source = open_in(plan);
    if (source) {
      in->port = std::move(*source);
      sources.push_back(in->port.get());
    } else {
      exchange.change.troubles.push_back(source.error().message);
    }
  }
  for (Out* out : exchange.late_outs) {
    OutPlan plan = out->plan;
    plan.options.wait_for_device = true;
    auto sink = open_out(plan, exchange.universes);
    if (sink) {
      out->port = std::move(*sink);
      sinks.push_back(out->port.get());
    } else {
      exchange.change.troubles.push_back(sink.error().message);
    }
  }
  const auto without_port = [](const auto& entry) { return entry.port == nullptr; };
  ins_ = std::move(exchange.ins);
  outs_ = std::move(exchange.outs);
  std::erase_if(ins_, without_port);
  std::erase_if(outs_, without_port);
  exchange.change.opened += static_cast<int>(sources.size() + sinks.size());
  if (sources.empty() && sinks.empty()) return {};
  return on_pump(
      pump,
      [&] {
        for (Source* source : sources) pump.add_source(*source);
        for (const Out& out : outs_) {
          if (std::find(sinks.begin(), sinks.end(), out.port.get()) != sinks.end()) add_out(pump, outs_, out);
        }
      },
      stopping);
}

Result<ShowChange> LiveShow::change_to(const Show& show, Pump& pump, const std::function<bool()>& stopping) {
  Exchange exchange{.show = show, .old_ins = ins_, .old_outs = outs_};
  for (const InPlan& plan : show.ins) exchange.ins.push_back({plan, nullptr});
  for (const OutPlan& plan : show.outs) exchange.outs.push_back({plan, nullptr});
  exchange.keep_same();
  exchange.find_late();
  FL_TRY(open_devices(exchange));
  Status exchanged;
  FL_TRY(on_pump(
      pump, [&] { exchanged = exchange_ports(exchange, pump); }, stopping));
  FL_TRY(exchanged);
  buffer_ = exchange.buffer;
  merge_ = show.merge;
  ltp_ = show.ltp;
  ltp_slots_ = show.ltp_slots;
  exchange.change.closed = static_cast<int>(exchange.old_ins.size() + exchange.old_outs.size());
  exchange.change.opened = static_cast<int>(exchange.added_ins.size() + exchange.added_outs.size());
  exchange.old_ins.clear();  // closes devices and files
  exchange.old_outs.clear();
  FL_TRY(open_late(exchange, pump, stopping));
  return std::move(exchange.change);
}

std::vector<const Source*> LiveShow::sources() const {
  std::vector<const Source*> sources;
  for (const In& in : ins_) sources.push_back(in.port.get());
  return sources;
}

std::vector<const Sink*> LiveShow::sinks() const {
  std::vector<const Sink*> sinks;
  for (const Out& out : outs_) sinks.push_back(out.port.get());
  return sinks;
}

}  // namespace footlight::tools
