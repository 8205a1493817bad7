// Photometric files in either format: valid ones are integrated, fitted and converted to tables.
#include <cmath>

#include "fixtures/photometry/fit.h"
#include "fixtures/photometry/photometry.h"
#include "fixtures/photometry/table.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using footlight::testing::require;

void footlight::testing::add_seeds(Seeds& seeds) {
  const std::string numbers = "1 -1 1 3 2 1 2 0 0 0\n1 1 5\n0 45 90\n0 90\n9 8 7\n6,5,4\n";
  seeds.add("c.ies", "IESNA:LM-63-2002\n[LAMP] 321 lm\nTILT=NONE\n" + numbers);
  seeds.add("tilt.ies", "IESNA91\nTILT=INCLUDE\n1\n2\n0 180\n1 1\n" + numbers);
  seeds.add("b.ies", "TILT=NONE\n1 100 1 3 2 2 1 0 0 0\n1 1 5\n-90 0 90\n0 90\n9 8 7\n6 5 4\n");
  seeds.add("a.ies", "TILT=NONE\n1 100 1 2 2 3 1 0 0 0\n1 1 5\n0 90\n-45 45\n9 8\n6 5\n");
  std::string ldt = "we\n1\n4\n4\n90\n2\n90\nr\nn\nn\nf\nd\n";
  for (int i = 0; i < 10; ++i) ldt += "0\n";
  ldt += "100\n1\n0\n1\n1\nlamp\n1000\n3000\n90\n10\n";
  for (int i = 0; i < 10; ++i) ldt += "0.5\n";
  seeds.add("s.ldt", ldt + "0\n90\n180\n270\n0\n90\n9\n8\n7\n6\n");
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view text(reinterpret_cast<const char*>(data), size);
  fixtures::Diagnostics diagnostics;
  const auto photometry = fixtures::parse_photometry(text, "fuzz", diagnostics);
  if (!photometry) {
    require(photometry.error().message.starts_with("fuzz"));
    return 0;
  }
  require(photometry->polar_deg.size() >= 2 && photometry->around_deg.size() >= 2);
  require(photometry->candela.size() == photometry->polar_deg.size() * photometry->around_deg.size());
  for (const double candela : photometry->candela) require(candela >= 0 && std::isfinite(candela));
  const double lm = integrated_lm(*photometry);
  require(std::isfinite(lm) && lm >= 0);
  require(std::isfinite(candela(*photometry, {0, 0, 1})));
  const fixtures::BeamFit fit = fixtures::fit_beam(*photometry);
  require(std::isfinite(fit.spread) && fit.spread > 0 && std::isfinite(fit.peak_cd) && std::isfinite(fit.shape_error));
  for (const fixtures::Side side : {fixtures::Side::kFront, fixtures::Side::kBack}) {
    const fixtures::MeasuredTable table = measured_table(*photometry, side);
    for (const float number : table.numbers) require(std::isfinite(number) && number >= 0);
    require(table.rings <= fixtures::kMeasuredRingsMax && table.columns <= fixtures::kMeasuredColumnsMax);
    require(std::isfinite(table.flux_lm) && std::isfinite(table.left_out_lm));
  }
  return 0;
}
