#include "tools/footlight/preview/window_ui.h"

#include <cstring>
#include <type_traits>

#include <imgui/imgui.h>

namespace footlight::tools {
namespace {

void add(std::vector<std::byte>& to, const void* from, std::size_t size_bytes) {
  if (size_bytes == 0) return;
  const auto* bytes = static_cast<const std::byte*>(from);
  to.insert(to.end(), bytes, bytes + size_bytes);
}

// For types without padding.
template <class Value>
void add(std::vector<std::byte>& to, const Value& value) {
  static_assert(std::is_trivially_copyable_v<Value>);
  add(to, &value, sizeof(value));
}

}  // namespace

bool ShownUi::changes(const ImDrawData& data) {
  next_.clear();
  add(next_, data.DisplayPos);
  add(next_, data.DisplaySize);
  add(next_, data.FramebufferScale);
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    add(next_, list.VtxBuffer.Size);
    add(next_, list.IdxBuffer.Size);
    add(next_, list.CmdBuffer.Size);
    add(next_, list.VtxBuffer.Data, static_cast<std::size_t>(list.VtxBuffer.size_in_bytes()));
    add(next_, list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
    for (const ImDrawCmd& command : list.CmdBuffer) {
      add(next_, command.ClipRect);
      add(next_, command.TextureId);
      add(next_, command.VtxOffset);
      add(next_, command.IdxOffset);
      add(next_, command.ElemCount);
    }
  }
  const bool same = next_.size() == last_.size() && std::memcmp(next_.data(), last_.data(), next_.size()) == 0;
  next_.swap(last_);
  return !same;
}

}  // namespace footlight::tools
