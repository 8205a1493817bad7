// Which passes a frame has, in order, for the needs of a rig and the settings: names, constants, shaders, memory.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "render/pass.h"
#include "render/resources.h"

namespace footlight::render {

// A pass as the rig and the settings make it.
struct PassPlan {
  std::string name;
  std::vector<vk::SpecConstant> constants;
  bool operator==(const PassPlan&) const = default;
};

// The passes of a frame, in order.
using PassList = std::vector<const PassEntry*>;
// Those of the product. The report replaces some of them by rivals (render/rivals/rivals.h).
[[nodiscard]] const PassList& product_passes();

[[nodiscard]] std::vector<PassPlan> plan_frame(const fixtures::Needs& needs, const FrameSettings& settings,
                                               const PassList& passes = product_passes());
// Names of the passes that the plan leaves out, with what the picture would gain from them.
struct LeftOutPass {
  std::string name;
  std::string loss;
};
[[nodiscard]] std::vector<LeftOutPass> left_out_passes(const fixtures::Needs& needs, const FrameSettings& settings);

// The shaders of all passes, needed or not: the stages of each pipeline.
struct PassShaders {
  std::string name;
  std::vector<std::vector<vk::Spirv>> pipelines;
};
[[nodiscard]] std::vector<PassShaders> pass_shaders();

// GPU memory of each pass that the plan has: the buffers and images of its shaders that no pass before it has. "frame"
// comes first with what every frame has. Without the meshes of bodies, whose length is known when they are read.
struct PassMemory {
  std::string name;
  std::uint64_t bytes = 0;
};
[[nodiscard]] std::vector<PassMemory> plan_memory(const MemoryShape& shape);

// The needs of a rig with these settings: without light in the air where settings.haze is false.
[[nodiscard]] fixtures::Needs drawn_needs(const fixtures::Needs& needs, const fixtures::Haze& haze,
                                          const FrameSettings& settings);

// What a frame has, whatever its passes are: commands and read-backs use them.
[[nodiscard]] std::span<const std::uint32_t> frame_bindings();
// The bindings of the frame that a pass reads and writes; not those that it makes for itself.
[[nodiscard]] std::vector<std::uint32_t> bindings_of(const PassEntry& pass);

}  // namespace footlight::render
