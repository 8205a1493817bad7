#include "tools/footlight/preview/ui/known_texts.h"

#include <algorithm>
#include <array>
#include <cstdlib>
#include <vector>

#include <fmt/args.h>

#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

// Texts that are always the same. They are here for the catalog: tr() looks them up.
[[maybe_unused]] constexpr const char* kWhole[] = {
    // PortState, FlashMode.
    tr_mark("working"),
    tr_mark("waiting"),
    tr_mark("gone"),
    tr_mark("ended"),
    tr_mark("off"),
    tr_mark("warn"),
    tr_mark("limit"),
    tr_mark("off: are not looked for"),
    tr_mark("warn: a message"),
    tr_mark("limit: the last harmless picture stays"),
    // Faders.
    tr_mark("dimmer"),
    tr_mark("brightness"),
    tr_mark("hue"),
    tr_mark("saturation"),
    tr_mark("red"),
    tr_mark("green"),
    tr_mark("blue"),
    tr_mark("white"),
    tr_mark("warm white"),
    tr_mark("cold white"),
    tr_mark("amber"),
    tr_mark("yellow"),
    tr_mark("lime"),
    tr_mark("blue green"),
    tr_mark("cyan"),
    tr_mark("light blue"),
    tr_mark("purple"),
    tr_mark("magenta"),
    tr_mark("pink"),
    tr_mark("ultraviolet"),
    tr_mark("colour"),
    tr_mark("colour 2"),
    tr_mark("colour 3"),
    tr_mark("pan"),
    tr_mark("tilt"),
    tr_mark("zoom"),
    tr_mark("focus"),
    tr_mark("iris"),
    tr_mark("gobo"),
    tr_mark("gobo turn"),
    tr_mark("gobo 2"),
    tr_mark("animation"),
    tr_mark("prism"),
    tr_mark("frost"),
    tr_mark("blade below"),
    tr_mark("blade left"),
    tr_mark("blade above"),
    tr_mark("blade right"),
    tr_mark("haze"),
    tr_mark("fog"),
    tr_mark("fan"),
    tr_mark("blower"),
    // Columns of a trace of a head (docs/trace.md), without their units; some are among the faders.
    tr_mark("light"),
    tr_mark("beams"),
    tr_mark("turn"),
    tr_mark("shutter"),
    tr_mark("color1"),
    tr_mark("color2"),
    tr_mark("gobo1"),
    tr_mark("gobo2"),
    tr_mark("prism1"),
    tr_mark("prism2"),
    tr_mark("gobo1 turn"),
    tr_mark("gobo2 turn"),
    tr_mark("animation turn"),
    tr_mark("prism1 turn"),
    tr_mark("prism2 turn"),
    tr_mark("blade1 a"),
    tr_mark("blade1 b"),
    tr_mark("blade2 a"),
    tr_mark("blade2 b"),
    tr_mark("blade3 a"),
    tr_mark("blade3 b"),
    tr_mark("blade4 a"),
    tr_mark("blade4 b"),
    tr_mark("blade1"),
    tr_mark("blade2"),
    tr_mark("blade3"),
    tr_mark("blade4"),
    tr_mark("lens x"),
    tr_mark("lens y"),
    tr_mark("lens z"),
    tr_mark("beam x"),
    tr_mark("beam y"),
    tr_mark("beam z"),
    // What a definition is (fixtures/paperwork/plan.h).
    tr_mark("moving head"),
    tr_mark("moving wash light"),
    tr_mark("profile"),
    tr_mark("media server"),
    tr_mark("par, flood"),
    tr_mark("bar, several cells"),
    tr_mark("strobe"),
    tr_mark("scanner"),
    tr_mark("laser"),
    tr_mark("haze, fog"),
    tr_mark("other"),
    // Buffers and images (render/memory_groups.cpp).
    tr_mark("tables of fixtures"),
    tr_mark("states of heads"),
    tr_mark("bodies and scenery"),
    tr_mark("gobos"),
    tr_mark("beams"),
    tr_mark("shadows"),
    tr_mark("reflected light"),
    tr_mark("reflection probes"),
    tr_mark("clouds of haze"),
    tr_mark("depth of field"),
    tr_mark("lasers"),
    tr_mark("mirror balls"),
    tr_mark("panes"),
    tr_mark("displays"),
    tr_mark("light and screen"),
    tr_mark("what a pixel shows"),
    tr_mark("beams by tile"),
    tr_mark("lasers by tile"),
    tr_mark("shadows by tile"),
    tr_mark("smooth edges"),
    tr_mark("glare"),
    tr_mark("mirrored light"),
    tr_mark("parameters and others"),
    tr_mark("mirrored picture, and of passes alone"),
    // What a pass is for (render/passes), and what a rig lacks without a need (fixtures/model/features.h).
    tr_mark("beams in the air"),
    tr_mark("bodies of fixtures and objects of the scene"),
    tr_mark("light that boxes and scenery reflect to others"),
    tr_mark("beams taken together for 64 x 64 pixels"),
    tr_mark("beams taken together for a tile that shows one plane, and what of a shadow is visible there"),
    tr_mark("displays, and their light in the air and on surfaces"),
    tr_mark("which box each pixel shows"),
    tr_mark("smooth edges of solid things"),
    tr_mark("beams taken together for 32 x 32 pixels"),
    tr_mark("beams of any kind"),
    tr_mark("depth of field: what is out of focus is blurred"),
    tr_mark("light that the camera's lens scatters"),
    tr_mark("what floors mirror"),
    tr_mark("what shiny floors, trusses and metals mirror"),
    tr_mark("what shiny surfaces mirror of the stage"),
    tr_mark("the file has no probe and no material that shines; no maps of what is mirrored"),
    tr_mark("tables of gobos in the air, which are sampled instead"),
    tr_mark("clouds of haze that drift, plumes of machines, and haze that thins with height"),
    tr_mark("scanned lasers"),
    tr_mark("the light of lenses of a few pixels"),
    tr_mark("spots of mirror balls"),
    tr_mark("beams with a rim or cuts taken together for 64 x 64 pixels"),
    tr_mark("shadows of beams taken together"),
    tr_mark("shadows of boxes and fixtures"),
    tr_mark("shadows in the haze"),
    tr_mark("shafts of sunlight behind panes, and the panes"),
    tr_mark("fixtures"),
    tr_mark("displays that are thin in the picture"),
    tr_mark("light on floor, walls and fixtures"),
    tr_mark("beams on surfaces and in haze"),
    tr_mark("anything to see"),
    tr_mark("nothing is patched; no decoding, no lamps"),
    tr_mark("no mode moves a motor; no axes are stepped"),
    tr_mark("no mode turns anything without end; no turns are counted"),
    tr_mark("no mode strobes; no shutter integral"),
    tr_mark("no motor is smoothed, rings or tracks; each is where its motor is"),
    tr_mark("no level is smoothed"),
    tr_mark("no dimmer moves; none is stepped"),
    tr_mark("no mode has a filter or a colour wheel; emitters and lamps alone"),
    tr_mark("no mode has a gobo, iris, frost, prism or blade; beams are round and whole"),
    tr_mark("no mode selects a gobo; no gobo images or tables"),
    tr_mark("no mode focuses; images and edges are sharp everywhere"),
    tr_mark("no mode has an animation wheel; none is looked at"),
    tr_mark("no mode shakes a gobo; none of its values is kept"),
    tr_mark("no mode has a second prism or frost; one of each at most"),
    tr_mark("no iris or frost pulses, no wheel goes to random slots; none of their values is kept"),
    tr_mark("no mode has macros or programs of colours; channels alone say them"),
    tr_mark("nothing is a laser; no scanned beams"),
    tr_mark("nothing reflects lamps; no spots of mirrors"),
    tr_mark("the sun shines through no glass; no shafts of light"),
    tr_mark("no LED wall, panel or strip; no light of pixels"),
    tr_mark("every floor is matt; nothing is mirrored"),
    tr_mark("every surface is matt; no highlights of beams"),
    tr_mark("no mode frames its beam; no edges are cut"),
    tr_mark("the air scatters nothing; no beams in the air"),
    tr_mark("haze is as dense everywhere; no table of its density"),
    tr_mark("no machine blows haze that is seen; none of its puffs is in a table of densities"),
    tr_mark("nothing makes haze or fog; the air stays as it is"),
    tr_mark("the air dims nothing over 100 m; no exponentials along the rays"),
    tr_mark("the rig has no box; no light on surfaces"),
    tr_mark("no mesh stands on the stage; none is drawn"),
    tr_mark("no beam has measured candela; none are looked up"),
    tr_mark("every beam is round"),
    tr_mark("every beam is the soft one (m = 1); no other beam profiles"),
    tr_mark("no mode has a lamp that glows; no filaments"),
    tr_mark("no mode has LEDs that take time; no drivers, no heat"),
    tr_mark("no mode strikes its lamp; arcs burn as they are"),
};

