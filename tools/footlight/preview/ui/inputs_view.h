// The inputs of the window as the panel of devices shows them, and what the user asks for. Plain data: the loop of the
// preview fills it in and carries it out (preview_inputs.cpp).
#pragma once

#include <optional>
#include <string>
#include <vector>

namespace footlight::tools {

struct InputsView {
  // What is.
  std::vector<std::string> inputs;   // endpoints
  std::vector<std::string> made_up;  // of them, those that are models of devices, and patterns
  std::string why_not;               // why none can be added now; empty: it can
  std::string refusal;               // why the last one that was to be added was not; empty: it was

  // What the user asks for; the loop carries it out and resets it.
  std::optional<std::string> add;  // "mock:chase", "sacn:1-9"
  std::optional<std::string> remove;
};

// "MADE UP: mock:chase", "MADE UP: 2 inputs"; empty: there is none.
[[nodiscard]] std::string made_up_words(const InputsView& view);

}  // namespace footlight::tools
