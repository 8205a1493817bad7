// The parameters of Remote Device Management that users see: their names, and their values as text, in both directions.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/rdm/rdm_packet.h"
#include "sim/core/result.h"

namespace footlight::drivers {

inline constexpr std::uint16_t kRdmSupportedParameters = 0x0050;
inline constexpr std::uint16_t kRdmParameterDescription = 0x0051;
inline constexpr std::uint16_t kRdmDeviceInfo = 0x0060;
inline constexpr std::uint16_t kRdmDeviceModelDescription = 0x0080;
inline constexpr std::uint16_t kRdmManufacturerLabel = 0x0081;
inline constexpr std::uint16_t kRdmDeviceLabel = 0x0082;
inline constexpr std::uint16_t kRdmSoftwareVersionLabel = 0x00C0;
inline constexpr std::uint16_t kRdmDmxPersonality = 0x00E0;
inline constexpr std::uint16_t kRdmDmxPersonalityDescription = 0x00E1;
inline constexpr std::uint16_t kRdmDmxStartAddress = 0x00F0;
inline constexpr std::uint16_t kRdmSlotInfo = 0x0120;
inline constexpr std::uint16_t kRdmSlotDescription = 0x0121;
inline constexpr std::uint16_t kRdmSensorDefinition = 0x0200;
inline constexpr std::uint16_t kRdmSensorValue = 0x0201;
inline constexpr std::uint16_t kRdmIdentifyDevice = 0x1000;
inline constexpr std::uint16_t kRdmManufacturerFirst = 0x8000;  // from here to 0xFFDF parameters are
                                                                // manufacturer-specific

// The format of the data of a request or response.
enum class RdmForm : std::uint8_t {
  kNone,    // no data, or not possible
  kBytes,   // unknown: hexadecimal
  kText,    // up to 32 characters
  kSwitch,  // one octet: off, on
  kU8,
  kU16,
  kU32,
  kParameterList,
  kUidList,
  kDeviceInfo,
  kPersonality,             // current one, and how many there are; set by its number
  kPersonalityDescription,  // number, footprint, text
  kParameterDescription,
  kSlotInfo,
  kSlotText,  // slot, text
  kSlotLevels,
  kSensorDefinition,
  kSensorValue,
  kLampState,
  kPowerState,
};

struct RdmParameter {
  std::uint16_t number = 0;
  std::string_view name;              // as in E1.20: "DMX_START_ADDRESS"
  RdmForm argument = RdmForm::kNone;  // of a get; kU8 or kU16
  RdmForm got = RdmForm::kNone;
  RdmForm set = RdmForm::kNone;
  bool can_set = false;  // with kNone as `set`: set without a value
};
[[nodiscard]] std::span<const RdmParameter> rdm_parameters();
// By name, in any case and with - for _; or by number, as in 0x00F0. nullptr: not in the list.
[[nodiscard]] const RdmParameter* find_rdm_parameter(std::string_view name_or_number);
[[nodiscard]] const RdmParameter* find_rdm_parameter(std::uint16_t number);
// The number in "0x8001"; nullopt: not a number of a parameter.
[[nodiscard]] std::optional<std::uint16_t> rdm_parameter_number(std::string_view text);
// "DMX_START_ADDRESS", or "0x8001" if it is not in the list.
[[nodiscard]] std::string name_of_rdm_parameter(std::uint16_t number);

// One value of an answer: {"start address", "17", true}.
struct RdmField {
  std::string name;  // empty: the value of the whole answer
  std::string text;
  bool is_number = false;
};
// A list has one field per entry. Text from devices is made printable. kProtocol: the data has another format.
[[nodiscard]] Result<std::vector<RdmField>> rdm_fields(RdmForm form, std::span<const std::uint8_t> data,
                                                       std::string_view name);
// kBadInput names what was expected.
[[nodiscard]] Result<Octets> rdm_data(RdmForm form, std::string_view text, std::string_view name);

// The parts of DEVICE_INFO that other code needs.
struct RdmDeviceInfo {
  std::uint16_t model = 0;
  std::uint16_t category = 0;
  std::uint32_t software = 0;
  int footprint = 0;    // slots, 0 to 512
  int personality = 0;  // from 1
  int personality_count = 0;
  int start_address = 0;  // 1 to 512; 0xFFFF: none
  int sub_devices = 0;
  int sensors = 0;
};
[[nodiscard]] Result<RdmDeviceInfo> parse_rdm_device_info(std::span<const std::uint8_t> data);
[[nodiscard]] std::string_view text_of_rdm_category(std::uint16_t category);

// A manufacturer-specific parameter, from PARAMETER_DESCRIPTION.
struct RdmOwnParameter {
  std::uint16_t number = 0;
  RdmForm form = RdmForm::kBytes;
  bool can_get = false;
  bool can_set = false;
  std::string name;
};
[[nodiscard]] Result<RdmOwnParameter> parse_rdm_parameter_description(std::span<const std::uint8_t> data);

// Text printable on one line: other octets become '?', trailing zeros and blanks are removed.
[[nodiscard]] std::string rdm_text(std::span<const std::uint8_t> bytes);

}  // namespace footlight::drivers
