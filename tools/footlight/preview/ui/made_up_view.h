// Made-up inputs as the panel of devices shows them, and what the user asks for. Plain data: the loop of the preview
// fills it in and carries it out (preview_made_up.cpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace footlight::tools {

struct MadeUpView {
  // What is.
  std::vector<std::string> inputs;  // endpoints that are on: models of devices, and patterns
  std::string why_not;              // why none can be added now; empty: it can

  // What the user asks for; the loop carries it out and resets it.
  std::optional<std::string> add;  // "mock:chase"
  std::optional<std::string> remove;
};

// "MADE UP: mock:chase", "MADE UP: 2 inputs"; empty: there is none.
[[nodiscard]] std::string made_up_words(const MadeUpView& view);

}  // namespace footlight::tools
