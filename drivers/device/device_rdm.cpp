#include "drivers/device/device_rdm.h"

#include <future>

#include "drivers/rdm/rdm_widget.h"

namespace footlight::drivers {

Result<Octets> DeviceRdmLine::exchange(std::span<const std::uint8_t> request) {
  // The job owns what it needs: it may run when the device is closed, after nobody waits any more.
  const auto answered = std::make_shared<std::promise<Result<Octets>>>();
  auto answer = answered->get_future();
  sink_.link().run_on_device([answered, line = line_, name = sink_.name(), trouble = sink_.trouble(),
                              bytes = Octets(request.begin(), request.end())](Widget& widget, WidgetContext* context) {
    auto* const rdm = dynamic_cast<RdmWidget*>(&widget);
    if (rdm == nullptr) {
      answered->set_value(
          fail(ErrorCode::kUnsupported,
               "{}: this interface, or what is known of it, has no RDM; use an ENTTEC DMX USB Pro or an "
               "Art-Net gateway",
               name));
    } else if (context == nullptr) {
      answered->set_value(fail(ErrorCode::kDisconnected, "{}: {}", name, trouble.empty() ? "unplugged" : trouble));
    } else {
      answered->set_value(rdm->exchange_rdm(*context, line, bytes));
    }
  });
  return answer.get();
}

}  // namespace footlight::drivers
