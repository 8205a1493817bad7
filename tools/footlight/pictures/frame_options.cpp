#include "tools/footlight/pictures/frame_options.h"

#include <optional>

#include "render/quality.h"
#include "tools/footlight/status/status_text.h"

namespace footlight::tools {

Result<std::uint32_t> parse_edges(const std::string& text) {
  if (text == "off") return 0u;
  if (text == "4") return 4u;
  if (text == "8") return 8u;
  if (text == "16") return 16u;
  return fail(ErrorCode::kBadInput, "--edges {}: expected off, 4, 8 or 16", printable_utf8(text));
}

Result<bool> parse_shadows(const std::string& text) {
  if (text == "on") return true;
  if (text == "off") return false;
  return fail(ErrorCode::kBadInput, "--shadows {}: expected on or off", printable_utf8(text));
}

Result<double> parse_glare(const std::string& text) {
  if (text == "off") return 0.0;
  const std::optional<double> share = render::share_of(text);
  if (share && *share >= 0 && *share <= 1) return *share;
  return fail(ErrorCode::kBadInput, "--glare {}: expected off or a share of the light up to 100%, as in 1%",
              printable_utf8(text));
}

}  // namespace footlight::tools
