// The number type of the judges.
#pragma once

namespace footlight::render {

using Wide = long double;

}  // namespace footlight::render
