// Replaces time_cvode.cpp in builds without SUNDIALS.
#include <limits>

#include "render/reference/time_report.h"
#include "render/reference/time_solvers.h"

namespace footlight::render {

bool has_cvode() { return false; }

struct FilamentCvode::Solver {};

FilamentCvode::FilamentCvode(const FilamentLaw&, double) {}

double FilamentCvode::step(double, double, double) { return std::numeric_limits<double>::quiet_NaN(); }

}  // namespace footlight::render