// With gaps.
constexpr const char* kForms[] = {
    // Of edits: RigEdit::text. A form comes before those that it would be taken for.
    tr_mark("add {} at {}"),
    tr_mark("add {} from {}"),
    tr_mark("patch {} at {}"),
    tr_mark("patch {} from {}"),
    tr_mark("unpatch {}"),
    tr_mark("rename the camera {} to {}"),
    tr_mark("rename {} to {} ..."),
    tr_mark("rename {} to {}"),
    tr_mark("number {} from {}"),
    tr_mark("set mode {} of {}"),
    tr_mark("set the haze to {} /m"),
    tr_mark("clone {} {} times"),
    tr_mark("delete the camera {}"),
    tr_mark("delete {}; dark without its pictures: {}"),
    tr_mark("delete {}"),
    tr_mark("turn {}"),
    tr_mark("move {} by {}, {}, {} m"),
    tr_mark("place {}"),
    tr_mark("rotate {} by {}, {}, {} degrees"),
    tr_mark("store the camera {}"),
    tr_mark("clone {}"),
    tr_mark("add {}"),
    // Messages, which standard error has in English, too.
    tr_mark("not armed: {}"),
    tr_mark("{}: armed: it sends the levels of the picture to no lamp, since it is made up"),
    tr_mark("{}: armed: it sends the levels of the picture to real lamps"),
    tr_mark("{}: armed: it sends zeros until End is held, then the levels of the picture to no lamp, since it is made "
            "up"),
    tr_mark("{}: armed: it sends zeros until End is held, then the levels of the picture to real lamps"),
    tr_mark("{}: disarmed: it ends with zeros"),
    tr_mark("the blackout of outputs has ended"),
    tr_mark("blackout of outputs: all that are armed send zeros"),
    tr_mark("blackout of outputs: the window gave no levels for 2.5 s; Shift+B ends it"),
    tr_mark("recorded {} s, {}: {}; {} lost, the disk was too slow"),
    tr_mark("recorded {} s, {}: {}; without the universes that an edit has added"),
    tr_mark("recorded {} s, {}: {}"),
    tr_mark("the recording ended: {}; what was written before stays readable"),
    tr_mark("{}; seeks begin at the start of the log"),
    tr_mark("{}: damaged at byte {}: {} of {} bytes left out, where levels stay as they were; 'footlight log info {}' "
            "lists them"),
    tr_mark("{}; its displays keep their last picture"),
    tr_mark("{}: {} so far cannot be decoded; the last whole one stays in their place. Export the video again"),
    tr_mark("nothing drives levels now; patch a fixture first"),
    tr_mark("{}: lost: {}"),
    tr_mark("{}: on standby again; {} is back"),
    tr_mark("{}: takes over for {}"),
    tr_mark("{}: blackout is on"),
    tr_mark("{}: blackout is off"),
    tr_mark("{}: a hold begins: when it ends, blackout is on"),
    tr_mark("{}: the hold is over"),
    tr_mark("{}: back"),
    tr_mark("{}: universe {} is not among those of this run; it stays unused"),
    tr_mark("{}: universes {} are not among those of this run; they stay unused"),
    tr_mark("{}: universe {} has {} senders already; frames of further ones are refused and counted"),
    tr_mark("{}: universe {}: a sender has priority {}; expected 0 to {}; its frames are ignored and counted"),
    // Errors of the window itself.
    tr_mark("a marker's name has 1 to {} bytes without control characters"),
    tr_mark("there is a marker here already: {}"),
    tr_mark("a marker is between 0 and {} s of the log"),
    tr_mark("a log has at most {} markers; delete some"),
    tr_mark("this rig cannot be edited"),
    tr_mark("no selected fixture can be turned to a point; select fixtures with a beam"),
    tr_mark("nothing to record: no fixture and no display of this rig has an address"),
    tr_mark("the recording before is still being written; try again when its end is reported"),
    tr_mark("{}: there is no such file"),
    tr_mark("{}: has no name before its ending; expected one such as show.toml"),
    tr_mark("{}: is a folder; choose another name"),
    tr_mark("{}: is a pipe or a device; choose another name"),
    tr_mark("{}: is no definition (GDTF, QXF, Open Fixture Library), no rig (MVR, TOML, QXW) and no log (.dmxlog)"),
    tr_mark("this window system does not let windows be read"),
    tr_mark("there are {} screenshots in this folder; move some of them"),
    tr_mark("{}: it is in the list already"),
    tr_mark("{}: disarm it before it gets another universe"),
    tr_mark("{}: the output was removed meanwhile; add it again"),
    tr_mark("{}: the rig did not use universe {} when its first output was added; start the window with --output {}"),
    tr_mark("--output {}: this is an input; use --in, or 'footlight run --in'"),
    tr_mark("--output {}: a window of its own is for 'footlight run --out {}'"),
    tr_mark("--output {}: named twice; expected it once"),
    tr_mark("--output {}: no fixture of this rig has an address, and the made-up ones of its faders are not sent; give "
            "the fixtures addresses (key F3, or 'footlight rig edit')"),
    tr_mark("--output {}: the fixtures of this rig have addresses in universe {}, and this output carries {}"),
    tr_mark("this rig has no fixture and no display with an address; remove the inputs, patch a fixture, or give a "
            "display a universe"),
    tr_mark("no fixture is selected; select at least one"),
    // Of slots and addresses.
    tr_mark("two breaks of {} share universe {}, address {}"),
    tr_mark("two breaks of {} share universe {}, addresses {} to {}"),
    tr_mark("{} and {} share universe {}, address {}"),
    tr_mark("{} and {} share universe {}, addresses {} to {}"),
    tr_mark("{}: column {}, row {}, {}"),
};

