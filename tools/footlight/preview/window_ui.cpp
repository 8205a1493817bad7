#include "tools/footlight/preview/window_ui.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <type_traits>
#include <utility>

#include <imgui/imgui.h>

namespace footlight::tools {
namespace {

constexpr float kStillUnits = 0.25f;

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
  std::vector<std::byte>& exact = next_.exact;
  exact.clear();
  next_.places.clear();
  add(exact, data.DisplayPos);
  add(exact, data.DisplaySize);
  add(exact, data.FramebufferScale);
  for (int i = 0; i < data.CmdListsCount; ++i) {
    const ImDrawList& list = *data.CmdLists[i];
    add(exact, list.VtxBuffer.Size);
    add(exact, list.IdxBuffer.Size);
    add(exact, list.CmdBuffer.Size);
    add(exact, list.IdxBuffer.Data, static_cast<std::size_t>(list.IdxBuffer.size_in_bytes()));
    for (const ImDrawVert& vertex : list.VtxBuffer) {
      add(exact, vertex.uv);
      add(exact, vertex.col);
      next_.places.push_back(vertex.pos.x);
      next_.places.push_back(vertex.pos.y);
    }
    for (const ImDrawCmd& command : list.CmdBuffer) {
      add(exact, command.ClipRect);
      add(exact, command.TextureId);
      add(exact, command.VtxOffset);
      add(exact, command.IdxOffset);
      add(exact, command.ElemCount);
    }
  }
  const bool same = exact == shown_.exact &&
                    std::equal(next_.places.begin(), next_.places.end(), shown_.places.begin(), shown_.places.end(),
                               [](float now, float shown) { return std::abs(now - shown) < kStillUnits; });
  if (!same) std::swap(next_, shown_);
  return !same;
}

}  // namespace footlight::tools
