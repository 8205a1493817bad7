// The bins of the meter: luminances from 2^FL_METER_LOW, each octave cut into equal parts. They are the leading bits of
// a float, so light that is 2^k times as bright lies exactly k octaves higher. After frame.glsl.
#include "fixtures/shared/color.h"

layout(set = 0, binding = FL_BINDING_METER, std430) buffer MeterBuffer { MeterRow meter; };

const float kMeterLow = exp2(float(FL_METER_LOW));
const uint kMeterShift = 23u - uint(FL_METER_STEPS_LOG2);
const uint kMeterFirst = uint(127 + FL_METER_LOW) << uint(FL_METER_STEPS_LOG2);

uint meter_bin(float luminance) {
  return min((floatBitsToUint(luminance) >> kMeterShift) - kMeterFirst, uint(FL_METER_BINS) - 1u);
}
// share: of the bin, from its lower end, below 1.
float meter_luminance(uint bin, float share) {
  uint part = uint(share * float(1u << kMeterShift));
  return uintBitsToFloat(((bin + kMeterFirst) << kMeterShift) + min(part, (1u << kMeterShift) - 1u));
}
