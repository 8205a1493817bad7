#include "drivers/rdm/rdm_parameters.h"

#include <algorithm>
#include <charconv>
#include <cmath>

namespace footlight::drivers {
namespace {

constexpr std::size_t kTextMax = 32;
constexpr int kNoStartAddress = 0xFFFF;

constexpr RdmParameter kParameters[] = {
    {0x0010, "PROXIED_DEVICES", RdmForm::kNone, RdmForm::kUidList},
    {kRdmSupportedParameters, "SUPPORTED_PARAMETERS", RdmForm::kNone, RdmForm::kParameterList},
    {kRdmParameterDescription, "PARAMETER_DESCRIPTION", RdmForm::kU16, RdmForm::kParameterDescription},
    {kRdmDeviceInfo, "DEVICE_INFO", RdmForm::kNone, RdmForm::kDeviceInfo},
    {kRdmDeviceModelDescription, "DEVICE_MODEL_DESCRIPTION", RdmForm::kNone, RdmForm::kText},
    {kRdmManufacturerLabel, "MANUFACTURER_LABEL", RdmForm::kNone, RdmForm::kText},
    {kRdmDeviceLabel, "DEVICE_LABEL", RdmForm::kNone, RdmForm::kText, RdmForm::kText, true},
    {0x0090, "FACTORY_DEFAULTS", RdmForm::kNone, RdmForm::kSwitch, RdmForm::kNone, true},
    {kRdmSoftwareVersionLabel, "SOFTWARE_VERSION_LABEL", RdmForm::kNone, RdmForm::kText},
    {0x00C1, "BOOT_SOFTWARE_VERSION_ID", RdmForm::kNone, RdmForm::kU32},
    {0x00C2, "BOOT_SOFTWARE_VERSION_LABEL", RdmForm::kNone, RdmForm::kText},
    {kRdmDmxPersonality, "DMX_PERSONALITY", RdmForm::kNone, RdmForm::kPersonality, RdmForm::kU8, true},
    {kRdmDmxPersonalityDescription, "DMX_PERSONALITY_DESCRIPTION", RdmForm::kU8, RdmForm::kPersonalityDescription},
    {kRdmDmxStartAddress, "DMX_START_ADDRESS", RdmForm::kNone, RdmForm::kU16, RdmForm::kU16, true},
    {kRdmSlotInfo, "SLOT_INFO", RdmForm::kNone, RdmForm::kSlotInfo},
    {kRdmSlotDescription, "SLOT_DESCRIPTION", RdmForm::kU16, RdmForm::kSlotText},
    {0x0122, "DEFAULT_SLOT_VALUE", RdmForm::kNone, RdmForm::kSlotLevels},
    {kRdmSensorDefinition, "SENSOR_DEFINITION", RdmForm::kU8, RdmForm::kSensorDefinition},
    {kRdmSensorValue, "SENSOR_VALUE", RdmForm::kU8, RdmForm::kSensorValue},
    {0x0400, "DEVICE_HOURS", RdmForm::kNone, RdmForm::kU32, RdmForm::kU32, true},
    {0x0401, "LAMP_HOURS", RdmForm::kNone, RdmForm::kU32, RdmForm::kU32, true},
    {0x0402, "LAMP_STRIKES", RdmForm::kNone, RdmForm::kU32, RdmForm::kU32, true},
    {0x0403, "LAMP_STATE", RdmForm::kNone, RdmForm::kLampState, RdmForm::kU8, true},
    {0x0405, "DEVICE_POWER_CYCLES", RdmForm::kNone, RdmForm::kU32, RdmForm::kU32, true},
    {0x0501, "DISPLAY_LEVEL", RdmForm::kNone, RdmForm::kU8, RdmForm::kU8, true},
    {0x0600, "PAN_INVERT", RdmForm::kNone, RdmForm::kSwitch, RdmForm::kSwitch, true},
    {0x0601, "TILT_INVERT", RdmForm::kNone, RdmForm::kSwitch, RdmForm::kSwitch, true},
    {0x0602, "PAN_TILT_SWAP", RdmForm::kNone, RdmForm::kSwitch, RdmForm::kSwitch, true},
    {kRdmIdentifyDevice, "IDENTIFY_DEVICE", RdmForm::kNone, RdmForm::kSwitch, RdmForm::kSwitch, true},
    {0x1001, "RESET_DEVICE", RdmForm::kNone, RdmForm::kNone, RdmForm::kU8, true},
    {0x1010, "POWER_STATE", RdmForm::kNone, RdmForm::kPowerState, RdmForm::kU8, true},
};

struct Number {
  std::uint16_t value;
  std::string_view text;
};

constexpr Number kCategories[] = {
    {0x0000, "not declared"},
    {0x0100, "fixture"},
    {0x0101, "fixture, fixed"},
    {0x0102, "fixture, moving yoke"},
    {0x0103, "fixture, moving mirror"},
    {0x01FF, "fixture, other"},
    {0x0200, "fixture accessory"},
    {0x0201, "fixture accessory, colour"},
    {0x0202, "fixture accessory, yoke"},
    {0x0203, "fixture accessory, mirror"},
    {0x0204, "fixture accessory, effect"},
    {0x0205, "fixture accessory, beam"},
    {0x02FF, "fixture accessory, other"},
    {0x0300, "projector"},
    {0x0301, "projector, fixed"},
    {0x0302, "projector, moving yoke"},
    {0x0303, "projector, moving mirror"},
    {0x03FF, "projector, other"},
    {0x0400, "atmospheric"},
    {0x0401, "atmospheric, effect"},
    {0x0402, "atmospheric, pyrotechnic"},
    {0x04FF, "atmospheric, other"},
    {0x0500, "dimmer"},
    {0x0501, "dimmer, AC incandescent"},
    {0x0502, "dimmer, AC fluorescent"},
    {0x0503, "dimmer, AC cold cathode"},
    {0x0504, "dimmer, AC not dimming"},
    {0x0505, "dimmer, AC low voltage"},
    {0x0506, "dimmer, AC other"},
    {0x0507, "dimmer, DC level"},
    {0x0508, "dimmer, DC PWM"},
    {0x0509, "dimmer, LED"},
    {0x05FF, "dimmer, other"},
    {0x0600, "power"},
    {0x0601, "power, control"},
    {0x0602, "power, source"},
    {0x06FF, "power, other"},
    {0x0700, "scenic"},
    {0x0701, "scenic, drive"},
    {0x07FF, "scenic, other"},
    {0x0800, "data"},
    {0x0801, "data, distribution"},
    {0x0802, "data, conversion"},
    {0x08FF, "data, other"},
    {0x0900, "audio and video"},
    {0x0901, "audio"},
    {0x0902, "video"},
    {0x09FF, "audio and video, other"},
    {0x0A00, "monitor"},
    {0x0A01, "monitor, AC line power"},
    {0x0A02, "monitor, DC power"},
    {0x0A03, "monitor, environment"},
    {0x0AFF, "monitor, other"},
    {0x7000, "control"},
    {0x7001, "control, controller"},
    {0x7002, "control, backup device"},
    {0x70FF, "control, other"},
    {0x7100, "test"},
    {0x7101, "test equipment"},
    {0x71FF, "test equipment, other"},
    {0x7FFF, "other"},
};

constexpr std::string_view kSensorTypes[] = {"temperature",
                                             "voltage",
                                             "current",
                                             "frequency",
                                             "resistance",
                                             "power",
                                             "mass",
                                             "length",
                                             "area",
                                             "volume",
                                             "density",
                                             "velocity",
                                             "acceleration",
                                             "force",
                                             "energy",
                                             "pressure",
                                             "time",
                                             "angle",
                                             "position x",
                                             "position y",
                                             "position z",
                                             "angular velocity",
                                             "luminous intensity",
                                             "luminous flux",
                                             "illuminance",
                                             "red",
                                             "green",
                                             "blue",
                                             "contacts",
                                             "memory",
                                             "items",
                                             "humidity",
                                             "counter"};
constexpr std::string_view kSensorUnits[] = {
    "",       "degC", "V",     "V peak", "V", "A",  "A peak", "A",   "Hz", "Ohm", "W",  "kg", "m",   "m^2",  "m^3",
    "kg/m^3", "m/s",  "m/s^2", "N",      "J", "Pa", "s",      "deg", "sr", "cd",  "lm", "lx", "IRE", "bytes"};
constexpr std::string_view kLampStates[] = {"off", "on", "striking", "standby", "not present"};

class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> data) : data_(data) {}
  [[nodiscard]] std::size_t left() const { return data_.size() - at_; }
  std::uint8_t u8() { return data_[at_++]; }
  std::uint16_t u16() {
    const auto high = static_cast<unsigned>(u8());
    return static_cast<std::uint16_t>(high << 8 | u8());
  }
  std::uint32_t u32() {
    const auto high = std::uint32_t{u16()};
    return high << 16 | u16();
  }
  std::int16_t i16() { return static_cast<std::int16_t>(u16()); }
  std::span<const std::uint8_t> rest() { return data_.subspan(std::exchange(at_, data_.size())); }

