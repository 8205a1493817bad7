#include "tools/footlight/status/json_lines.h"

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>

#include "fixtures/photometry/fit.h"
#include "fixtures/photometry/photometry.h"
#include "fixtures/photometry/table.h"
#include "tools/footlight/hand/hand_text.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {
namespace {

using Json = nlohmann::ordered_json;

std::string line_of(const Json& json) { return json.dump(-1, ' ', false, Json::error_handler_t::replace); }

Json timing(const Timing& timing) {
  return {{"count", timing.count}, {"p50_ns", timing.p50_ns}, {"p99_ns", timing.p99_ns}, {"max_ns", timing.max_ns}};
}

Json ports_of(const PumpStatus& status) {
  Json ports = Json::array();
  for (const PortStatus& port : status.ports) {
    Json universes = Json::array();
    for (const PortUniverseStatus& universe : port.universes) {
      Json one = {{"universe", universe.universe}, {"frames", universe.frames}, {"rate_hz", universe.rate_hz}};
      if (port.is_sink) {
        one["snapshots"] = universe.snapshots;
        one["replaced"] = universe.replaced;
        one["refused"] = universe.refused;
        one["waiting"] = universe.waiting;
      }
      universes.push_back(std::move(one));
    }
    Json json = {{"name", port.name},
                 {"direction", port.is_sink ? "out" : "in"},
                 {"state", name_of(port.state)},
                 {"trouble", port.trouble},
                 {"frames", port.frames},
                 {"rate_hz", port.rate_hz},
                 {"rejected", port.port.rejected},
                 {"dropped", port.port.dropped},
                 {"errors", port.port.errors},
                 {"replaced", port.replaced},
                 {"unrouted", port.unrouted},
                 {"failures", port.failures},
                 {"lateness", timing(port.lateness)},
                 {"latency", timing(port.latency)},
                 {"universes", std::move(universes)}};
    for (const PortFigure& figure : port.figures) json["figures"][figure.name] = figure.value;
    if (port.is_sink) {
      json["snapshots"] = port.snapshots;
      json["refused"] = port.refused;
      json["waiting"] = port.waiting;
      if (!port.standby_for.empty()) json["standby_for"] = port.standby_for;
      json["standby"] = port.standby;
    }
    ports.push_back(std::move(json));
  }
  return ports;
}

Json facts_of(const Event& event, const char* id_key) {
  Json json = {{"time", utc_text(event.unix_ns, 6)}, {"level", name_of(event.level)}, {id_key, event.id}};
  if (!event.port.empty()) json["port"] = event.port;
  if (event.universe != 0) json["universe"] = event.universe;
  json["text"] = event.text;
  return json;
}

Json universes_of(const PumpStatus& status) {
  Json universes = Json::array();
  for (const UniverseStatus& universe : status.universes) {
    Json senders = Json::array();
    for (const SenderStatus& sender : universe.senders) {
      senders.push_back({{"name", sender.name},
                         {"id", sender.id},
                         {"priority", sender.priority},
                         {"age_ns", sender.age_ns},
                         {"rate_hz", sender.rate_hz},
                         {"wins", sender.wins},
                         {"per_address", sender.per_address},
                         {"lost", sender.losses.lost},
                         {"late", sender.losses.late}});
    }
    const MergeCounters& merge = universe.merge;
    universes.push_back({{"universe", universe.universe},
                         {"rate_hz", universe.rate_hz},
                         {"writes", universe.writes},
                         {"winners", universe.winners},
                         {"priority", universe.priority},
                         {"frames", merge.frames},
                         {"shown", merge.frames_shown},
                         {"outranked", merge.frames_outranked},
                         {"priorities", merge.frames_priorities},
                         {"early", merge.frames_early},
                         {"ended", merge.frames_ended},
                         {"refused_priority", merge.refused_priority},
                         {"refused_full", merge.refused_full},
                         {"senders_displaced", merge.senders_displaced},
                         {"senders_silent", merge.senders_silent},
                         {"senders_ended", merge.senders_ended},
                         {"senders", std::move(senders)}});
  }
  return universes;
}

}  // namespace

