// footlight fixtures show: prints the content of a definition.
#include <algorithm>
#include <cstdio>
#include <iterator>
#include <memory>
#include <vector>

#include <fmt/ranges.h>

#include "fixtures/displays/screens.h"
#include "fixtures/files/import/import.h"
#include "fixtures/files/import/text.h"
#include "fixtures/gobos/gobo_images.h"
#include "fixtures/mirrors/mirror_ball.h"
#include "fixtures/model/attributes.h"
#include "fixtures/model/lamp.h"
#include "fixtures/model/params.h"
#include "fixtures/simulate/machines.h"
#include "tools/footlight/commands/fixtures_command.h"
#include "tools/footlight/status/printable.h"

namespace footlight::tools {
namespace {

using namespace fixtures;

class Writer {
 public:
  explicit Writer(const FixtureType& type) : type_(type) {}

  std::string take() { return std::move(text_); }

  void write_head() {
    const Provenance& from = type_.provenance;
    line(0, "{} {}", type_.manufacturer, type_.name);
    line(1, "{}{}{}", from.format, from.version.empty() ? "" : " " + from.version,
         from.file.empty() ? "" : ", " + from.file);
    if (!type_.id.empty()) line(1, "id {}", type_.id);
    if (!type_.description.empty()) line(1, "{}", type_.description);
    if (type_.weight_kg > 0) line(1, "{} kg", type_.weight_kg);
    if (type_.power_w > 0) line(1, "{} W", type_.power_w);
    if (type_.modes.size() > 1) {
      line(0, "Modes");
      for (std::size_t i = 0; i < type_.modes.size(); ++i) line(1, "{}  {}", i + 1, summary(type_.modes[i]));
    }
  }

  void write_parts() {
    for (const Wheel& wheel : type_.wheels) {
      line(0, "Wheel {}", wheel.name);
      for (std::size_t i = 0; i < wheel.slots.size(); ++i) line(1, "{:>2}  {}", i + 1, slot(wheel.slots[i]));
    }
    write_sources("Emitters", type_.emitters);
    write_sources("Filters", type_.filters);
    if (!type_.models.empty()) line(0, "Bodies");
    for (const Model& model : type_.models) {
      line(1, "{}: {:.3g} x {:.3g} x {:.3g} m, {}", model.name, model.size_m.x, model.size_m.y, model.size_m.z,
           !model.file.empty()                   ? model.file
           : model.primitive == Primitive::kNone ? "a box"
                                                 : "a primitive");
    }
  }

  void write_mode(const Mode& mode) {
    line(0, "Mode {}", summary(mode));
    if (!mode.description.empty()) line(1, "{}", mode.description);
    line(1, "Geometries");
    write_tree(mode);
    std::vector<std::string> names;
    for (const Remark& one : unsimulated(type_, mode)) names.push_back(one.what);
    if (!names.empty()) {
      line(1, "Read, but not simulated: {}", fmt::join(names, ", "));
    }
    names.clear();
    for (const Remark& one : shows_nothing(mode)) names.push_back(one.what);
    if (!names.empty()) line(1, "Read, without a visible effect: {}", fmt::join(names, ", "));
    if (makes_haze(mode)) line(1, "Machine: produces haze or fog in the room ([room] of the rig)");
    std::vector<std::string> lamps;
    for (const Geometry& geometry : mode.geometries) {
      if (geometry.beam == kNoIndex) continue;
      const std::string lamp = lamp_text(type_, type_.beams[index(geometry.beam)], lamp_use(mode));
      if (!lamp.empty() && std::find(lamps.begin(), lamps.end(), lamp) == lamps.end()) lamps.push_back(lamp);
    }
    for (const std::string& lamp : lamps) line(1, "Lamp {}", lamp);
    line(1, "Dimmer law: {}", dimmer_law_words()[static_cast<std::size_t>(type_.dimmer_law)]);
    line(1, "Channels");
    for (const Channel& channel : mode.channels) write_channel(mode, channel);
    for (const Relation& relation : mode.relations) {
      const Channel& follower = mode.channels[index(relation.follower)];
      line(2, "{} {} {}{}", mode.channels[index(relation.master)].name, relation.overrides ? "overrides" : "multiplies",
           follower.name, relation.function == kNoIndex ? "" : " " + follower.functions[index(relation.function)].name);
    }
  }

 private:
  static std::size_t index(int i) { return static_cast<std::size_t>(i); }

