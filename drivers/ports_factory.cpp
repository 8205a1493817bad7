#include "drivers/ports_factory.h"

#include <algorithm>
#include <optional>

#include "drivers/device/chooser.h"
#include "drivers/device/device.h"
#include "drivers/device/device_rdm.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/transport/either_opener.h"
#include "drivers/transport/hid_opener.h"
#include "drivers/transport/libusb_opener.h"
#include "drivers/transport/tty_opener.h"
#include "drivers/usb_match.h"

namespace footlight::drivers {
namespace {

Result<const DriverInfo*> driver_of(const PortRequest& request) {
  if (const DriverInfo* driver = find_driver(request.scheme)) return driver;
  std::string known;
  for (const DriverInfo* driver : drivers()) known += fmt::format("{}{}", known.empty() ? "" : ", ", driver->id);
  return fail(ErrorCode::kBadInput, "{}:{}: no driver of that name; expected one of {}", request.scheme, request.target,
              known);
}

Status check_universes(const PortRequest& request) {
  for (const Universe universe : request.universes)
    if (!is_universe(universe))
      return fail(ErrorCode::kBadInput, "{}:{}: universe {}: expected {} to {}", request.scheme, request.target,
                  universe, kUniverseMin, kUniverseMax);
  return {};
}

}  // namespace

const DriverInfo* find_driver(std::string_view id) {
  const auto all = drivers();
  const auto found = std::find_if(all.begin(), all.end(), [&](const DriverInfo* driver) { return driver->id == id; });
  return found == all.end() ? nullptr : *found;
}

std::string name_of(const PortRequest& request) {
  if (!request.name.empty()) return request.name;
  return request.target.empty() ? request.scheme : fmt::format("{}:{}", request.scheme, request.target);
}

bool has_driver(std::string_view scheme) { return find_driver(scheme) != nullptr; }

namespace {

// Everything needed to open a port of a device.
struct Opening {
  DevicePlan plan;
  DevicePortConfig port;
};

// The row of the plugged-in device; an empty one if it is unknown.
UsbModelId model_of(const DriverInfo& driver, const std::string& target) {
  const auto found = Chooser(std::string(driver.id), target).find();
  if (!found || found->driver_id != driver.id) return {};
  const UsbMatch match = match_usb_device(found->usb_vendor, found->usb_product, found->manufacturer, found->product);
  return match.model != nullptr ? *match.model : UsbModelId{};
}

bool has_rows_of(const DriverInfo& driver, TransportKind kind) {
  return std::any_of(driver.usb_ids.begin(), driver.usb_ids.end(),
                     [&](const UsbModelId& model) { return model.transport == kind; });
}

// The opener has every transport that a device of this driver may need, since the device may be plugged in later. The
// plugged-in device decides which one is used. A device that the user names uses the driver's first row.
Result<std::unique_ptr<Opener>> opener_of(const DriverInfo& driver, const PortRequest& request, Clock& clock) {
  auto chooser = std::make_shared<Chooser>(std::string(driver.id), request.target);
  const TransportKind unknown_kind = driver.usb_ids[0].transport;
  if (has_rows_of(driver, TransportKind::kHid))
    return make_hid_opener({.driver_id = std::string(driver.id), .target = request.target}, clock);
  auto libusb = make_libusb_opener({.chooser = chooser, .unknown_kind = unknown_kind}, clock);
  if (has_rows_of(driver, TransportKind::kUsb)) return libusb;
  FL_ASSIGN(auto tty, make_tty_opener(chooser, clock));
  if (!libusb) return tty;
  const auto snapshot = [chooser, unknown_kind]() -> std::optional<SeenDevice> {
    const auto found = chooser->find();
    if (!found) return std::nullopt;
    return SeenDevice{found->driver_id == chooser->driver_id() ? found->transport : unknown_kind, found->node};
  };
  return make_either_opener(std::move(*libusb), std::move(tty), snapshot, clock);
}

// The requested connectors, or the first ones that support the use.
Result<std::vector<DeviceLine>> lines_of(const PortRequest& request, const Widget& widget, LineUse use) {
  std::vector<DeviceLine> lines;
  if (!request.connectors.empty() && request.connectors.size() != request.universes.size())
    return fail(ErrorCode::kBadInput, "{}: {} connectors and {} universes; name equally many", name_of(request),
                request.connectors.size(), request.universes.size());
  if (!request.connectors.empty()) {
    for (std::size_t i = 0; i < request.universes.size(); ++i)
      lines.push_back({.line = request.connectors[i] - 1, .universe = request.universes[i]});
    return lines;
  }
  Status refusal;
  for (int line = 0; line < widget.line_count() && lines.size() < request.universes.size(); ++line) {
    const Status can = widget.can(line, use);
    if (can)
      lines.push_back({.line = line, .universe = request.universes[lines.size()]});
    else
      refusal = can;
  }
  if (lines.size() == request.universes.size()) return lines;
  if (!refusal) return fail(refusal.error().code, "{}: {}", name_of(request), refusal.error().message);
  return fail(ErrorCode::kBadInput, "{}: supports {} universe{}, but {} were requested", name_of(request), lines.size(),
              lines.size() == 1 ? "" : "s", request.universes.size());
}

Result<Opening> opening_of(const PortRequest& request, LineUse use, Clock& clock) {
  FL_ASSIGN(const DriverInfo* driver, driver_of(request));
  FL_TRY(check_universes(request));
  Opening opening;
  UsbModelId model;
  if (driver->make_widget == nullptr) {
    FL_ASSIGN(const mock::MockTarget target, mock::mock_of_target(request.target, use == LineUse::kOutput));
    driver = target.driver;
    model = target.row;
    opening.plan.opener = mock::make_mock_opener(target.usb, clock);
  } else {
    FL_ASSIGN(opening.plan.opener, opener_of(*driver, request, clock));
    model = model_of(*driver, request.target);
  }
  const unsigned wanted = use == LineUse::kOutput ? kCanOutput : kCanInput;
  if ((driver->capabilities & wanted) == 0)
    return fail(ErrorCode::kUnsupported, "{}: has no {}", name_of(request),
                use == LineUse::kOutput ? "output" : "input");
  FL_ASSIGN(opening.plan.widget, driver->make_widget(request, model));
  FL_ASSIGN(std::vector<DeviceLine> lines, lines_of(request, *opening.plan.widget, use));
  opening.port = {.name = name_of(request),
                  .lines = std::move(lines),
                  .blackout_on_exit = request.blackout_on_exit,
                  .wait_for_device = request.wait_for_device};
  return opening;
}

}  // namespace

Result<std::unique_ptr<Sink>> open_sink(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(Opening opening, opening_of(request, LineUse::kOutput, clock));
  return DeviceSink::open(std::move(opening.plan), opening.port, clock);
}

Result<std::unique_ptr<RdmLine>> open_rdm_line(const PortRequest& request, const RdmUid& own, Clock& clock) {
  FL_ASSIGN(Opening opening, opening_of(request, LineUse::kOutput, clock));
  FL_ASSIGN(auto sink, DeviceSink::open(std::move(opening.plan), opening.port, clock));
  return std::make_unique<DeviceRdmLine>(std::move(sink), own);
}

Result<std::unique_ptr<Source>> open_source(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(Opening opening, opening_of(request, LineUse::kInput, clock));
  return DeviceSource::open(std::move(opening.plan), opening.port, clock);
}

}  // namespace footlight::drivers
