// SPIR-V without the code that constants switch off.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <initializer_list>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include "render/plan.h"
#include "render/vk/specialised.h"
#include "render/vk/spirv_words.h"
#include "tests/support/must.h"
#include "tests/support/temp_folder.h"

namespace footlight::render::vk {
namespace {

using footlight::testing::must;
using footlight::testing::TempFolder;
using Words = std::vector<std::uint32_t>;

void add(Words& words, std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
  words.push_back(static_cast<std::uint32_t>(operands.size() + 1) << 16 | op);
  words.insert(words.end(), operands);
}

constexpr std::uint32_t kOpReturn = 253;

// Types 1: void, 2: its function, 3: bool, 4: uint, 5: pointer to a private uint. 6: a variable of that. 7: a constant
// with SpecId 9, false. 8: 100, 9: 200, 10: a boolean that is not constant. Ids of the function: from 20 on.
Words module_begins() {
  Words words = {kSpirvMagic, 0x00010600, 0, 40, 0};
  add(words, 17, {1});                        // OpCapability Shader
  add(words, 14, {0, 1});                     // OpMemoryModel Logical GLSL450
  add(words, 15, {5, 20, 0x6e69616d, 0, 6});  // OpEntryPoint GLCompute "main"
  add(words, 16, {20, 17, 1, 1, 1});          // OpExecutionMode LocalSize
  add(words, kOpName, {7, 0x00006161});
  add(words, kOpDecorate, {7, kDecorationSpecId, 9});
  add(words, kOpDecorate, {30, 0});  // RelaxedPrecision
  add(words, kOpTypeVoid, {1});
  add(words, 33, {2, 1});  // OpTypeFunction
  add(words, kOpTypeBool, {3});
  add(words, kOpTypeInt, {4, 32, 0});
  add(words, kOpTypePointer, {5, 6, 4});
  add(words, kOpVariable, {5, 6, 6});
  add(words, kOpSpecConstantFalse, {3, 7});
  add(words, kOpConstant, {4, 8, 100});
  add(words, kOpConstant, {4, 9, 200});
  add(words, kOpFunction, {1, 20, 0, 2});
  add(words, kOpLabel, {21});
  return words;
}
void module_ends(Words& words) {
  add(words, kOpReturn, {});
  add(words, 56, {});  // OpFunctionEnd
}

// Stores 100 where the constant is true, else 200.
Words module_with_branch() {
  Words words = module_begins();
  add(words, kOpSelectionMerge, {24, 0});
  add(words, kOpBranchConditional, {7, 22, 23});
  add(words, kOpLabel, {22});
  add(words, kOpBranch, {24});
  add(words, kOpLabel, {23});
  add(words, kOpLoad, {4, 30, 6});
  add(words, kOpStore, {6, 30});
  add(words, kOpBranch, {24});
  add(words, kOpLabel, {24});
  add(words, kOpPhi, {4, 31, 8, 22, 9, 23});
  add(words, kOpIAdd, {4, 32, 31, 8});
  add(words, kOpStore, {6, 32});
  module_ends(words);
  return words;
}

// Each instruction: its number, then its operands.
std::vector<Words> instructions(const Words& words) {
  std::vector<Words> all;
  for (std::size_t at = kSpirvHeaderWords; at < words.size(); at += words[at] >> 16) {
    const auto first = words.begin() + static_cast<std::ptrdiff_t>(at);
    all.emplace_back(first, first + (words[at] >> 16));
    all.back().front() &= 0xffff;
  }
  return all;
}
bool has(const Words& words, std::uint32_t op, std::initializer_list<std::uint32_t> operands) {
  Words wanted = {op};
  wanted.insert(wanted.end(), operands);
  const auto all = instructions(words);
  return std::find(all.begin(), all.end(), wanted) != all.end();
}
bool has_any(const Words& words, std::uint32_t op) {
  const auto all = instructions(words);
  return std::any_of(all.begin(), all.end(), [&](const Words& each) { return each.front() == op; });
}

TEST_CASE("of a branch by a constant the way that is taken is left, and what follows from it is a constant") {
  const Words module = module_with_branch();
  const Words yes = specialised(module, std::vector<SpecConstant>{{9, 1}});
  CHECK(has(yes, kOpConstant, {4, 32, 200}));
  CHECK(has(yes, kOpBranch, {22}));
  CHECK(!has(yes, kOpLabel, {23}));
  CHECK(!has_any(yes, kOpLoad));
  CHECK(!has_any(yes, kOpDecorate));  // neither the constant's nor that of a value that is gone
  const Words no = specialised(module, std::vector<SpecConstant>{{9, 0}});
  CHECK(has(no, kOpConstant, {4, 32, 300}));
  CHECK(has(no, kOpLoad, {4, 30, 6}));
  CHECK(has(no, kOpDecorate, {30, 0}));
  CHECK(!has(no, kOpLabel, {22}));
  for (const Words& each : {yes, no}) {
    CHECK(!has_any(each, kOpSpecConstantFalse));
    CHECK(!has_any(each, kOpSelectionMerge));
    CHECK(!has_any(each, kOpPhi));
    CHECK(!has_any(each, kOpName));
  }
}

TEST_CASE("a constant without a value keeps that of the shader") {
  CHECK(specialised(module_with_branch(), {}) == specialised(module_with_branch(), std::vector<SpecConstant>{{9, 0}}));
}

TEST_CASE("a loop that a constant keeps from coming back becomes a switch of one case") {
  Words words = module_begins();
  add(words, kOpBranch, {22});
  add(words, kOpLabel, {22});
  add(words, kOpLoopMerge, {25, 24, 0});
  add(words, kOpBranch, {26});
  add(words, kOpLabel, {26});
  add(words, kOpBranchConditional, {7, 23, 25});
  add(words, kOpLabel, {23});
  add(words, kOpBranch, {24});
  add(words, kOpLabel, {24});
  add(words, kOpBranch, {22});
  add(words, kOpLabel, {25});
  module_ends(words);
  const Words ended = specialised(words, {});
  CHECK(!has_any(ended, kOpLoopMerge));
  CHECK(has(ended, kOpSelectionMerge, {25, 0}));
  CHECK(has(ended, kOpConstant, {4, 40, 0}));
  CHECK(has(ended, kOpSwitch, {40, 26}));
  CHECK(has(ended, kOpBranch, {25}));
  CHECK(!has(ended, kOpLabel, {24}));
  const Words goes_on = specialised(words, std::vector<SpecConstant>{{9, 1}});
  CHECK(has(goes_on, kOpLoopMerge, {25, 24, 0}));
  CHECK(has(goes_on, kOpLabel, {24}));
}

TEST_CASE("words that are no SPIR-V are left as they are") {
  CHECK(specialised({}, {}).empty());
  CHECK(specialised(Words{1, 2, 3, 4, 5, 6}, {}).empty());
  Words cut = module_with_branch();
  cut.pop_back();
  cut.back() = 56 | 9u << 16;  // longer than what is left
  CHECK(specialised(cut, {}).empty());
}

// Of a rig without anything special, of the demo's needs and of all needs at once.
std::vector<fixtures::Needs> several_needs() {
  fixtures::Needs few;
  few.fixtures = true;
  few.haze = true;
  fixtures::Needs some = few;
  some.gobo = some.surfaces = some.profile = some.focus = some.iris = true;
  some.beams_max = 200;
  fixtures::Needs all = some;
  all.blades = all.animation = all.measured = all.rectangle = all.wide = all.extinction = true;
  all.motion = all.strobe = all.machines = all.spin = all.color = all.optics = all.dowser = true;
  all.flex = all.smooth = all.stacked = all.shake = all.pulses = all.macro = true;
  all.haze_field = all.laser = all.panes = all.displays = all.gloss = all.sheen = all.mirrors = all.objects = true;
  all.probes = true;
  return {few, some, all};
}

TEST_CASE("all shaders of the frame can be specialised, with the same interface and none of their constants") {
  const TempFolder folder;
  const std::string path = folder.file("shader.spv");
  const bool can_validate = std::system("spirv-val --version >/dev/null 2>&1") == 0;
  for (const fixtures::Needs& needs : several_needs()) {
    const std::vector<PassPlan> plan = plan_frame(needs, {}, product_passes());
    for (const PassShaders& pass : pass_shaders()) {
      const auto planned =
          std::find_if(plan.begin(), plan.end(), [&](const PassPlan& each) { return each.name == pass.name; });
      if (planned == plan.end()) continue;
      for (const std::vector<Spirv>& stages : pass.pipelines) {
        if (stages.size() > 1) continue;  // drawn triangles; they are small and have no constants
        INFO(pass.name);
        const Words less = specialised(stages[0], planned->constants);
        REQUIRE(!less.empty());
        CHECK(less.size() < stages[0].size());
        CHECK(!has_any(less, kOpSpecConstant));
        CHECK(!has_any(less, kOpSpecConstantTrue));
        const ShaderInterface before = must(read_interface(stages[0]));
        const ShaderInterface after = must(read_interface(less));
        CHECK(before.bindings == after.bindings);
        CHECK(before.push_bytes == after.push_bytes);
        if (!can_validate) continue;
        std::ofstream(path, std::ios::binary)
            .write(reinterpret_cast<const char*>(less.data()), static_cast<std::streamsize>(less.size() * 4));
        CHECK(std::system(("spirv-val --target-env vulkan1.3 " + path).c_str()) == 0);
      }
    }
  }
}

TEST_CASE("of the light of beams without gobos, shadows and haze that is uneven less than half is left") {
  fixtures::Needs needs;
  needs.fixtures = needs.haze = needs.surfaces = true;
  const std::vector<PassPlan> plan = plan_frame(needs, {}, product_passes());
  for (const PassShaders& pass : pass_shaders()) {
    if (pass.name != "surfaces") continue;
    const auto planned =
        std::find_if(plan.begin(), plan.end(), [](const PassPlan& each) { return each.name == "surfaces"; });
    REQUIRE(planned != plan.end());
    const Spirv whole = pass.pipelines.at(0).at(0);
    CHECK(specialised(whole, planned->constants).size() * 2 < whole.size());
  }
}

}  // namespace
}  // namespace footlight::render::vk
