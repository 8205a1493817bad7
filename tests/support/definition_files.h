// Small definitions of fixtures as files, for tests of lists and of rigs that fixtures are added to.
#pragma once

#include <string>
#include <vector>

#include <fmt/format.h>

namespace footlight::testing {

// A QXF of a moving head: pan, tilt, dimmer and a wheel with two gobos. Each mode has so many of these channels.
struct QxfMode {
  std::string name;
  int channels = 4;
};
inline std::string qxf_head(const std::string& maker, const std::string& model, const std::vector<QxfMode>& modes) {
  static const std::vector<std::string> kNames{"Pan", "Tilt", "Dimmer", "Wheel"};
  std::string text =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n<!DOCTYPE FixtureDefinition>\n"
      "<FixtureDefinition xmlns=\"http://www.qlcplus.org/FixtureDefinition\">\n"
      "<Creator><Name>T</Name><Version>4.12.6</Version><Author>T</Author></Creator>\n<Manufacturer>" +
      maker + "</Manufacturer><Model>" + model +
      "</Model><Type>Moving Head</Type>\n<Channel Name=\"Pan\" Preset=\"PositionPan\"/>\n"
      "<Channel Name=\"Tilt\" Preset=\"PositionTilt\"/>\n<Channel Name=\"Dimmer\" Preset=\"IntensityMasterDimmer\"/>\n"
      "<Channel Name=\"Wheel\"><Group Byte=\"0\">Gobo</Group><Capability Min=\"0\" Max=\"99\">Open</Capability>"
      "<Capability Min=\"100\" Max=\"199\" Preset=\"GoboMacro\" Res1=\"Others/dots.png\">Dots</Capability>"
      "<Capability Min=\"200\" Max=\"255\" Preset=\"GoboMacro\" Res1=\"Others/bars.png\">Bars</Capability></Channel>\n";
  for (const QxfMode& mode : modes) {
    text += "<Mode Name=\"" + mode.name + "\">\n";
    for (int i = 0; i < mode.channels; ++i) {
      text += fmt::format("<Channel Number=\"{}\">{}</Channel>\n", i, kNames[static_cast<std::size_t>(i) % 4]);
    }
    text += "</Mode>\n";
  }
  return text +
         "<Physical><Bulb Type=\"LED\" Lumens=\"5000\" ColourTemperature=\"7000\"/>\n"
         "<Dimensions Weight=\"10\" Width=\"300\" Height=\"500\" Depth=\"200\"/>\n"
         "<Lens Name=\"Other\" DegreesMin=\"8\" DegreesMax=\"40\"/>\n"
         "<Focus Type=\"Head\" PanMax=\"400\" TiltMax=\"200\"/>\n"
         "<Technical PowerConsumption=\"150\" DmxConnector=\"5-pin\"/></Physical>\n</FixtureDefinition>\n";
}

inline constexpr const char* kOflPar =
    R"({"$schema": "https://x/open-fixture-library/master/schemas/fixture.json", "name": "Flat Par",
"categories": ["Color Changer"], "physical": {"bulb": {"type": "LED", "lumens": 900}},
"availableChannels": {"Dim": {"capability": {"type": "Intensity"}}},
"modes": [{"name": "one", "channels": ["Dim"]}]})";

}  // namespace footlight::testing
