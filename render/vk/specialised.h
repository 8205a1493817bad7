// A shader as one combination of specialisation constants leaves it: SPIR-V without the code that they switch off.
//
// lavapipe translates and optimises all of a shader before it looks at constants, for each pipeline and also where its
// machine code comes from the cache on disk. Shaders of the frame have code for everything that a rig may have, so most
// of that time goes into code that the constants switch off (docs/decisions/0164).
//
// Propagates constants of booleans and 32-bit integers along the branches that can be taken (Wegman and Zadeck 1991,
// "Constant Propagation with Conditional Branches"), and leaves out blocks that are never reached and values that
// nothing uses. Computes nothing with floats, so results are those of the whole shader to the bit.
//
// Any thread.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "render/vk/pipeline.h"
#include "render/vk/shader.h"

namespace footlight::render::vk {

// Has the same interface; debug names are gone, and so are all specialisation constants whose type is a boolean or has
// 32 bits. Constants without a value in `constants` have that of the shader. Empty: the module has a form that this
// does not know, and the shader is to be used as it is.
[[nodiscard]] std::vector<std::uint32_t> specialised(Spirv spirv, std::span<const SpecConstant> constants);

}  // namespace footlight::render::vk
