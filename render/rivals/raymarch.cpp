#include "render/rivals/raymarch.h"

#include "render/rivals/rival_pass.h"
#include "shaders/bounds.comp.h"
#include "shaders/raymarch.comp.h"

namespace footlight::render {

const PassEntry kRaymarchPass{
    "raymarch",
    has_air,
    rival_constants,
    [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
      auto pass = std::make_unique<RivalPass>(context, std::vector<vk::SpecConstant>{{FL_SPEC_WHOLE_RAY, 1}});
      FL_TRY(pass->add_bounds());
      FL_TRY(pass->add_compute(kRaymarchComp, tiles_of_beams(context)));
      return pass;
    },
    [] {
      return std::vector<std::vector<vk::Spirv>>{{kBoundsComp}, {kRaymarchComp}};
    },
    "light in the haze"};

const Rival kRaymarch{"march whole ray",
                      {16, 32, 64, 256},
                      {16, 64, 256},
                      "ray marching with equal steps from the eye to the surface",
                      false,
                      true,
                      false,
                      [] { return passes_with_air({&kRaymarchPass}); },
                      rival_settings};

}  // namespace footlight::render