 private:
  std::span<const std::uint8_t> data_;
  std::size_t at_ = 0;
};

RdmField number_field(std::string name, long long value) { return {std::move(name), std::to_string(value), true}; }
RdmField text_field(std::string name, std::string text) { return {std::move(name), std::move(text), false}; }

std::string text_at(std::span<const std::string_view> texts, std::size_t index) {
  return index < texts.size() ? std::string(texts[index]) : fmt::format("kind {}", index);
}

// The power of ten of a sensor's prefix.
int exponent_of(std::uint8_t prefix) {
  constexpr int kExponents[] = {0, 1, 2, 3, 6, 9, 12, 15, 18, 21, 24};
  if (prefix < std::size(kExponents)) return -kExponents[prefix];
  if (prefix > 0x10 && prefix - 0x10u < std::size(kExponents)) return kExponents[prefix - 0x10];
  return 0;
}

std::string amount(int value, std::uint8_t unit, std::uint8_t prefix) {
  const double scaled = value * std::pow(10.0, exponent_of(prefix));
  const std::string name = text_at(kSensorUnits, unit);
  return fmt::format("{:g}{}{}", scaled, name.empty() ? "" : " ", name);
}

RdmForm form_of_type(std::uint8_t type, std::size_t size) {
  if (type == 2) return RdmForm::kText;
  if (type == 3 || (type == 1 && size == 1)) return RdmForm::kU8;
  if (type == 5) return RdmForm::kU16;
  if (type == 7) return RdmForm::kU32;
  return RdmForm::kBytes;
}

