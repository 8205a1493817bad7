#include "render/rivals/beam_card.h"

#include "render/rivals/rival_pass.h"
#include "shaders/addblended.comp.h"
#include "shaders/card.frag.h"
#include "shaders/card.vert.h"

namespace footlight::render {

const PassEntry kBeamCardPass{"beam card",
                              has_air,
                              rival_constants,
                              [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                                auto pass = std::make_unique<RivalPass>(context);
                                FL_TRY(pass->add_meshes(kCardVert, kCardFrag, 6));
                                return pass;
                              },
                              [] {
                                return std::vector<std::vector<vk::Spirv>>{{kCardVert, kCardFrag}, {kAddblendedComp}};
                              },
                              "light in the haze"};

const Rival kBeamCard{"beam card",   {1},   {1},  "DH Wang, a simple shaft of light, 2022",
                      false,         false, true, [] { return passes_with_air({&kBeamCardPass}); },
                      rival_settings};

}  // namespace footlight::render