std::string json_of_ready() { return line_of({{"event", "ready"}}); }

std::string json_of_notice(const Event& event) {
  Json json = {{"event", "notice"}};
  json.update(facts_of(event, "id"));
  return line_of(json);
}

std::string json_of_event(const Event& event) { return line_of(facts_of(event, "event")); }

std::string json_of_status(const PumpStatus& status) {
  return line_of({{"event", "status"},
                  {"stamp_ns", status.stamp_ns},
                  {"ports", ports_of(status)},
                  {"universes", universes_of(status)}});
}

std::string json_of_summary(const PumpStatus& status, DurationNs elapsed_ns) {
  return line_of({{"event", "summary"},
                  {"elapsed_ns", elapsed_ns},
                  {"ports", ports_of(status)},
                  {"universes", universes_of(status)}});
}

std::string json_of_levels(const Universes& universes, std::span<const Universe> requested, TimeNs now_ns) {
  static constexpr char kDigits[] = "0123456789abcdef";
  Json list = Json::array();
  Slots levels;
  FrameStamp stamp;
  std::string digits(2 * levels.size(), '0');
  for (const Universe universe : requested) {
    const int index = universes.index_of(universe);
    if (index < 0) continue;
    universes.snapshot(index, levels, stamp);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      digits[2 * i] = kDigits[levels[i] >> 4];
      digits[2 * i + 1] = kDigits[levels[i] & 15];
    }
    list.push_back(
        {{"universe", universe}, {"stamp_ns", stamp.stamp_ns}, {"revision", stamp.revision}, {"levels", digits}});
  }
  return line_of({{"event", "levels"}, {"now_ns", now_ns}, {"universes", std::move(list)}});
}

std::string json_of_reloads(std::uint64_t taken, std::uint64_t refused, bool running, const std::string& trouble) {
  return line_of(
      {{"event", "reload"}, {"taken", taken}, {"refused", refused}, {"running", running}, {"trouble", trouble}});
}

std::string json_of_hand(const HandReport& report, const std::string& rig) {
  std::map<int, std::vector<HandLevel>> by_priority;
  for (const HandSource::Held& each : report.held) {
    HandLevel level;
    level.universe = each.universe;
    level.slots[0] = static_cast<std::uint16_t>(slot_of_address(each.address));
    level.value = each.level;
    by_priority[each.priority].push_back(level);
  }
  Json held = Json::array();
  for (const auto& [priority, levels] : by_priority) {
    held.push_back({{"priority", priority}, {"levels", assignments_of(levels)}});
  }
  return line_of({{"event", "hand"},
                  {"version", kHandVersion},
                  {"blackout", report.blackout},
                  {"hold", report.hold},
                  {"fades", report.fades},
                  {"beats_a_minute", std::round(report.beats_a_minute * 1e3) / 1e3},
                  {"rig", rig},
                  {"held", held}});
}

std::string json_of_device(const drivers::FoundDevice& device) {
  using namespace drivers;
  const bool is_dmx = !device.driver_id.empty();
  return line_of({{"kind", is_dmx ? kind_of(device.transport) : "unknown"},
                  {"transport", device.way},
                  {"driver", device.driver_id},
                  {"model", device.model_name},
                  {"manufacturer", device.manufacturer},
                  {"product", device.product},
                  {"serial", device.serial},
                  {"usb_vendor", device.usb_vendor},
                  {"usb_product", device.usb_product},
                  {"port", device.port_path},
                  {"node", device.node},
                  {"kernel_driver", device.kernel_driver},
                  {"endpoint", device.endpoint},
                  {"can_output", (device.capabilities & kCanOutput) != 0},
                  {"can_input", (device.capabilities & kCanInput) != 0},
                  {"readiness", drivers::name_of(device.readiness)},
                  {"reason", device.reason},
                  {"remedy", device.remedy},
                  {"rebind", device.rebind}});
}