  template <class... Args>
  void line(int depth, fmt::format_string<Args...> format, Args&&... args) {
    text_.append(static_cast<std::size_t>(depth) * 2, ' ');
    fmt::format_to(std::back_inserter(text_), format, std::forward<Args>(args)...);
    text_ += '\n';
  }

  static std::string summary(const Mode& mode) {
    std::string slots;
    if (mode.break_slot_counts.empty()) {
      slots = fmt::format("{} {}", mode.slot_count, mode.slot_count == 1 ? "slot" : "slots");
    }
    for (const auto& [dmx_break, count] : mode.break_slot_counts) {
      slots += fmt::format("{}{} slots of break {}", slots.empty() ? "" : ", ", count, dmx_break);
    }
    std::size_t virtual_count = 0;
    for (const Channel& channel : mode.channels) virtual_count += channel.slot_offsets.empty() ? 1u : 0u;
    return fmt::format("{}: {}, {} channels{}", mode.name, slots, mode.channels.size(),
                       virtual_count == 0 ? "" : fmt::format(", {} of them virtual", virtual_count));
  }

  static std::string color(const ColorXyY& c) { return fmt::format("x {:.4g} y {:.4g} Y {:.4g}", c.x, c.y, c.Y); }

  [[nodiscard]] std::string slot(const WheelSlot& slot) const {
    std::string text = slot.name;
    if (slot.open) return text + ": open";
    if (!slot.image.empty()) text += ": " + slot.image;
    if (!slot.facets.empty()) text += fmt::format(": prism of {} facets", slot.facets.size());
    if (slot.is_animation) text += ": animation";
    if (slot.filter != kNoIndex) text += ": filter " + type_.filters[index(slot.filter)].name;
    return text + ": " + color(slot.color);
  }

  void write_sources(const char* title, const std::vector<ColorSource>& sources) {
    if (!sources.empty()) line(0, "{}", title);
    for (const ColorSource& source : sources) {
      std::size_t points = 0;
      for (const ColorMeasurement& one : source.measurements) points += one.spectrum.size();
      line(1, "{}: {}{}{}", source.name, color(source.color),
           source.dominant_wavelength_nm > 0 ? fmt::format(", {:.4g} nm", source.dominant_wavelength_nm) : "",
           points > 0 ? fmt::format(", spectrum of {} points", points) : "");
    }
  }

  void write_tree(const Mode& mode) {
    std::vector<int> depths;
    const std::vector<fixtures::Screen> screens = screens_of(type_, mode);
    for (const Geometry& geometry : mode.geometries) {
      depths.push_back(geometry.parent == kNoIndex ? 0 : depths[index(geometry.parent)] + 1);
      std::string text = fmt::format("{} ({})", geometry.name, is_tube(geometry) ? "tube" : kind_name(geometry.kind));
      const glm::dvec3 at(geometry.pose[3]);
      if (at != glm::dvec3(0)) text += fmt::format(" at {:.4g} {:.4g} {:.4g} m", at.x, at.y, at.z);
      if (geometry.model != kNoIndex) text += ", body " + type_.models[index(geometry.model)].name;
      if (geometry.beam != kNoIndex) {
        const Beam& its = type_.beams[index(geometry.beam)];
        text += ", " + (is_tube(geometry) ? tube(its, geometry.tube_m) : beam(its));
      }
      if (geometry.laser != kNoIndex) text += ", " + laser(type_.lasers[index(geometry.laser)]);
      for (const fixtures::Screen& screen : screens) {
        if (&mode.geometries[index(screen.geometry)] != &geometry) continue;
        text += fmt::format(", {:.4g} x {:.4g} m, dark without content in a rig file", screen.width_m, screen.height_m);
      }
      if (geometry.mirror_ball != kNoIndex) text += ", " + mirrors(type_.mirror_balls[index(geometry.mirror_ball)]);
      line(2 + std::min(depths.back(), 20), "{}", text);
    }
  }

