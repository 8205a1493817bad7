#include "render/vk/shader.h"

#include <algorithm>
#include <map>

#include "render/vk/spirv_words.h"

namespace footlight::render::vk {
namespace {

// Words of the SPIR-V specification 1.6, section 3.7 (storage classes).
enum Storage : std::uint32_t { kUniformConstant = 0, kUniform = 2, kPushConstant = 9, kStorageBuffer = 12 };
constexpr std::uint32_t kImageForStorage = 2;  // operand "Sampled" of OpTypeImage

struct Type {
  std::uint32_t op = 0;
  std::span<const std::uint32_t> operands;  // behind the result id
};

struct Variable {
  std::uint32_t id = 0;
  std::uint32_t pointer = 0;
  std::uint32_t storage = 0;
};

// What of a module says something about its interface.
struct Module {
  std::map<std::uint32_t, Type> types;
  std::map<std::uint32_t, std::uint32_t> bindings;  // by the variable's id
  std::map<std::uint32_t, std::uint32_t> sets;
  std::vector<Variable> variables;
};

Result<Module> read_module(Spirv spirv) {
  if (spirv.size() < kSpirvHeaderWords || spirv[0] != kSpirvMagic)
    return fail(ErrorCode::kBadInput, "a shader is no SPIR-V");
  Module module;
  for (std::size_t at = kSpirvHeaderWords; at < spirv.size();) {
    const std::uint32_t words = spirv[at] >> 16;
    const std::uint32_t op = spirv[at] & 0xffff;
    if (words == 0 || at + words > spirv.size()) {
      return fail(ErrorCode::kBadInput, "a shader's SPIR-V ends within instruction {} at word {}", op, at);
    }
    const auto operands = spirv.subspan(at + 1, words - 1);
    const bool is_type = op >= kOpTypeVoid && op <= kOpTypePointer;
    if (is_type && !operands.empty()) module.types[operands[0]] = {op, operands.subspan(1)};
    if (op == kOpVariable && operands.size() >= 3) module.variables.push_back({operands[1], operands[0], operands[2]});
    if (op == kOpDecorate && operands.size() >= 3 && operands[1] == kDecorationBinding) {
      module.bindings[operands[0]] = operands[2];
    }
    if (op == kOpDecorate && operands.size() >= 3 && operands[1] == kDecorationDescriptorSet) {
      module.sets[operands[0]] = operands[2];
    }
    at += words;
  }
  return module;
}

// The type that a pointer type points to.
const Type* pointee(const Module& module, std::uint32_t pointer) {
  const auto found = module.types.find(pointer);
  if (found == module.types.end() || found->second.op != kOpTypePointer || found->second.operands.size() < 2) {
    return nullptr;
  }
  const auto type = module.types.find(found->second.operands[1]);
  return type == module.types.end() ? nullptr : &type->second;
}

Result<VkDescriptorType> descriptor_of(const Variable& variable, const Type& type, std::uint32_t binding) {
  if (variable.storage == kStorageBuffer && type.op == kOpTypeStruct) return VK_DESCRIPTOR_TYPE_STORAGE_BUFFER;
  if (variable.storage == kUniform && type.op == kOpTypeStruct) return VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER;
  if (variable.storage == kUniformConstant && type.op == kOpTypeSampledImage) {
    return VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER;
  }
  const bool image = variable.storage == kUniformConstant && type.op == kOpTypeImage && type.operands.size() > 5;
  if (image && type.operands[5] == kImageForStorage) return VK_DESCRIPTOR_TYPE_STORAGE_IMAGE;
  return fail(ErrorCode::kUnsupported,
              "binding {} of a shader: expected a buffer, a storage image or a combined image sampler",
              binding);
}

Result<std::uint32_t> push_bytes_of(const Module& module, const Type& block) {
  for (const std::uint32_t member : block.operands) {
    const auto type = module.types.find(member);
    const bool scalar =
        type != module.types.end() && (type->second.op == kOpTypeInt || type->second.op == kOpTypeFloat);
    if (!scalar || type->second.operands.empty() || type->second.operands[0] != 32) {
      return fail(ErrorCode::kUnsupported, "push constants of a shader: expected 32-bit scalars only");
    }
  }
  return static_cast<std::uint32_t>(block.operands.size() * 4);
}

}  // namespace

Result<ShaderInterface> read_interface(Spirv spirv) {
  FL_ASSIGN(const Module module, read_module(spirv));
  ShaderInterface shader;
  for (const Variable& variable : module.variables) {
    const bool push = variable.storage == kPushConstant;
    const bool bound =
        variable.storage == kUniformConstant || variable.storage == kUniform || variable.storage == kStorageBuffer;
    if (!push && !bound) continue;
    const Type* type = pointee(module, variable.pointer);
    if (type == nullptr) return fail(ErrorCode::kBadInput, "variable {} of a shader has no type", variable.id);
    if (push) {
      FL_ASSIGN(shader.push_bytes, push_bytes_of(module, *type));
      continue;
    }
    const auto binding = module.bindings.find(variable.id);
    const auto set = module.sets.find(variable.id);
    if (binding == module.bindings.end() || set == module.sets.end() || set->second != 0) {
      return fail(ErrorCode::kUnsupported, "variable {} of a shader: expected a binding in descriptor set 0",
                  variable.id);
    }
    FL_ASSIGN(const VkDescriptorType descriptor, descriptor_of(variable, *type, binding->second));
    shader.bindings.push_back({binding->second, descriptor});
  }
  std::sort(shader.bindings.begin(), shader.bindings.end(),
            [](const ShaderBinding& a, const ShaderBinding& b) { return a.binding < b.binding; });
  // A table that a shader reads in two forms has one descriptor.
  shader.bindings.erase(std::unique(shader.bindings.begin(), shader.bindings.end(),
                                    [](const ShaderBinding& a, const ShaderBinding& b) {
                                      return a.binding == b.binding && a.type == b.type;
                                    }),
                        shader.bindings.end());
  return shader;
}

Result<ShaderInterface> read_interfaces(std::span<const Spirv> stages) {
  ShaderInterface all;
  for (const Spirv stage : stages) {
    FL_ASSIGN(const ShaderInterface one, read_interface(stage));
    all.push_bytes = std::max(all.push_bytes, one.push_bytes);
    for (const ShaderBinding& binding : one.bindings) {
      const auto at = std::lower_bound(all.bindings.begin(), all.bindings.end(), binding,
                                       [](const auto& a, const auto& b) { return a.binding < b.binding; });
      if (at == all.bindings.end() || at->binding != binding.binding) {
        all.bindings.insert(at, binding);
      } else if (at->type != binding.type) {
        return fail(ErrorCode::kUnsupported, "binding {} has two types in the stages of one pipeline", binding.binding);
      }
    }
  }
  return all;
}

std::uint32_t count_of(const ShaderInterface& shader, VkDescriptorType type) {
  return static_cast<std::uint32_t>(std::count_if(shader.bindings.begin(), shader.bindings.end(),
                                                  [&](const ShaderBinding& each) { return each.type == type; }));
}

}  // namespace footlight::render::vk
