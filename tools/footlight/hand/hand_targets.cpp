#include "tools/footlight/hand/hand_targets.h"

#include "fixtures/simulate/hand_fixtures.h"
#include "tools/footlight/hand/hand_text.h"

namespace footlight::tools {

Status add_assignment(const std::string& text, const RigOf& rig, std::vector<HandLevel>& into) {
  const std::size_t equals = text.rfind('=');
  const std::size_t colon = equals == std::string::npos ? std::string::npos : text.rfind(':', equals);
  if (colon == std::string::npos) {
    if (names_slots(text)) return parse_slot_assignment(text, into);
    return fail(ErrorCode::kBadInput,
                "{}: expected UNIVERSE.ADDRESS=LEVEL or FIXTURE:ATTRIBUTE=VALUE, for example 1.17=255 or 'Mover "
                "3:Tilt=30'",
                text);
  }
  const auto number = parse_hand_number(std::string_view(text).substr(equals + 1));
  if (!number) return fail(ErrorCode::kBadInput, "{}: {}", text, number.error().message);
  FL_ASSIGN(const fixtures::Rig* used, rig(text));
  FL_ASSIGN(const auto levels,
            fixtures::levels_of_attribute(*used, text.substr(0, colon), text.substr(colon + 1, equals - colon - 1),
                                          {number->number, number->percent}));
  into.insert(into.end(), levels.begin(), levels.end());
  return {};
}

Status add_target(const std::string& text, const RigOf& rig, std::vector<HandLevel>& into) {
  if (names_slots(text)) return parse_slots(text, into);
  FL_ASSIGN(const fixtures::Rig* used, rig(text));
  const std::size_t colon = text.rfind(':');
  auto levels = colon == std::string::npos
                    ? fixtures::slots_of_fixtures(*used, text)
                    : fixtures::levels_of_attribute(*used, text.substr(0, colon), text.substr(colon + 1), {0, false});
  if (!levels) return tl::unexpected(std::move(levels).error());
  for (HandLevel& level : *levels) {
    level.value = 0;
    into.push_back(level);
  }
  return {};
}

}  // namespace footlight::tools
