#pragma once

#include "render/rivals/rivals.h"

namespace footlight::render {

extern const Rival kClusters;        // any number of lights, nothing lost
extern const Rival kClustersLossy;   // 127 lights, and slabs that miss what fits between their faces
extern const Rival kClustersOwnLaw;  // and with the method's own law of light, in half floats
extern const PassEntry kClustersPass;
extern const PassEntry kClustersLossyPass;
extern const PassEntry kClustersOwnLawPass;

}  // namespace footlight::render
