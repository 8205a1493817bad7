// Dimmer laws: from the level of the channel (coarse and fine combined) to the share of light. A fixture has one law,
// used for its beam, floor, lens and output alike.
//
// All laws are monotone, and exactly 0 at 0 and 1 at 1; NaN gives 0.

FL_CONST uint kLawLinear = uint(0);
FL_CONST uint kLawSquare = uint(1);         // level^2: finer at the bottom
FL_CONST uint kLawS = uint(2);              // 3 level^2 - 2 level^3: finer at both ends
FL_CONST uint kLawInverseSquare = uint(3);  // level^(1/2), undoes the square: finer at the top
FL_CONST uint kLawTable = uint(4);
FL_CONST uint kLawCount = uint(5);
FL_CONST uint kLawTableCount = uint(17);

// Light at level i / 16, linear in between. Monotone if its values are.
struct LawTable {
  Real light[17];
};

FL_FN Real law_table(LawTable table, Real level) {
  if (!(level > Real(0))) return table.light[0];
  if (level >= Real(1)) return table.light[16];
  Real place = level * Real(16);
  uint i = uint(place);
  Real low = table.light[i];
  Real high = table.light[i + uint(1)];
  return clamp(low + (high - low) * (place - Real(i)), min(low, high), max(low, high));
}

// All laws except kLawTable, which needs its table; an unknown law is linear.
FL_FN Real law_light(uint law, Real level) {
  if (!(level > Real(0))) return Real(0);
  if (level >= Real(1)) return Real(1);
  if (law == kLawSquare) return level * level;
  if (law == kLawS)
    return level < Real(0.5) ? level * level * (Real(3) - Real(2) * level)
                             : Real(1) - (Real(1) - level) * (Real(1) - level) * (Real(1) + Real(2) * level);
  if (law == kLawInverseSquare) return sqrt(level);
  return level;
}