// The minimum length of the data, and whether it may be longer.
struct Size {
  std::size_t least = 0;
  std::size_t most = kRdmDataSizeMax;
};
Size size_of(RdmForm form) {
  switch (form) {
    case RdmForm::kNone:
    case RdmForm::kBytes:
    case RdmForm::kText:
    case RdmForm::kParameterList:
    case RdmForm::kUidList:
    case RdmForm::kSlotInfo:
    case RdmForm::kSlotLevels: return {0, SIZE_MAX};
    case RdmForm::kSwitch:
    case RdmForm::kU8:
    case RdmForm::kLampState:
    case RdmForm::kPowerState: return {1, 1};
    case RdmForm::kU16:
    case RdmForm::kPersonality: return {2, 2};
    case RdmForm::kU32: return {4, 4};
    case RdmForm::kDeviceInfo: return {19, 19};
    case RdmForm::kPersonalityDescription: return {3, 3 + kTextMax};
    case RdmForm::kParameterDescription: return {20, 20 + kTextMax};
    case RdmForm::kSlotText: return {2, 2 + kTextMax};
    case RdmForm::kSensorDefinition: return {13, 13 + kTextMax};
    case RdmForm::kSensorValue: return {9, 9};
  }
  return {};
}

tl::unexpected<Error> not_of_that_form(std::string_view name, std::size_t size) {
  return fail(ErrorCode::kProtocol, "{}: the device answered {} octets, which is not the format of this parameter",
              name, size);
}

