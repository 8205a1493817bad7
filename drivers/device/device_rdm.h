// The RDM line of an open interface. Requests run on the device's thread, between two frames.
#pragma once

#include <memory>
#include <span>
#include <string>

#include "drivers/device/device.h"
#include "drivers/rdm/rdm_directory.h"
#include "drivers/rdm/rdm_line.h"

namespace footlight::drivers {

// Blocks the caller while the device's thread works, so it must not be used on the pump's thread. Does not keep the
// device open: calls after it was closed fail with kDisconnected.
class DeviceRdmLine final : public RdmWire {
 public:
  // `line`: the connector, from 0. `name` starts messages.
  DeviceRdmLine(DeviceHandle device, std::string name, int line, const RdmUid& own)
      : RdmWire(own), device_(std::move(device)), name_(std::move(name)), line_(line) {}
  // The first connector of a sink, which this object keeps open.
  DeviceRdmLine(std::unique_ptr<DeviceSink> sink, const RdmUid& own);

 private:
  Result<Octets> exchange(std::span<const std::uint8_t> request) override;

  const std::unique_ptr<DeviceSink> sink_;  // may be empty
  const DeviceHandle device_;
  const std::string name_;
  const int line_;
};

// Registers the lines of a sink for gateways, if its device supports RDM.
void put_rdm_lines(RdmDirectory& directory, const DeviceSink& sink, const RdmUid& own);

}  // namespace footlight::drivers
