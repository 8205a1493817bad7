#include "render/rivals/equiangular.h"

#include "render/rivals/rival_pass.h"
#include "shaders/bounds.comp.h"
#include "shaders/equiangular.comp.h"

namespace footlight::render {
namespace {

template <bool kWholeRay, bool kJitter>
Result<std::unique_ptr<Pass>> create_equiangular(const PassContext& context) {
  auto pass = std::make_unique<RivalPass>(
      context, std::vector<vk::SpecConstant>{{FL_SPEC_WHOLE_RAY, kWholeRay}, {FL_SPEC_JITTER, kJitter}});
  FL_TRY(pass->add_bounds());
  FL_TRY(pass->add_compute(kEquiangularComp, tiles_of_beams(context)));
  return pass;
}

template <bool kWholeRay, bool kJitter>
PassEntry equiangular_entry() {
  return {"equiangular",
          has_air,
          rival_constants,
          create_equiangular<kWholeRay, kJitter>,
          [] {
            return std::vector<std::vector<vk::Spirv>>{{kBoundsComp}, {kEquiangularComp}};
          },
          "light in the haze"};
}

Rival equiangular_rival(const char* method, PassList (*passes)()) {
  return {method, {4, 8, 16, 32}, {8, 32}, "Kulla and Fajardo, EGSR 2012", false, true, false, passes, rival_settings};
}

}  // namespace

const PassEntry kEquiangularPass = equiangular_entry<false, true>();
const PassEntry kEquiangularMiddlesPass = equiangular_entry<false, false>();
const PassEntry kEquiangularWholePass = equiangular_entry<true, true>();

const Rival kEquiangular = equiangular_rival("equi-angular", [] { return passes_with_air({&kEquiangularPass}); });
const Rival kEquiangularMiddles =
    equiangular_rival("equi-angular middles", [] { return passes_with_air({&kEquiangularMiddlesPass}); });
const Rival kEquiangularWhole =
    equiangular_rival("equi-angular whole ray", [] { return passes_with_air({&kEquiangularWholePass}); });

}  // namespace footlight::render
