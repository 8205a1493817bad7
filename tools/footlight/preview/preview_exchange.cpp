// MVR-xchange in the preview: rigs from other stations, and the present one for them.
#include <filesystem>
#include <memory>
#include <utility>

#include "tools/footlight/preview/preview_window.h"

namespace footlight::tools {

// Once a turn: what the menu asks for, and what has come.
void Preview::follow_exchange() {
  const auto shared = [this]() -> ExchangeFollower::Rig {
    return {std::make_shared<const fixtures::ImportedRig>(edited_->file().imported()),
            std::filesystem::path(edited_->file().target()).stem().string() + ".mvr"};
  };
  for (MvrExchange::Event& event : exchange_.turn(last_ns_, exchange_view_, folder_for_rigs(), shared)) {
    const bool wrong = event.kind == MvrExchange::Event::Kind::kError;
    tell(std::move(event.text), wrong);
    if (event.kind == MvrExchange::Event::Kind::kReceived && !asked_next_) ask_to_open({std::move(event.path), ""});
  }
}

// Of the rig's file; for --demo the current one.
std::string Preview::folder_for_rigs() const {
  const std::string folder = std::filesystem::path(edited_->file().target()).parent_path().string();
  return folder.empty() ? "." : folder;
}

}  // namespace footlight::tools
