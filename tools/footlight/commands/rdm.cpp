// footlight rdm: lists the RDM devices on a DMX line, and reads and sets their parameters.
#include <algorithm>
#include <cstdio>
#include <memory>
#include <string>
#include <vector>

#include "drivers/net/artnet_rdm.h"
#include "drivers/ports_factory.h"
#include "drivers/rdm/rdm_controller.h"
#include "drivers/rdm/rdm_line.h"
#include "drivers/rdm/rdm_parameters.h"
#include "sim/system_clock.h"
#include "tools/footlight/bridge/open_ports.h"
#include "tools/footlight/command.h"
#include "tools/footlight/status/json_lines.h"

namespace footlight::tools {
namespace {

using drivers::Octets;
using drivers::RdmUid;

struct Options {
  std::string port;
  std::string uid;
  std::string parameter;
  std::string value;  // get: the argument
  bool json = false;
};

constexpr const char* kPortHelp = "the line: enttec-pro:EN123456, mock:enttec-pro, or artnet:1@10.0.0.7 (a gateway)";

Result<std::unique_ptr<drivers::RdmLine>> open_line(const Options& options, Clock& clock) {
  if (options.port.empty()) {
    return fail(ErrorCode::kBadInput,
                "rdm: expected --port, for example '--port enttec-pro' or '--port mock:enttec-pro'");
  }
  FL_ASSIGN(const Endpoint endpoint, parse_port(options.port));
  if (endpoint.kind == EndpointKind::kDevice) {
    drivers::PortRequest request;
    request.scheme = endpoint.scheme;
    request.target = endpoint.target;
    request.universes = {1};
    request.name = endpoint.text;
    return drivers::open_rdm_line(request, drivers::rdm_own_uid(), clock);
  }
  if (endpoint.scheme == "artnet") return drivers::open_artnet_rdm_line(endpoint, clock);
  return fail(ErrorCode::kBadInput,
              "{}: does not support RDM; use an interface or a gateway: enttec-pro:EN123456 or artnet:1@10.0.0.7",
              options.port);
}

// Reads the parameters of the list. A device that does not answer one of them is listed all the same.
RdmDevice describe(drivers::RdmController& controller, const drivers::RdmFound& found) {
  using namespace drivers;
  RdmDevice device;
  device.uid = text_of(found.uid);
  device.is_proxy = found.is_proxy;
  device.is_proxied = found.is_proxied;
  const auto text = [&](std::uint16_t parameter) -> std::string {
    const auto data = controller.get(found.uid, parameter, {}, name_of_rdm_parameter(parameter));
    return data ? rdm_text(*data) : std::string();
  };
  const auto data = controller.get(found.uid, kRdmDeviceInfo, {}, "DEVICE_INFO");
  const auto info = data ? parse_rdm_device_info(*data) : Result<RdmDeviceInfo>(tl::unexpected(data.error()));
  if (!info) {
    device.trouble = info.error().message;
    return device;
  }
  device.category = text_of_rdm_category(info->category);
  device.footprint = info->footprint;
  device.start_address = info->start_address == 0xFFFF ? 0 : info->start_address;
  device.personality = info->personality;
  device.personalities = info->personality_count;
  device.sub_devices = info->sub_devices;
  device.sensors = info->sensors;
  device.manufacturer = text(kRdmManufacturerLabel);
  device.model = text(kRdmDeviceModelDescription);
  device.label = text(kRdmDeviceLabel);
  device.software = text(kRdmSoftwareVersionLabel);
  const Octets which = {static_cast<std::uint8_t>(info->personality)};
  const auto personality = controller.get(found.uid, kRdmDmxPersonalityDescription, which, "");
  if (personality && personality->size() > 3) device.personality_name = rdm_text(std::span(*personality).subspan(3));
  return device;
}

void print(const RdmDevice& device) {
  std::string name = device.manufacturer;
  for (const std::string& part : {device.model, device.label.empty() ? "" : fmt::format("\"{}\"", device.label)}) {
    if (!part.empty()) name += (name.empty() ? "" : " ") + part;
  }
  fmt::print("{}  {}\n", device.uid, name.empty() ? "(no name)" : name);
  if (!device.trouble.empty()) {
    fmt::print("  {}\n", device.trouble);
    return;
  }
  if (device.start_address == 0) {
    fmt::print("  no slots\n");
  } else {
    fmt::print("  address {}, {} slots, personality {} of {}{}\n", device.start_address, device.footprint,
               device.personality, device.personalities,
               device.personality_name.empty() ? "" : fmt::format(" ({})", device.personality_name));
  }
  fmt::print("  {}{}{}{}\n", device.category,
             device.software.empty() ? "" : fmt::format(", software {}", device.software),
             device.sensors == 0 ? "" : fmt::format(", {} sensors", device.sensors),
             device.is_proxied ? ", behind a proxy"
             : device.is_proxy ? ", a proxy"
                               : "");
}

Result<int> list(const Options& options) {
  SystemClock clock;
  FL_ASSIGN(const auto line, open_line(options, clock));
  FL_ASSIGN(const auto found, line->discover());
  drivers::RdmController controller(*line, clock);
  for (const auto& one : found) {
    const RdmDevice device = describe(controller, one);
    if (options.json) {
      fmt::print("{}\n", json_of_rdm_device(device));
    } else {
      print(device);
    }
  }
  if (!found.empty()) return kExitOk;
  fmt::print(stderr, "footlight: {}: no RDM device on this line answered\n", options.port);
  return kExitNotFound;
}

// A parameter given by the user: one of the list, or a manufacturer parameter, which the device describes.
struct Parameter {
  std::uint16_t number = 0;
  std::string name;
  drivers::RdmForm argument = drivers::RdmForm::kBytes;
  drivers::RdmForm got = drivers::RdmForm::kBytes;
  drivers::RdmForm set = drivers::RdmForm::kBytes;
  bool can_set = true;
};

Result<Parameter> parameter_of(const Options& options, const RdmUid& uid, drivers::RdmController& controller) {
  if (const auto* known = drivers::find_rdm_parameter(options.parameter)) {
    return Parameter{known->number, std::string(known->name), known->argument, known->got, known->set, known->can_set};
  }
  const auto number = drivers::rdm_parameter_number(options.parameter);
  if (!number) {
    std::string names;
    for (const auto& one : drivers::rdm_parameters()) names += fmt::format("{}{}", names.empty() ? "" : ", ", one.name);
    return fail(ErrorCode::kBadInput,
                "\"{}\": no parameter of that name; expected a number such as 0x8001, or one of {}", options.parameter,
                names);
  }
  Parameter parameter;
  parameter.number = *number;
  parameter.name = options.parameter;
  if (*number < drivers::kRdmManufacturerFirst || uid.is_broadcast()) return parameter;
  const Octets argument = {static_cast<std::uint8_t>(*number >> 8), static_cast<std::uint8_t>(*number)};
  const auto data = controller.get(uid, drivers::kRdmParameterDescription, argument, "PARAMETER_DESCRIPTION");
  if (!data) return parameter;  // then as hexadecimal octets
  FL_ASSIGN(const auto own, drivers::parse_rdm_parameter_description(*data));
  parameter.name = fmt::format("{} ({})", options.parameter, own.name);
  parameter.got = own.form;
  parameter.set = own.form;
  parameter.can_set = own.can_set;
  return parameter;
}

Result<int> get(const Options& options) {
  if (options.uid.empty() || options.parameter.empty()) {
    return fail(ErrorCode::kBadInput,
                "rdm get: expected a UID and a parameter, for example 'footlight rdm get 7FF0:00000001 DEVICE_INFO'");
  }
  FL_ASSIGN(const RdmUid uid, drivers::parse_rdm_uid(options.uid));
  SystemClock clock;
  FL_ASSIGN(const auto line, open_line(options, clock));
  drivers::RdmController controller(*line, clock);
  FL_ASSIGN(const Parameter parameter, parameter_of(options, uid, controller));
  FL_ASSIGN(const Octets argument, drivers::rdm_data(parameter.argument, options.value, parameter.name));
  FL_ASSIGN(const Octets data, controller.get(uid, parameter.number, argument, parameter.name));
  FL_ASSIGN(const auto fields, drivers::rdm_fields(parameter.got, data, parameter.name));
  if (options.json) {
    fmt::print("{}\n", json_of_rdm_fields(text_of(uid), drivers::name_of_rdm_parameter(parameter.number), fields));
    return kExitOk;
  }
  for (const auto& field : fields) {
    fmt::print("{}\n", field.name.empty() ? field.text : fmt::format("{}: {}", field.name, field.text));
  }
  return kExitOk;
}

Result<int> set(const Options& options) {
  if (options.uid.empty() || options.parameter.empty()) {
    return fail(ErrorCode::kBadInput,
                "rdm set: expected a UID, a parameter and a value, for example 'footlight rdm set 7FF0:00000001 "
                "DMX_START_ADDRESS 17'");
  }
  FL_ASSIGN(const RdmUid uid, drivers::parse_rdm_uid(options.uid));
  SystemClock clock;
  FL_ASSIGN(const auto line, open_line(options, clock));
  drivers::RdmController controller(*line, clock);
  FL_ASSIGN(const Parameter parameter, parameter_of(options, uid, controller));
  if (!parameter.can_set) {
    return fail(ErrorCode::kBadInput, "{}: is read-only; use 'footlight rdm get'", parameter.name);
  }
  FL_ASSIGN(const Octets data, drivers::rdm_data(parameter.set, options.value, parameter.name));
  FL_TRY(controller.set(uid, parameter.number, data, parameter.name));
  if (options.json)
    fmt::print("{}\n", json_of_rdm_fields(text_of(uid), drivers::name_of_rdm_parameter(parameter.number), {}));
  return kExitOk;
}

void add(Arguments& arguments) {
  Arguments lister = arguments.subcommand("list", "List the devices on the line, with address, slots and name",
                                          "  footlight rdm list --port enttec-pro:EN123456\n"
                                          "  footlight rdm list --port mock:enttec-pro --json\n"
                                          "  footlight rdm list --port artnet:1@10.0.0.7\n"
                                          "Exit code 3 if no device answers.");
  auto list_options = std::make_shared<Options>();
  lister.option("--port", list_options->port, "ENDPOINT", kPortHelp);
  lister.flag("--json", list_options->json, "one JSON object a line for each device");
  lister.job([list_options]() -> Result<int> { return list(*list_options); });

  Arguments getter = arguments.subcommand("get", "Read one parameter of a device",
                                          "  footlight rdm get 7FF0:00000001 DEVICE_INFO --port mock:enttec-pro\n"
                                          "  footlight rdm get 7FF0:00000001 sensor-value 0 --port mock:enttec-pro\n"
                                          "  footlight rdm get 7FF0:00000001 0x8001 --port mock:enttec-pro\n");
  auto get_options = std::make_shared<Options>();
  getter.word("UID", get_options->uid, "of the device, as printed by 'rdm list'");
  getter.word("PARAMETER", get_options->parameter, "its name in E1.20, or its number, for example 0x8001");
  getter.word("ARGUMENT", get_options->value, "the number of the sensor, slot or personality, if there are several");
  getter.option("--port", get_options->port, "ENDPOINT", kPortHelp);
  getter.flag("--json", get_options->json, "one JSON object");
  getter.job([get_options]() -> Result<int> { return get(*get_options); });

  Arguments setter =
      arguments.subcommand("set", "Set a parameter of one device, or of all devices",
                           "  footlight rdm set 7FF0:00000001 DMX_START_ADDRESS 17 --port enttec-pro\n"
                           "  footlight rdm set 7FF0:00000001 DEVICE_LABEL 'FOH left' --port enttec-pro\n"
                           "  footlight rdm set all IDENTIFY_DEVICE off --port enttec-pro\n"
                           "Exit code 1 if the device refuses; its reason is printed.");
  auto set_options = std::make_shared<Options>();
  setter.word("UID", set_options->uid, "of the device, or all");
  setter.word("PARAMETER", set_options->parameter, "its name in E1.20, or its number, for example 0x8001");
  setter.word("VALUE", set_options->value, "a number, text, on or off, or hexadecimal octets");
  setter.option("--port", set_options->port, "ENDPOINT", kPortHelp);
  setter.flag("--json", set_options->json, "one JSON object");
  setter.job([set_options]() -> Result<int> { return set(*set_options); });
}

}  // namespace

extern const CommandInfo rdm_command{
    .name = "rdm",
    .help = "Find RDM devices on a DMX line, and read and set their parameters",
    .examples =
        "  footlight rdm list --port enttec-pro\n"
        "  footlight rdm get 7FF0:00000001 DEVICE_INFO --port mock:enttec-pro\n"
        "  footlight rdm set 7FF0:00000001 IDENTIFY_DEVICE on --port enttec-pro\n",
    .add = add,
};

}  // namespace footlight::tools
