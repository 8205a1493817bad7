#include "drivers/rdm/rdm_parameters.h"

#include <doctest/doctest.h>

#include <algorithm>
#include <random>

namespace footlight::drivers {
namespace {

std::string text_of(const Result<std::vector<RdmField>>& fields) {
  if (!fields) return fields.error().message;
  std::string text;
  for (const RdmField& field : *fields) {
    text += (text.empty() ? "" : "; ") + (field.name.empty() ? field.text : field.name + " " + field.text);
  }
  return text;
}

std::string text_of(RdmForm form, Octets data) { return text_of(rdm_fields(form, data, "X")); }

constexpr RdmForm kForms[] = {RdmForm::kNone,
                              RdmForm::kBytes,
                              RdmForm::kText,
                              RdmForm::kSwitch,
                              RdmForm::kU8,
                              RdmForm::kU16,
                              RdmForm::kU32,
                              RdmForm::kParameterList,
                              RdmForm::kUidList,
                              RdmForm::kDeviceInfo,
                              RdmForm::kPersonality,
                              RdmForm::kPersonalityDescription,
                              RdmForm::kParameterDescription,
                              RdmForm::kSlotInfo,
                              RdmForm::kSlotText,
                              RdmForm::kSlotLevels,
                              RdmForm::kSensorDefinition,
                              RdmForm::kSensorValue,
                              RdmForm::kLampState,
                              RdmForm::kPowerState};

}  // namespace

TEST_CASE("parameters are found by name in any case, with dashes, and by number") {
  CHECK(find_rdm_parameter("DMX_START_ADDRESS")->number == 0x00F0);
  CHECK(find_rdm_parameter("dmx-start-address")->number == 0x00F0);
  CHECK(find_rdm_parameter("0x00F0")->name == "DMX_START_ADDRESS");
  CHECK(find_rdm_parameter("0x8001") == nullptr);
  CHECK(find_rdm_parameter("DMX_START") == nullptr);
  CHECK(name_of_rdm_parameter(0x1000) == "IDENTIFY_DEVICE");
  CHECK(name_of_rdm_parameter(0x8001) == "0x8001");
  CHECK(rdm_parameter_number("0x8001") == 0x8001);
  CHECK_FALSE(rdm_parameter_number("0x18001").has_value());
  CHECK_FALSE(rdm_parameter_number("0x").has_value());
}

TEST_CASE("answers are converted to text") {
  CHECK(text_of(RdmForm::kDeviceInfo, {1, 0, 0, 7, 1, 2, 0, 1, 2, 3, 0, 16, 2, 3, 0, 17, 0, 0, 1}) ==
        "model 0x0007; category fixture, moving yoke; software 0x00010203; footprint 16; personality 2; "
        "personalities 3; start address 17; sub-devices 0; sensors 1");
  CHECK(text_of(RdmForm::kText, {'F', 'O', 'H', 0x1B, '[', '1', 'm', 0, 'x'}) == "FOH?[1m");
  CHECK(text_of(RdmForm::kSwitch, {1}) == "on");
  CHECK(text_of(RdmForm::kU32, {0, 1, 0, 0}) == "65536");
  CHECK(text_of(RdmForm::kParameterList, {0x00, 0xE0, 0x80, 0x01}) == "DMX_PERSONALITY; 0x8001");
  CHECK(text_of(RdmForm::kUidList, {2, 0xB0, 0, 0, 0, 1}) == "02B0:00000001");
  CHECK(text_of(RdmForm::kPersonalityDescription, {2, 0, 16, 'E', 'x', 't'}) ==
        "personality 2; footprint 16; name Ext");
  CHECK(text_of(RdmForm::kSlotInfo, {0, 0, 0, 0, 1, 0, 1, 1, 0, 0}) ==
        "slot 1 function 0x0001; slot 2 kind 0x01 of slot 1");
  CHECK(text_of(RdmForm::kSensorDefinition, {0, 0, 1, 1, 0xFF, 0x38, 4, 0xB0, 0, 0, 3, 0x20, 0, 'L'}) ==
        "sensor 0; kind temperature; lowest -20 degC; highest 120 degC; normal from 0 degC; normal to 80 degC; name L");
  CHECK(text_of(RdmForm::kSensorValue, {1, 0xFF, 0xFE, 0, 1, 0, 2, 0, 3}) ==
        "sensor 1; value -2; lowest 1; highest 2; recorded 3");
  CHECK(text_of(RdmForm::kBytes, {0, 0xAB}) == "00 AB");
}

TEST_CASE("an answer of a wrong length is refused, for every form with a length") {
  for (const auto& [form, wrong] :
       std::vector<std::pair<RdmForm, Octets>>{{RdmForm::kDeviceInfo, Octets(18)},
                                               {RdmForm::kDeviceInfo, Octets(20)},
                                               {RdmForm::kSwitch, {}},
                                               {RdmForm::kU16, Octets(3)},
                                               {RdmForm::kU32, Octets(2)},
                                               {RdmForm::kParameterList, Octets(3)},
                                               {RdmForm::kUidList, Octets(7)},
                                               {RdmForm::kSlotInfo, Octets(4)},
                                               {RdmForm::kSlotLevels, Octets(4)},
                                               {RdmForm::kSensorValue, Octets(8)},
                                               {RdmForm::kSensorDefinition, Octets(12)},
                                               {RdmForm::kParameterDescription, Octets(19)},
                                               {RdmForm::kPersonalityDescription, Octets(36)}}) {
    const auto fields = rdm_fields(form, wrong, "X");
    REQUIRE_FALSE(fields.has_value());
    CHECK(fields.error().code == ErrorCode::kProtocol);
  }
}

TEST_CASE("any octets in any form give printable text or an error") {
  std::mt19937 random(5);
  for (int i = 0; i < 5'000; ++i) {
    Octets data(random() % 60);
    for (auto& octet : data) octet = static_cast<std::uint8_t>(random());
    for (const RdmForm form : kForms) {
      const auto fields = rdm_fields(form, data, "X");
      if (!fields) continue;
      for (const RdmField& field : *fields) {
        const std::string all = field.text + field.name;
        REQUIRE(std::all_of(all.begin(), all.end(), [](char c) { return c >= 0x20 && c < 0x7F; }));
      }
    }
  }
}

TEST_CASE("typed values are parsed, and invalid ones are refused with the expected form") {
  CHECK(rdm_data(RdmForm::kU16, "17", "X").value() == Octets{0, 17});
  CHECK(rdm_data(RdmForm::kU16, "0x0111", "X").value() == Octets{1, 17});
  CHECK(rdm_data(RdmForm::kU32, "65536", "X").value() == Octets{0, 1, 0, 0});
  CHECK(rdm_data(RdmForm::kSwitch, "on", "X").value() == Octets{1});
  CHECK(rdm_data(RdmForm::kText, "FOH", "X").value() == Octets{'F', 'O', 'H'});
  CHECK(rdm_data(RdmForm::kText, "", "X").value().empty());
  CHECK(rdm_data(RdmForm::kNone, "", "X").value().empty());
  CHECK(rdm_data(RdmForm::kBytes, "00 1f", "X").value() == Octets{0, 0x1F});
  for (const auto& [form, text, words] : std::vector<std::tuple<RdmForm, std::string, std::string>>{
           {RdmForm::kU8, "256", "0 to 255"},
           {RdmForm::kU8, "", "0 to 255"},
           {RdmForm::kU16, "-1", "0 to 65535"},
           {RdmForm::kU16, "12 ", "0 to 65535"},
           {RdmForm::kSwitch, "maybe", "on or off"},
           {RdmForm::kText, std::string(33, 'x'), "at most 32"},
           {RdmForm::kText, "a\tb", "printable"},
           {RdmForm::kNone, "1", "no value"},
           {RdmForm::kBytes, "0", "hexadecimal"},
           {RdmForm::kBytes, "0g", "hexadecimal"},
           {RdmForm::kBytes, std::string(2 * 232, '0'), "231 octets"}}) {
    CAPTURE(text);
    const auto data = rdm_data(form, text, "X");
    REQUIRE_FALSE(data.has_value());
    CHECK(data.error().code == ErrorCode::kBadInput);
    CHECK(data.error().message.find(words) != std::string::npos);
  }
}

}  // namespace footlight::drivers
