#include "drivers/device/chooser.h"

#include <algorithm>
#include <vector>

#include "drivers/permission.h"

namespace footlight::drivers {

Chooser::Chooser(std::string driver_id, std::string target, FindOptions find)
    : driver_id_(std::move(driver_id)), target_(std::move(target)), find_(std::move(find)) {}

Result<FoundDevice> Chooser::find() const {
  constexpr std::string_view kPort = "port-";
  const DeviceList list = find_devices(find_);
  const std::lock_guard lock(mutex_);
  const bool by_port = target_.starts_with(kPort);
  std::vector<const FoundDevice*> fitting;
  std::string others;
  for (const FoundDevice& device : list.devices) {
    const bool ours = device.driver_id == driver_id_;
    bool fits = ours && target_.empty();
    if (pinned_)
      fits = pinned_->serial.empty() ? device.port_path == pinned_->port_path : device.serial == pinned_->serial;
    else if (by_port)
      fits = device.port_path == target_.substr(kPort.size());
    else if (!target_.empty())
      fits = device.serial == target_;
    if (fits)
      fitting.push_back(&device);
    else if (ours)
      others += fmt::format("{}{}", others.empty() ? "" : ", ", device.endpoint);
  }
  if (fitting.size() == 1) return *fitting[0];
  const std::string named =
      pinned_
          ? fmt::format("{}:{}", driver_id_, pinned_->serial.empty() ? "port-" + pinned_->port_path : pinned_->serial)
          : fmt::format("{}{}{}", driver_id_, target_.empty() ? "" : ":", target_);
  if (fitting.empty())
    return fail(ErrorCode::kNotFound, "{}: not plugged in{}{}", named, others.empty() ? "" : "; there is ", others);
  std::string ports;
  for (const FoundDevice* device : fitting)
    ports += fmt::format("{}{}:port-{}", ports.empty() ? "" : ", ", driver_id_, device->port_path);
  return fail(ErrorCode::kBadInput, "{}: {} devices match; name one of {}", named, fitting.size(), ports);
}

Result<FoundDevice> Chooser::choose() const {
  FL_ASSIGN(FoundDevice found, find());
  switch (found.readiness) {
    case Readiness::kReady: break;
    case Readiness::kNotDmx:  // named by the user; the driver will find out whether it answers
      if (!found.holder.empty()) return fail(ErrorCode::kPermission, "{}: in use by {}", found.node, found.holder);
      break;
    case Readiness::kUnsupported: return fail(ErrorCode::kUnsupported, "{}", found.reason);
    case Readiness::kNoNode: return fail(ErrorCode::kNotFound, "{}", found.reason);
    case Readiness::kNoPermission:  // the reason starts with the node
      return fail(ErrorCode::kPermission, "{}", message_of({found.reason, found.remedy}));
    case Readiness::kBusy:
      return fail(ErrorCode::kPermission, "{}: {}", found.node, message_of({found.reason, found.remedy}));
  }
  return found;
}

void Chooser::pin(const FoundDevice& device) {
  const DeviceList list = find_devices(find_);
  const bool shared = std::count_if(list.devices.begin(), list.devices.end(),
                                    [&](const FoundDevice& other) { return other.serial == device.serial; }) > 1;
  const std::lock_guard lock(mutex_);
  if (pinned_) return;
  pinned_ = device.serial.empty() || shared ? Pin{.serial = {}, .port_path = device.port_path}
                                            : Pin{.serial = device.serial, .port_path = {}};
}

std::string Chooser::identity() const {
  if (const auto found = find()) return fmt::format("{} at {}/{}", driver_id_, found->port_path, found->serial);
  return fmt::format("{}:{}", driver_id_, target_);  // two ports that wait for the same device share it
}

}  // namespace footlight::drivers