std::string json_of_gpio_chip(const drivers::FoundGpioChip& chip) {
  return line_of({{"kind", "gpio"},
                  {"name", chip.name},
                  {"label", chip.label},
                  {"lines", chip.line_count},
                  {"node", chip.node},
                  {"kernel_driver", chip.kernel_driver},
                  {"owner", chip.owner},
                  {"group", chip.group},
                  {"mode", fmt::format("{:04o}", chip.mode)},
                  {"open_to", chip.open_to},
                  {"readiness", drivers::name_of(chip.readiness)},
                  {"reason", chip.reason},
                  {"remedy", chip.remedy}});
}

std::string json_of_finding(const NetworkFinding& found) {
  return line_of({{"protocol", found.protocol},
                  {"name", found.name},
                  {"address", found.address},
                  {"id", found.id},
                  {"sends", found.sends},
                  {"receives", found.receives},
                  {"complete", found.complete}});
}

std::string json_of_check(const Check& check, const Outcome& outcome) {
  return line_of({{"check", check.id},
                  {"title", check.title},
                  {"verdict", name_of(outcome.verdict)},
                  {"seen", outcome.seen},
                  {"fix", outcome.fix}});
}

std::string json_of_rdm_device(const RdmDevice& device) {
  return line_of({{"uid", device.uid},
                  {"manufacturer", device.manufacturer},
                  {"model", device.model},
                  {"label", device.label},
                  {"software", device.software},
                  {"category", device.category},
                  {"footprint", device.footprint},
                  {"start_address", device.start_address},
                  {"personality", device.personality},
                  {"personalities", device.personalities},
                  {"personality_name", device.personality_name},
                  {"sub_devices", device.sub_devices},
                  {"sensors", device.sensors},
                  {"is_proxy", device.is_proxy},
                  {"is_proxied", device.is_proxied},
                  {"trouble", device.trouble}});
}

std::string json_of_rdm_fields(const std::string& uid, const std::string& parameter,
                               const std::vector<drivers::RdmField>& fields) {
  const auto value_of = [](const drivers::RdmField& field) -> Json {
    if (field.is_number) return std::stoll(field.text);
    return field.text;
  };
  Json values = Json::array();
  if (!fields.empty() && !fields.front().name.empty()) {
    values = Json::object();
    for (const auto& field : fields) values[field.name] = value_of(field);
  } else if (fields.size() == 1) {
    values = value_of(fields.front());
  } else {
    for (const auto& field : fields) values.push_back(value_of(field));
  }
  return line_of({{"uid", uid}, {"parameter", parameter}, {"values", values}});
}

namespace {

const char* word_of(LogFormat format) {
  switch (format) {
    case LogFormat::kDmxLog: return "dmxlog";
    case LogFormat::kOlaShow: return "ola-show";
    case LogFormat::kPacketCapture: return "packet-capture";
    case LogFormat::kLineCapture: return "line-capture";
    case LogFormat::kSound: return "sound";
    case LogFormat::kVideo: return "video";
  }
  return "?";
}

}  // namespace

std::string json_of_log(const LogInfo& info, const std::vector<std::string>& notes) {
  Json universes = Json::array();
  for (const LogUniverseInfo& universe : info.universes) {
    universes.push_back({{"universe", universe.universe},
                         {"frames", universe.frames},
                         {"changes", universe.changes},
                         {"slots", universe.slot_count},
                         {"first_ns", universe.first_ns},
                         {"last_ns", universe.last_ns},
                         {"rate_hz", universe.rate_hz()}});
  }
  Json damage = Json::array();
  for (const LogDamage& part : info.damage) {
    damage.push_back({{"offset", part.offset}, {"size_bytes", part.size_bytes}, {"what", part.what}});
  }
  return line_of({{"path", info.path},
                  {"format", word_of(info.format)},
                  {"duration_ns", info.duration_ns},
                  {"wall_start_unix_ns", info.wall_start_unix_ns},
                  {"frames", info.frames},
                  {"changes", info.changes},
                  {"file_bytes", info.file_bytes},
                  {"finished", info.finished},
                  {"checked", info.checked},
                  {"damage_count", info.damage_count},
                  {"damage_bytes", info.damage_bytes},
                  {"damage", std::move(damage)},
                  {"notes", notes},
                  {"universes", std::move(universes)}});
}

