// What a raw value of a channel means: its function, the named range, and the value in real units.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "fixtures/model/fixture_type.h"

namespace footlight::tools {

struct ChannelReading {
  const fixtures::ChannelFunction* function = nullptr;  // nullptr: no function has this value
  const fixtures::ChannelSet* set = nullptr;            // nullptr: no named range
  double value = 0;                                     // in the units of fixture_type.h; of a wheel its slot, from 1
};

// raw_of: the raw values of the mode's other channels, which decide between functions.
[[nodiscard]] ChannelReading reading_of(const fixtures::FixtureType& type, const fixtures::Channel& channel,
                                        std::uint32_t raw, const std::function<std::uint32_t(int)>& raw_of);

// "-32.5°", "50 %", "5600 K", "12.0 Hz", "3: Star"; the name of the function where the value alone says nothing.
[[nodiscard]] std::string text_of(const ChannelReading& reading);

// What a channel controls, for people: its name, else the attribute of its first function.
[[nodiscard]] std::string name_of(const fixtures::Channel& channel);

}  // namespace footlight::tools
