#include "render/rivals/rivals.h"

#include <algorithm>

#include "render/passes/beams.h"
#include "render/passes/coarse.h"
#include "render/passes/depths.h"
#include "render/passes/fine.h"
#include "render/passes/haze.h"
#include "render/passes/records.h"
#include "render/passes/shade.h"
#include "render/passes/shadowtiles.h"
#include "render/passes/surfaces.h"
#include "render/rivals/beam_card.h"
#include "render/rivals/clusters.h"
#include "render/rivals/cone_mesh.h"
#include "render/rivals/equiangular.h"
#include "render/rivals/froxels.h"
#include "render/rivals/raymarch.h"
#include "render/rivals/shadow_maps.h"
#include "render/rivals/shaft_march.h"

namespace footlight::render {

const std::vector<Rival>& rivals() {
  static const std::vector<Rival> kRivals{
      kRaymarch,     // equal steps along the whole ray
      kEquiangular,  // samples by the angle at the light, in the beam, random in their strata
      kEquiangularMiddles,
      kEquiangularWhole,
      kFroxels,  // a grid of the picture and its depth
      kFroxelsSampled,
      kShadowMapsSmall,  // equal steps in the beam, each in a map of what hides light
      kShadowMaps,
      kConeMesh,  // a wall of light, rasterised
      kBeamCard,  // a flat fan that faces the camera, rasterised
      kClusters,  // light on surfaces: bits of lights along X, Y and Z
      kClustersLossy,
      kClustersOwnLaw,
      kShaftMarch,  // equal steps through the box of a shaft of sunlight
  };
  return kRivals;
}

PassList passes_with_air(const PassList& air) {
  const PassEntry* const own[] = {&kDepthsPass,  &kShadowtilesPass, &kHazePass,  &kCoarsePass,
                                  &kRecordsPass, &kFinePass,        &kShadePass, &kBeamsPass};
  PassList list;
  for (const PassEntry* pass : product_passes()) {
    if (pass == &kBeamsPass) list.insert(list.end(), air.begin(), air.end());
    if (std::find(std::begin(own), std::end(own), pass) == std::end(own)) list.push_back(pass);
  }
  return list;
}

PassList passes_with_surfaces(const PassEntry* surfaces) {
  PassList list = product_passes();
  std::replace(list.begin(), list.end(), &kSurfacesPass, surfaces);
  return list;
}

}  // namespace footlight::render
