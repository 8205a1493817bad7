// The RDM line of an open interface: requests go over the device's thread, between two frames.
#pragma once

#include <memory>
#include <span>

#include "drivers/device/device.h"
#include "drivers/rdm/rdm_line.h"

namespace footlight::drivers {

// Blocks the caller while the device's thread does the work, so it is not for the pump's thread.
class DeviceRdmLine final : public RdmWire {
 public:
  // `line`: the connector, from 0. The sink outlives it.
  DeviceRdmLine(const DeviceSink& sink, int line, const RdmUid& own) : RdmWire(own), sink_(sink), line_(line) {}
  // Keeps the interface open by itself.
  DeviceRdmLine(std::unique_ptr<DeviceSink> sink, int line, const RdmUid& own)
      : RdmWire(own), owned_(std::move(sink)), sink_(*owned_), line_(line) {}

 private:
  Result<Octets> exchange(std::span<const std::uint8_t> request) override;

  const std::unique_ptr<DeviceSink> owned_;
  const DeviceSink& sink_;
  const int line_;
};

}  // namespace footlight::drivers