template <class T>
std::optional<T> whole_number(std::string_view text) {
  T value = 0;
  int base = 10;
  if (text.starts_with("0x") || text.starts_with("0X")) {
    text.remove_prefix(2);
    base = 16;
  }
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value, base);
  if (text.empty() || error != std::errc{} || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::span<const RdmParameter> rdm_parameters() { return kParameters; }

const RdmParameter* find_rdm_parameter(std::uint16_t number) {
  const auto found = std::find_if(std::begin(kParameters), std::end(kParameters),
                                  [&](const RdmParameter& one) { return one.number == number; });
  return found == std::end(kParameters) ? nullptr : found;
}

std::optional<std::uint16_t> rdm_parameter_number(std::string_view text) {
  if (!text.starts_with("0x")) return std::nullopt;
  return whole_number<std::uint16_t>(text);
}

const RdmParameter* find_rdm_parameter(std::string_view name_or_number) {
  if (const auto number = rdm_parameter_number(name_or_number)) return find_rdm_parameter(*number);
  std::string name(name_or_number);
  for (char& c : name) {
    if (c == '-') c = '_';
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  const auto found = std::find_if(std::begin(kParameters), std::end(kParameters),
                                  [&](const RdmParameter& one) { return one.name == name; });
  return found == std::end(kParameters) ? nullptr : found;
}

std::string name_of_rdm_parameter(std::uint16_t number) {
  const RdmParameter* const known = find_rdm_parameter(number);
  return known != nullptr ? std::string(known->name) : fmt::format("{:#06x}", number);
}

std::string rdm_text(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    if (byte == 0) break;
    text += byte < 0x20 || byte > 0x7E ? '?' : static_cast<char>(byte);
  }
  while (!text.empty() && text.back() == ' ') text.pop_back();
  return text;
}

std::string_view text_of_rdm_category(std::uint16_t category) {
  const auto found = std::find_if(std::begin(kCategories), std::end(kCategories),
                                  [&](const Number& one) { return one.value == category; });
  return found == std::end(kCategories) ? "a manufacturer-specific category" : found->text;
}

Result<RdmDeviceInfo> parse_rdm_device_info(std::span<const std::uint8_t> data) {
  if (data.size() != size_of(RdmForm::kDeviceInfo).least) return not_of_that_form("DEVICE_INFO", data.size());
  Reader reader(data.subspan(2));  // version of the protocol
  RdmDeviceInfo info;
  info.model = reader.u16();
  info.category = reader.u16();
  info.software = reader.u32();
  info.footprint = reader.u16();
  info.personality = reader.u8();
  info.personality_count = reader.u8();
  info.start_address = reader.u16();
  info.sub_devices = reader.u16();
  info.sensors = reader.u8();
  return info;
}

Result<RdmOwnParameter> parse_rdm_parameter_description(std::span<const std::uint8_t> data) {
  const Size size = size_of(RdmForm::kParameterDescription);
  if (data.size() < size.least || data.size() > size.most) {
    return not_of_that_form("PARAMETER_DESCRIPTION", data.size());
  }
  Reader reader(data);
  RdmOwnParameter own;
  own.number = reader.u16();
  const std::size_t length = reader.u8();
  own.form = form_of_type(reader.u8(), length);
  const unsigned commands = reader.u8();
  own.can_get = (commands & 1u) != 0;
  own.can_set = (commands & 2u) != 0;
  own.name = rdm_text(data.subspan(20));
  return own;
}

Result<std::vector<RdmField>> rdm_fields(RdmForm form, std::span<const std::uint8_t> data, std::string_view name) {
  const Size size = size_of(form);
  if (data.size() < size.least || data.size() > size.most) return not_of_that_form(name, data.size());
  Reader reader(data);
  std::vector<RdmField> fields;
  switch (form) {
    case RdmForm::kNone: break;
    case RdmForm::kBytes: {
      std::string text;
      for (const std::uint8_t byte : data) text += fmt::format("{}{:02X}", text.empty() ? "" : " ", byte);
      fields.push_back(text_field("", text));
      break;
    }
    case RdmForm::kText: fields.push_back(text_field("", rdm_text(data))); break;
    case RdmForm::kSwitch: fields.push_back(text_field("", reader.u8() != 0 ? "on" : "off")); break;
    case RdmForm::kU8: fields.push_back(number_field("", reader.u8())); break;
    case RdmForm::kU16: fields.push_back(number_field("", reader.u16())); break;
    case RdmForm::kU32: fields.push_back(number_field("", reader.u32())); break;
    case RdmForm::kLampState: fields.push_back(text_field("", text_at(kLampStates, reader.u8()))); break;
    case RdmForm::kPowerState: {
      const std::uint8_t state = reader.u8();
      constexpr std::string_view kStates[] = {"full off", "shutdown", "standby"};
      fields.push_back(text_field("", state == 0xFF ? "normal" : text_at(kStates, state)));
      break;
    }
    case RdmForm::kParameterList:
      if (data.size() % 2 != 0) return not_of_that_form(name, data.size());
      while (reader.left() > 0) fields.push_back(text_field("", name_of_rdm_parameter(reader.u16())));
      break;
    case RdmForm::kUidList:
      if (data.size() % 6 != 0) return not_of_that_form(name, data.size());
      while (reader.left() > 0) {
        const std::uint16_t manufacturer = reader.u16();
        fields.push_back(text_field("", text_of(RdmUid{manufacturer, reader.u32()})));
      }
      break;
    case RdmForm::kDeviceInfo: {
      FL_ASSIGN(const RdmDeviceInfo info, parse_rdm_device_info(data));
      fields.push_back(text_field("model", fmt::format("{:#06x}", info.model)));
      fields.push_back(text_field("category", std::string(text_of_rdm_category(info.category))));
      fields.push_back(text_field("software", fmt::format("{:#010x}", info.software)));
      fields.push_back(number_field("footprint", info.footprint));
      fields.push_back(number_field("personality", info.personality));
      fields.push_back(number_field("personalities", info.personality_count));
      if (info.start_address != kNoStartAddress) fields.push_back(number_field("start address", info.start_address));
      fields.push_back(number_field("sub-devices", info.sub_devices));
      fields.push_back(number_field("sensors", info.sensors));
      break;
    }
    case RdmForm::kPersonality:
      fields.push_back(number_field("personality", reader.u8()));
      fields.push_back(number_field("personalities", reader.u8()));
      break;
    case RdmForm::kPersonalityDescription:
      fields.push_back(number_field("personality", reader.u8()));
      fields.push_back(number_field("footprint", reader.u16()));
      fields.push_back(text_field("name", rdm_text(reader.rest())));
      break;
    case RdmForm::kParameterDescription: {
      FL_ASSIGN(const RdmOwnParameter own, parse_rdm_parameter_description(data));
      fields.push_back(text_field("parameter", fmt::format("{:#06x}", own.number)));
      fields.push_back(text_field("name", own.name));
      fields.push_back(text_field("can", own.can_get && own.can_set ? "get, set" : own.can_get ? "get" : "set"));
      Reader limits(data.subspan(8));
      fields.push_back(number_field("lowest", limits.u32()));
      fields.push_back(number_field("highest", limits.u32()));
      fields.push_back(number_field("default", limits.u32()));
      break;
    }
    case RdmForm::kSlotInfo:
      if (data.size() % 5 != 0) return not_of_that_form(name, data.size());
      while (reader.left() > 0) {
        const int slot = reader.u16();
        const int type = reader.u8();
        const int what = reader.u16();
        // A secondary slot refers to its primary slot; a primary one has a function.
        fields.push_back(text_field(fmt::format("slot {}", slot + 1),
                                    type == 0 ? fmt::format("function {:#06x}", what)
                                              : fmt::format("kind {:#04x} of slot {}", type, what + 1)));
      }
      break;
    case RdmForm::kSlotText: {
      const int slot = reader.u16();
      fields.push_back(text_field(fmt::format("slot {}", slot + 1), rdm_text(reader.rest())));
      break;
    }
    case RdmForm::kSlotLevels:
      if (data.size() % 3 != 0) return not_of_that_form(name, data.size());
      while (reader.left() > 0) {
        const int slot = reader.u16();
        fields.push_back(number_field(fmt::format("slot {}", slot + 1), reader.u8()));
      }
      break;
    case RdmForm::kSensorDefinition: {
      fields.push_back(number_field("sensor", reader.u8()));
      fields.push_back(text_field("kind", text_at(kSensorTypes, reader.u8())));
      const std::uint8_t unit = reader.u8();
      const std::uint8_t prefix = reader.u8();
      for (const char* const limit : {"lowest", "highest", "normal from", "normal to"}) {
        fields.push_back(text_field(limit, amount(reader.i16(), unit, prefix)));
      }
      reader.u8();  // which values it records
      fields.push_back(text_field("name", rdm_text(reader.rest())));
      break;
    }
    case RdmForm::kSensorValue:
      fields.push_back(number_field("sensor", reader.u8()));
      for (const char* const value : {"value", "lowest", "highest", "recorded"}) {
        fields.push_back(number_field(value, reader.i16()));
      }
      break;
  }
  return fields;
}

Result<Octets> rdm_data(RdmForm form, std::string_view text, std::string_view name) {
  const auto number = [&](std::uint64_t most, int octets) -> Result<Octets> {
    const auto value = whole_number<std::uint64_t>(text);
    if (!value || *value > most) {
      return fail(ErrorCode::kBadInput, "{}: expected a number from 0 to {}, got \"{}\"", name, most, text);
    }
    Octets data;
    for (int shift = 8 * (octets - 1); shift >= 0; shift -= 8)
      data.push_back(static_cast<std::uint8_t>(*value >> shift));
    return data;
  };
  switch (form) {
    case RdmForm::kNone:
      if (text.empty()) return Octets{};
      return fail(ErrorCode::kBadInput, "{}: takes no value, got \"{}\"", name, text);
    case RdmForm::kText: {
      if (text.size() > kTextMax) {
        return fail(ErrorCode::kBadInput, "{}: expected at most {} characters, got {}", name, kTextMax, text.size());
      }
      const bool printable = std::all_of(text.begin(), text.end(), [](char c) { return c >= 0x20 && c <= 0x7E; });
      if (!printable) return fail(ErrorCode::kBadInput, "{}: expected printable ASCII, got \"{}\"", name, text);
      return Octets(text.begin(), text.end());
    }
    case RdmForm::kSwitch:
      if (text == "on" || text == "1" || text == "true") return Octets{1};
      if (text == "off" || text == "0" || text == "false") return Octets{0};
      return fail(ErrorCode::kBadInput, "{}: expected on or off, got \"{}\"", name, text);
    case RdmForm::kU8: return number(0xFF, 1);
    case RdmForm::kU16: return number(0xFFFF, 2);
    case RdmForm::kU32: return number(0xFFFF'FFFF, 4);
    default: {
      Octets data;
      for (std::size_t at = 0; at < text.size();) {
        if (text[at] == ' ') {
          ++at;
          continue;
        }
        const auto byte =
            at + 2 <= text.size() ? whole_number<std::uint8_t>(fmt::format("0x{}", text.substr(at, 2))) : std::nullopt;
        if (!byte || data.size() == kRdmDataSizeMax) {
          return fail(ErrorCode::kBadInput, "{}: expected up to {} octets in hexadecimal as in \"00 1F\", got \"{}\"",
                      name, kRdmDataSizeMax, text);
        }
        data.push_back(*byte);
        at += 2;
      }
      return data;
    }
  }
}

}  // namespace footlight::drivers