std::string json_of_line_timing(const std::string& path, const drivers::LineCaptureInfo& info) {
  Json frames = Json::array();
  for (const drivers::LineFrameTiming& frame : info.frames) {
    Json one = {{"start_ns", frame.start_ns},
                {"break_ns", frame.break_ns},
                {"mab_ns", frame.mab_ns},
                {"start_code", frame.start_code},
                {"slots", frame.slot_count},
                {"gap_min_ns", frame.gap_min_ns},
                {"gap_mean_ns", frame.slot_count == 0 ? 0 : frame.gap_sum_ns / frame.slot_count},
                {"gap_max_ns", frame.gap_max_ns},
                {"pitch_min_ns", frame.pitch_min_ns},
                {"end_ns", frame.end_ns},
                {"period_ns", frame.period_ns},
                {"unfinished", frame.unfinished},
                {"sound", frame.fault == drivers::LineFault::kNone}};
    if (frame.fault != drivers::LineFault::kNone) one["reason"] = text_of(frame.fault);
    frames.push_back(std::move(one));
  }
  return line_of({{"path", path},
                  {"channel", info.channel},
                  {"inverted", info.inverted},
                  {"sample_rate_hz", info.sample_rate_hz},
                  {"duration_ns", info.duration_ns},
                  {"sound", info.counters.sound},
                  {"rejected", info.counters.rejected},
                  {"glitches", info.counters.glitches},
                  {"notes", info.notes},
                  {"frames", std::move(frames)}});
}

std::string json_of_log_diff(const std::string& a, const std::string& b, const LogDiff& diff) {
  constexpr const char* kFrom[] = {"given", "changes", "first-frames", "nothing"};
  Json universes = Json::array();
  for (const LogUniverseDiff& one : diff.universes) {
    Json universe = {{"universe", one.universe},
                     {"frames_a", one.frames_a},
                     {"frames_b", one.frames_b},
                     {"pairs", one.pairs},
                     {"only_a", one.only_a},
                     {"only_b", one.only_b},
                     {"different", one.different},
                     {"slots_different", one.slots_different},
                     {"level_distance_max", one.level_distance_max},
                     {"time_p50_ns", one.times.p50_ns},
                     {"time_p99_ns", one.times.p99_ns},
                     {"time_max_ns", one.times.max_ns},
                     {"drift_ppm", one.drift_ppm}};
    if (one.first_address != 0) {
      universe["first_difference"] = {{"time_ns", one.first_ns},
                                      {"address", one.first_address},
                                      {"level_a", one.first_level_a},
                                      {"level_b", one.first_level_b}};
    }
    universes.push_back(std::move(universe));
  }
  return line_of({{"a", a},
                  {"b", b},
                  {"equal", diff.equal},
                  {"duration_a_ns", diff.duration_a_ns},
                  {"duration_b_ns", diff.duration_b_ns},
                  {"offset_ns", diff.offset_ns},
                  {"offset_from", kFrom[static_cast<std::size_t>(diff.offset_from)]},
                  {"offset_votes", diff.offset_votes},
                  {"universes", std::move(universes)}});
}

std::string json_of_conversion(const std::string& in, const std::string& out, const ConvertReport& report) {
  return line_of({{"in", in},
                  {"out", out},
                  {"frames", report.frames},
                  {"left_out", report.left_out},
                  {"duration_ns", report.duration_ns},
                  {"lead_dropped_ns", report.lead_dropped_ns},
                  {"bytes_in", report.bytes_in},
                  {"bytes_out", report.bytes_out},
                  {"damage_count", report.damage_count},
                  {"other_universes", report.other_universes},
                  {"absent_universes", report.absent},
                  {"late_stamps", report.late_stamps},
                  {"notes", report.notes}});
}

