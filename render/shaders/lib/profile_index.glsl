// Profiles by number: m = 1/4, 1/3, 1/2, 1, 2, 3, 4.
uint profile_index(float profile_power) {
  return profile_power > 3.5    ? 6u
         : profile_power > 2.5  ? 5u
         : profile_power > 1.5  ? 4u
         : profile_power > 0.75 ? 3u
         : profile_power > 0.42 ? 2u
         : profile_power > 0.29 ? 1u
                                : 0u;
}
float profile_of_index(uint index) { return index > 2u ? float(index) - 2.0 : 1.0 / (4.0 - float(index)); }