std::string counted_text(std::string_view one) {
  const std::size_t space = one.find(' ');
  const std::string_view digits = one.substr(0, space);
  const bool number = !digits.empty() && digits.find_first_not_of("0123456789") == std::string_view::npos;
  if (!number || space == std::string_view::npos) return std::string(one);
  const std::string_view noun = one.substr(space + 1);
  const unsigned long count = std::strtoul(std::string(digits).c_str(), nullptr, 10);
  if (noun == "fixture" || noun == "fixtures") return trf_n("{} fixture", "{} fixtures", count, count);
  if (noun == "change" || noun == "changes") return trf_n("{} change", "{} changes", count, count);
  if (noun == "frame" || noun == "frames") return trf_n("{} frame", "{} frames", count, count);
  if (noun == "picture" || noun == "pictures") return trf_n("{} picture", "{} pictures", count, count);
  if (noun == "part" || noun == "parts") return trf_n("{} part", "{} parts", count, count);
  return std::string(one);
}

// What the gaps of a form have in a text; false: the text has another form.
bool fits(std::string_view form, std::string_view text, std::vector<std::string>& gaps) {
  gaps.clear();
  std::size_t gap = form.find("{}");
  if (!text.starts_with(form.substr(0, gap))) return false;
  if (gap == std::string_view::npos) return text == form;
  text.remove_prefix(gap);
  while (gap != std::string_view::npos) {
    form.remove_prefix(gap + 2);
    gap = form.find("{}");
    const std::string_view after = form.substr(0, gap);
    std::size_t end =
        gap == std::string_view::npos ? text.size() - std::min(after.size(), text.size()) : text.find(after);
    if (end == std::string_view::npos || text.substr(end, after.size()) != after) return false;
    gaps.push_back(counted_text(text.substr(0, end)));
    text.remove_prefix(end + after.size());
  }
  return true;
}

}  // namespace

std::string tr_known(const std::string& english) {
  if (words_detail::current == nullptr) return english;
  std::vector<std::string> gaps;
  for (const char* form : kForms) {
    if (!fits(form, english, gaps)) continue;
    fmt::dynamic_format_arg_store<fmt::format_context> arguments;
    for (const std::string& gap : gaps) arguments.push_back(gap);
    return words_detail::format(form, tr(form), arguments);
  }
  return counted_text(english);
}

}  // namespace footlight::tools
