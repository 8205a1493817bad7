// Nodes of a beam's light in the haze. A flat profile 1 - rho^(2m) is a polynomial of degree 2m in s: m = 3 and 4 need
// one and two nodes more than kNodes. So do the soft ones, of degree 2/m.
uint air_nodes(float profile_power) {
  uint nodes = kNodes;
  if (kProfile) {
    float degree = max(profile_power, 1.0 / profile_power);
    nodes = min(nodes + (degree > 2.5 ? 1u : 0u) + (degree > 3.5 ? 1u : 0u), 8u);
  }
  return nodes;
}
