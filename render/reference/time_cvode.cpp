#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>

#include <algorithm>
#include <limits>

#include "render/reference/time_report.h"
#include "render/reference/time_solvers.h"

namespace footlight::render {

bool has_cvode() { return true; }

struct FilamentCvode::Solver {
  FilamentLaw law;
  double v = 0;
  SUNContext context = nullptr;
  N_Vector y = nullptr;
  SUNMatrix matrix = nullptr;
  SUNLinearSolver linear = nullptr;
  void* cvode = nullptr;

  Solver() = default;
  Solver(const Solver&) = delete;
  Solver& operator=(const Solver&) = delete;
  ~Solver() {
    CVodeFree(&cvode);
    SUNLinSolFree(linear);
    SUNMatDestroy(matrix);
    N_VDestroy(y);
    SUNContext_Free(&context);
  }

  [[nodiscard]] double kept(double at) const { return std::max(at, 0.3 * law.ambient); }
  static int slope(realtype, N_Vector y, N_Vector out, void* self) {
    const auto& s = *static_cast<const Solver*>(self);
    NV_Ith_S(out, 0) = s.law.slope(s.kept(NV_Ith_S(y, 0)), s.v);
    return 0;
  }
  static int slope_by_y(realtype, N_Vector y, N_Vector, SUNMatrix out, void* self, N_Vector, N_Vector, N_Vector) {
    const auto& s = *static_cast<const Solver*>(self);
    SM_ELEMENT_D(out, 0, 0) = s.law.slope_by_y(s.kept(NV_Ith_S(y, 0)), s.v);
    return 0;
  }
};

FilamentCvode::FilamentCvode(const FilamentLaw& law, double tolerance) : solver_(std::make_shared<Solver>()) {
  constexpr long kStepsMax = 100'000;
  Solver& s = *solver_;
  s.law = law;
  SUNContext_Create(nullptr, &s.context);
  s.y = N_VNew_Serial(1, s.context);
  NV_Ith_S(s.y, 0) = law.ambient;
  s.matrix = SUNDenseMatrix(1, 1, s.context);
  s.linear = SUNLinSol_Dense(s.y, s.matrix, s.context);
  s.cvode = CVodeCreate(CV_BDF, s.context);
  CVodeInit(s.cvode, Solver::slope, 0, s.y);
  CVodeSetUserData(s.cvode, &s);
  CVodeSStolerances(s.cvode, tolerance, tolerance * 1e-2);
  CVodeSetLinearSolver(s.cvode, s.linear, s.matrix);
  CVodeSetJacFn(s.cvode, Solver::slope_by_y);
  CVodeSetMaxNumSteps(s.cvode, kStepsMax);
}

double FilamentCvode::step(double y, double v, double dt_s) {
  Solver& s = *solver_;
  s.v = v;
  NV_Ith_S(s.y, 0) = y;
  realtype reached_s = 0;
  const bool done = CVodeReInit(s.cvode, 0, s.y) == CV_SUCCESS && CVodeSetStopTime(s.cvode, dt_s) == CV_SUCCESS &&
                    CVode(s.cvode, dt_s, s.y, &reached_s, CV_NORMAL) >= 0;
  return done ? NV_Ith_S(s.y, 0) : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace footlight::render
