#include "tools/footlight/live_show.h"

#include <algorithm>
#include <chrono>
#include <future>

#include "tools/footlight/bridge.h"

namespace footlight::tools {
namespace {

// Both want the same thing to themselves.
bool collide(const Endpoint& a, const Endpoint& b) {
  return a.kind == b.kind && a.kind != EndpointKind::kNetwork && a.scheme == b.scheme && a.target == b.target;
}

// Universes of the show file and of the endpoints. What a log brings is known when it is open.
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

// Has the pump's thread do it, and waits until it has.
Status on_pump(Pump& pump, std::function<void()> job, const std::function<bool()>& stopping) {
  const auto done = std::make_shared<std::promise<void>>();
  const auto finished = done->get_future();
  pump.call([job = std::move(job), done] {
    job();
    done->set_value();
  });
  while (finished.wait_for(std::chrono::milliseconds(20)) != std::future_status::ready) {
    if (stopping()) return fail(ErrorCode::kTimeout, "the bridge stopped meanwhile");
  }
  return {};
}

// A port of the network, and not the demo show.
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

Result<ShowChange> LiveShow::change_to(const Show& show, Pump& pump, const std::function<bool()>& stopping) {
  std::vector<In> ins;
  std::vector<Out> outs;
  for (const InPlan& plan : show.ins) ins.push_back({plan, nullptr});
  for (const OutPlan& plan : show.outs) outs.push_back({plan, nullptr});

  // What stays: each port of old for one line of the file. Who stands by stays only with the one that it stands by for.
  std::vector<In> old_ins = ins_;
  std::vector<Out> old_outs = outs_;
  ShowChange change;
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
  // From here on old_... are those that go. Those of the new that cannot be opened before:
  const auto must_wait = [&](const Endpoint& endpoint) {
    return std::any_of(old_ins.begin(), old_ins.end(),
                       [&](const In& old) { return !old.plan.demo && collide(old.plan.endpoint, endpoint); }) ||
           std::any_of(old_outs.begin(), old_outs.end(),
                       [&](const Out& old) { return collide(old.plan.endpoint, endpoint); });
  };
  std::vector<In*> late_ins;
  std::vector<Out*> late_outs;
  for (In& in : ins)
    if (in.port == nullptr && !in.plan.demo && must_wait(in.plan.endpoint)) late_ins.push_back(&in);
  for (Out& out : outs) {
    if (out.port != nullptr) continue;
    const bool primary_late = std::any_of(late_outs.begin(), late_outs.end(), [&](const Out* late) {
      return late->plan.endpoint.text == out.plan.standby_for;
    });
    if (primary_late || must_wait(out.plan.endpoint)) late_outs.push_back(&out);
  }

  // Devices and files open here, however long that takes.
  const auto is_late = [](const auto& late, const auto& port) {
    return std::find(late.begin(), late.end(), &port) != late.end();
  };
  std::vector<Universe> universes = named_universes(show);
  std::vector<In*> added_ins;
  std::vector<Out*> added_outs;
  for (In& in : ins) {
    if (in.port == nullptr && !is_late(late_ins, in)) {
      added_ins.push_back(&in);
      if (!network(in)) {
        FL_ASSIGN(in.port, open_in(in.plan));
      }
    }
    if (in.port != nullptr) universes.insert(universes.end(), in.port->universes().begin(), in.port->universes().end());
  }
  universes = sorted_once(std::move(universes));
  FL_TRY(check_ltp(show, universes));
  for (Out& out : outs) {
    if (out.port != nullptr || is_late(late_outs, out)) continue;
    added_outs.push_back(&out);
    if (!network(out)) {
      FL_ASSIGN(out.port, open_out(out.plan, universes));
    }
  }
  std::shared_ptr<Universes> buffer = buffer_;
  const auto numbers = buffer_->numbers();
  const bool moves = !std::equal(universes.begin(), universes.end(), numbers.begin(), numbers.end()) ||
                     !(show.merge == merge_) || show.ltp != ltp_ || show.ltp_slots != ltp_slots_;
  if (moves) {
    FL_ASSIGN(buffer, Universes::make(universes));
  }

  // Network ports know of each other and so belong to the pump's thread from their begin to their end. They open last:
  // what they hear from then on waits in their sockets. Once they are open nothing can be refused. Sources come before
  // the others go, so that nothing is missed; sinks go before the others come, so that the last words of one are not
  // taken for those of the next.
  const auto open_networks = [&]() -> Status {
    for (In* in : added_ins) {
      if (in->port != nullptr) continue;
      FL_ASSIGN(in->port, open_in(in->plan));
    }
    for (Out* out : added_outs) {
      if (out->port != nullptr) continue;
      FL_ASSIGN(out->port, open_out(out->plan, universes));
    }
    return {};
  };
  Status opened;
  FL_TRY(on_pump(
      pump,
      [&] {
        opened = open_networks();
        if (!opened) {
          for (In* in : added_ins)
            if (network(*in)) in->port.reset();
          for (Out* out : added_outs)
            if (network(*out)) out->port.reset();
          return;
        }
        if (moves) {
          pump.move_to(buffer, show.merge);
          set_modes(pump, show.ltp, show.ltp_slots);
        }
        for (const In* in : added_ins) pump.add_source(*in->port);
        for (const In& old : old_ins) pump.remove_source(*old.port);
        for (auto old = old_outs.rbegin(); old != old_outs.rend(); ++old) pump.remove_sink(*old->port);
        for (const Out* out : added_outs) add_out(pump, outs, *out);
        ins_ = ins;
        outs_ = outs;
        for (In& old : old_ins)
          if (network(old)) old.port.reset();
        for (Out& old : old_outs)
          if (network(old)) old.port.reset();
      },
      stopping));
  FL_TRY(opened);
  buffer_ = buffer;
  merge_ = show.merge;
  ltp_ = show.ltp;
  ltp_slots_ = show.ltp_slots;
  change.closed = static_cast<int>(old_ins.size() + old_outs.size());
  change.opened = static_cast<int>(added_ins.size() + added_outs.size());
  old_ins.clear();  // gives devices and files back
  old_outs.clear();

  // Those that had to wait. One that does not come back is kept waiting for.
  for (In* in : late_ins) {
    InPlan plan = in->plan;
    plan.options.wait_for_device = true;
    auto source = open_in(plan);
    if (source) {
      in->port = std::move(*source);
    } else {
      change.troubles.push_back(source.error().message);
    }
  }
  for (Out* out : late_outs) {
    OutPlan plan = out->plan;
    plan.options.wait_for_device = true;
    auto sink = open_out(plan, universes);
    if (sink) {
      out->port = std::move(*sink);
    } else {
      change.troubles.push_back(sink.error().message);
    }
  }
  const auto without_port = [](const auto& entry) { return entry.port == nullptr; };
  std::vector<Source*> late_sources;
  std::vector<const Sink*> late_sinks;
  for (const In* in : late_ins)
    if (in->port != nullptr) late_sources.push_back(in->port.get());
  for (const Out* out : late_outs)
    if (out->port != nullptr) late_sinks.push_back(out->port.get());
  ins_ = std::move(ins);
  outs_ = std::move(outs);
  std::erase_if(ins_, without_port);
  std::erase_if(outs_, without_port);
  change.opened += static_cast<int>(late_sources.size() + late_sinks.size());
  if (late_sources.empty() && late_sinks.empty()) return change;
  FL_TRY(on_pump(
      pump,
      [&] {
        for (Source* source : late_sources) pump.add_source(*source);
        for (const Out& out : outs_) {
          const bool late = std::find(late_sinks.begin(), late_sinks.end(), out.port.get()) != late_sinks.end();
          if (late) add_out(pump, outs_, out);
        }
      },
      stopping));
  return change;
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