namespace {

Json json_of(const std::vector<fixtures::Diagnostic>& diagnostics) {
  Json json = Json::array();
  for (const fixtures::Diagnostic& one : diagnostics) {
    json.push_back({{"severity", severity_name(one.severity)},
                    {"code", one.code},
                    {"file", one.place.file},
                    {"line", one.place.line},
                    {"column", one.place.column},
                    {"message", one.message},
                    {"assumed", one.assumed}});
  }
  return json;
}

}  // namespace

std::string json_of_fixture_check(const FixtureCheck& check) {
  return line_of({{"file", check.file},
                  {"format", check.format},
                  {"status", status_name(check.status)},
                  {"manufacturer", check.manufacturer},
                  {"name", check.name},
                  {"modes", check.modes},
                  {"diagnostics", json_of(check.diagnostics)}});
}

std::string json_of_beam(const std::string& name, const fixtures::FixtureType& type, std::size_t index) {
  constexpr double kDegrees = 180 / std::numbers::pi;
  const fixtures::Beam& beam = type.beams[index];
  Json row = {{"type", name}, {"beam", index + 1}, {"flux_lm", beam.flux_lm}};
  if (!beam.photometry.empty()) {
    row["photometry"] = beam.photometry;
    const auto photometry = fixtures::read_photometry_file(type.files, beam.photometry);
    if (!photometry) {
      row["trouble"] = photometry.error().message;
      return line_of(row);
    }
    const auto side = beam.photometry_back ? fixtures::Side::kBack : fixtures::Side::kFront;
    const fixtures::MeasuredTable table = fixtures::measured_table(*photometry, side);
    row["to_deg"] = table.half_angle_rad * kDegrees;
    row["angles"] = table.rings;
    row["planes"] = table.columns;
    row["error"] = table.error;
    row["left_out_lm"] = table.left_out_lm;
    row["integrated_lm"] = fixtures::integrated_lm(*photometry);
    row["stated_lm"] = photometry->stated_lm;
    row["stated_of_lamps"] = photometry->stated_of_lamps;
  } else if (const auto rectangle = fixtures::rectangle_of(beam)) {
    const double half_width = std::tan(rectangle->half_angle_rad);
    row["width_deg"] = 2 * rectangle->half_angle_rad * kDegrees;
    row["height_deg"] = 2 * std::atan(half_width / rectangle->aspect) * kDegrees;
  } else {
    const fixtures::BeamFit fit = fixtures::drawn_beam(beam);
    row["beam_angle_deg"] = beam.beam_angle_deg;
    row["field_angle_deg"] = beam.field_angle_deg;
    if (beam.profile_power > 0) row["profile_power"] = fit.profile_power;
    row["drawn_beam_angle_deg"] = fit.beam_angle_deg;
    row["drawn_field_angle_deg"] = fit.field_angle_deg;
    row["angle_error"] = fit.angle_error;
    row["peak_cd"] = fit.peak_cd;
    row["assumed"] = fit.assumed;
  }
  return line_of(row);
}

std::string json_of_color(const std::string& type, const fixtures::ColorError& color) {
  const auto numbers = [](const fixtures::ColorXyY& c) { return Json::array({c.x, c.y, c.Y}); };
  return line_of({{"type", type},
                  {"what", color.what},
                  {"reference", numbers(color.reference)},
                  {"drawn", numbers(color.drawn)},
                  {"delta_e", color.delta_e},
                  {"delta_e_mixing", color.delta_e_mixing},
                  {"by_spectrum", color.by_spectrum}});
}

std::string json_of_rig_check(const RigCheck& check) {
  Json assumptions = Json::array();
  for (const fixtures::Assumption& each : check.assumptions) {
    assumptions.push_back({{"code", each.code},
                           {"requested", each.wanted},
                           {"used", each.used},
                           {"why", each.why},
                           {"count", each.count}});
  }
  return line_of({{"file", check.file},
                  {"format", check.format},
                  {"status", status_name(check.status)},
                  {"fixtures", check.fixtures},
                  {"diagnostics", json_of(check.diagnostics)},
                  {"assumptions", std::move(assumptions)}});
}

}  // namespace footlight::tools
