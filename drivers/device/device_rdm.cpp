#include "drivers/device/device_rdm.h"

#include <future>
#include <utility>

#include "drivers/rdm/rdm_widget.h"

namespace footlight::drivers {

DeviceRdmLine::DeviceRdmLine(std::unique_ptr<DeviceSink> sink, const RdmUid& own)
    : RdmWire(own),
      sink_(std::move(sink)),
      device_(sink_->link().handle()),
      name_(sink_->name()),
      line_(sink_->link().lines().front().line) {}

Result<Octets> DeviceRdmLine::exchange(std::span<const std::uint8_t> request) {
  // The job owns its data: it may run when the device is closed and the caller has gone.
  const auto answered = std::make_shared<std::promise<Result<Octets>>>();
  auto answer = answered->get_future();
  const bool posted =
      device_.run_on_device([answered, line = line_, name = name_, bytes = Octets(request.begin(), request.end())](
                                Widget& widget, WidgetContext* context) {
        auto* const rdm = dynamic_cast<RdmWidget*>(&widget);
        if (rdm == nullptr) {
          answered->set_value(fail(ErrorCode::kUnsupported,
                                   "{}: this interface, or its driver, has no RDM; use an ENTTEC DMX USB Pro "
                                   "or an Art-Net gateway",
                                   name));
        } else if (context == nullptr) {
          answered->set_value(fail(ErrorCode::kDisconnected, "{}: unplugged or closed", name));
        } else {
          answered->set_value(rdm->exchange_rdm(*context, line, bytes));
        }
      });
  if (!posted) return fail(ErrorCode::kDisconnected, "{}: closed", name_);
  return answer.get();
}

void put_rdm_lines(RdmDirectory& directory, const DeviceSink& sink, const RdmUid& own) {
  if (!sink.link().has_rdm()) return;
  const DeviceHandle device = sink.link().handle();
  for (const DeviceLine& line : sink.link().lines()) {
    directory.put(
        line.universe,
        [device, name = sink.name(), at = line.line, own]() -> std::unique_ptr<RdmLine> {
          return std::make_unique<DeviceRdmLine>(device, name, at, own);
        },
        [device] { return device.is_gone(); });
  }
}

}  // namespace footlight::drivers
