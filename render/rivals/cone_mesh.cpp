#include "render/rivals/cone_mesh.h"

#include "render/rivals/rival_pass.h"
#include "shaders/addblended.comp.h"
#include "shaders/cone.frag.h"
#include "shaders/cone.vert.h"

namespace footlight::render {

const PassEntry kConeMeshPass{"cone mesh",
                              has_air,
                              rival_constants,
                              [](const PassContext& context) -> Result<std::unique_ptr<Pass>> {
                                auto pass = std::make_unique<RivalPass>(context);
                                FL_TRY(pass->add_meshes(kConeVert, kConeFrag, FL_CONE_SIDES * 6));
                                return pass;
                              },
                              [] {
                                return std::vector<std::vector<vk::Spirv>>{{kConeVert, kConeFrag}, {kAddblendedComp}};
                              },
                              "light in the haze"};

const Rival kConeMesh{"cone mesh",   {1},   {1},  "VR Stage Lighting, standard mover",
                      false,         false, true, [] { return passes_with_air({&kConeMeshPass}); },
                      rival_settings};

}  // namespace footlight::render