  static const char* kind_name(GeometryKind kind) {
    switch (kind) {
      case GeometryKind::kPlain: return "part";
      case GeometryKind::kAxis: return "axis";
      case GeometryKind::kBeam: return "beam";
      case GeometryKind::kFilterBeam: return "beam filter";
      case GeometryKind::kFilterColor: return "colour filter";
      case GeometryKind::kFilterGobo: return "gobo filter";
      case GeometryKind::kFilterShaper: return "shaper";
      case GeometryKind::kLaser: return "laser";
      case GeometryKind::kDisplay: return "display";
      case GeometryKind::kMediaServer: return "media server";
      case GeometryKind::kMediaLayer: return "media layer";
      case GeometryKind::kMediaCamera: return "media camera";
      case GeometryKind::kWiring: return "wiring";
      case GeometryKind::kInventory: return "inventory";
      case GeometryKind::kStructure: return "structure";
      case GeometryKind::kSupport: return "support";
      case GeometryKind::kMagnet: return "magnet";
    }
    return "part";
  }

  static bool is_tube(const Geometry& geometry) {
    return geometry.beam != kNoIndex && geometry.tube_m != glm::dvec2(0);
  }

  static std::string tube(const Beam& beam, const glm::dvec2& size_m) {
    return fmt::format("{:.5g} lm, {:.5g} K, {:.3g} m long and {:.3g} m wide, {:.4g} cd/m2 to all directions before it",
                       beam.flux_lm, beam.color_temperature_k, std::max(size_m.x, size_m.y),
                       std::min(size_m.x, size_m.y), tube_nits(beam, size_m));
  }

  static std::string beam(const Beam& beam) {
    const char* type = "";
    switch (beam.type) {
      case BeamType::kWash: type = "wash"; break;
      case BeamType::kSpot: type = "spot"; break;
      case BeamType::kNone: type = "no beam"; break;
      case BeamType::kRectangle: type = "rectangle"; break;
      case BeamType::kPc: type = "PC"; break;
      case BeamType::kFresnel: type = "fresnel"; break;
      case BeamType::kGlow: type = "glow"; break;
    }
    return fmt::format("{}, {:.5g} lm, {:.5g} K, beam {:.4g} deg, field {:.4g} deg, lens {:.3g} m{}", type,
                       beam.flux_lm, beam.color_temperature_k, beam.beam_angle_deg, beam.field_angle_deg, beam.radius_m,
                       beam.face_m.x > 0 ? fmt::format(", {:.3g} x {:.3g} m", beam.face_m.x, beam.face_m.y) : "");
  }

  static std::string mirrors(const MirrorBall& ball) {
    return fmt::format("ball {:.4g} m wide with {} mirrors of {:.4g} m", ball.diameter_m, mirror_count(ball),
                       ball.mirror_m);
  }

  static std::string laser(const Laser& laser) {
    return fmt::format("{}, {:.4g} W, {:.3g} mrad, scans {:.4g} x {:.4g} deg",
                       laser.wavelength_nm > 0 ? fmt::format("{:.4g} nm", laser.wavelength_nm) : "full colour",
                       laser.power_w, laser.divergence_mrad, laser.scan_pan_deg, laser.scan_tilt_deg);
  }

  void write_channel(const Mode& mode, const Channel& channel) {
    std::string slots;
    for (const int slot : channel.slot_offsets) slots += fmt::format("{}{}", slots.empty() ? "" : ",", slot + 1);
    if (slots.empty()) slots = "virtual";
    if (mode.break_slot_counts.size() > 1 && !channel.slot_offsets.empty()) {
      slots += fmt::format(" of break {}", channel.dmx_break);
    }
    line(2, "{}  {}: {} bits, default {}{}{}", slots, channel.name, 8 * channel.byte_count, channel.default_value,
         channel.has_highlight ? fmt::format(", highlight {}", channel.highlight_value) : "",
         channel.snap ? ", snaps" : "");
    for (const ChannelFunction& function : channel.functions) write_function(mode, function);
  }

  static std::string range(const AttributeInfo& info, double from, double to) {
    const std::string unit = unit_text(info.unit);
    const std::string end = unit.empty() ? "" : " " + unit;
    return from == to ? fmt::format("{:.5g}{}", from, end) : fmt::format("{:.5g} to {:.5g}{}", from, to, end);
  }

  void write_function(const Mode& mode, const ChannelFunction& function) {
    const AttributeInfo info = attribute_info(function.attribute);
    std::string text = fmt::format("{}-{}  {}", function.dmx_from, function.dmx_to, function.attribute);
    if (function.name != function.attribute && !function.name.empty()) text += fmt::format(" \"{}\"", function.name);
    text += ": " + range(info, function.physical_from, function.physical_to);
    if (function.real_fade_s > 0) text += fmt::format(", {:.4g} s from end to end", function.real_fade_s);
    if (function.real_acceleration_s > 0) text += fmt::format(", {:.4g} s to full speed", function.real_acceleration_s);
    if (function.wheel != kNoIndex) text += ", wheel " + type_.wheels[index(function.wheel)].name;
    if (function.emitter != kNoIndex) text += ", emitter " + type_.emitters[index(function.emitter)].name;
    if (function.filter != kNoIndex) text += ", filter " + type_.filters[index(function.filter)].name;
    for (const MasterCondition& master : function.masters) {
      text += fmt::format(", while {} is {} to {}", mode.channels[index(master.channel)].name, master.dmx_from,
                          master.dmx_to);
    }
    line(4, "{}", text);
    for (const ChannelSet& set : function.sets) {
      if (set.name.empty() && set.wheel_slot == 0) continue;
      line(6, "{}-{}  {}{}: {}", set.dmx_from, set.dmx_to, set.name,
           set.wheel_slot > 0 ? fmt::format(" (slot {})", set.wheel_slot) : "",
           range(info, set.physical_from, set.physical_to));
    }
  }

  const FixtureType& type_;
  std::string text_;
};

struct Options {
  std::string file;
  std::string mode;
  bool optics = false;
};

Result<int> show(const Options& options) {
  if (options.file.empty())
    return fail(ErrorCode::kBadInput, "nothing to show; name a file: 'footlight fixtures show head.gdtf'");
  FL_ASSIGN(const Imported imported, import_fixture(options.file));
  Diagnostics images;
  check_images(imported.type, images);
  for (const Diagnostic& one : images.all()) fmt::print(stderr, "footlight: {}\n", printable_line(text(one)));
  if (options.optics) {
    fmt::print("{}", printable_lines(optics_of_type(imported.type)));
  } else {
    FL_ASSIGN(const std::string text, text_of_type(imported.type, options.mode));
    fmt::print("{}", printable_lines(text));
  }
  std::size_t wrong = 0;
  for (const Diagnostic& one : imported.diagnostics) wrong += one.severity != Severity::kNote ? 1u : 0u;
  if (wrong > 0) {
    fmt::print(stderr, "footlight: {} errors and warnings; 'footlight fixtures check --notes {}' lists them\n", wrong,
               printable_utf8(options.file));
  }
  return kExitOk;
}

}  // namespace

Result<std::string> text_of_type(const FixtureType& type, std::string_view mode) {
  std::vector<const Mode*> shown;
  for (std::size_t i = 0; i < type.modes.size(); ++i) {
    if (mode.empty() || equal_any_case(type.modes[i].name, mode)) shown.push_back(&type.modes[i]);
  }
  if (const auto number = integer_of(mode);
      shown.empty() && number && *number >= 1 && *number <= static_cast<std::int64_t>(type.modes.size())) {
    shown.push_back(&type.modes[static_cast<std::size_t>(*number - 1)]);
  }
  if (shown.empty() && !mode.empty()) {
    std::string names;
    for (const Mode& one : type.modes) names += fmt::format("{}\"{}\"", names.empty() ? "" : ", ", one.name);
    return fail(ErrorCode::kNotFound, "no mode \"{}\"; expected {}", mode,
                names.empty() ? "none, it has no modes" : names);
  }
  Writer writer(type);
  writer.write_head();
  writer.write_parts();
  for (const Mode* one : shown) writer.write_mode(*one);
  return writer.take();
}

void add_fixtures_show(Arguments& arguments) {
  Arguments show_arguments =
      arguments.subcommand("show", "Show the modes, channels, functions, geometries, beams and wheels of a definition",
                           "  footlight fixtures show head.gdtf\n"
                           "  footlight fixtures show head.qxf --mode \"16 Channel\"\n"
                           "  footlight fixtures show head.gdtf --mode 2\n"
                           "'footlight fixtures check' lists errors in the file.");
  auto options = std::make_shared<Options>();
  show_arguments.word("FILE", options->file, "a definition, or the folder of an unpacked one");
  show_arguments.option("--mode", options->mode, "NAME", "only this mode, by name or by number");
  show_arguments.flag("--optics", options->optics,
                      "show instead how beams and colours are drawn, and the differences from the definition");
  show_arguments.job([options]() -> Result<int> { return show(*options); });
}

}  // namespace footlight::tools
