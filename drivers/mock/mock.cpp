// The driver's row of the models in drivers/mock/: `mock:enttec-pro`.
#include "drivers/driver.h"
#include "drivers/mock/mock_usb.h"
#include "drivers/usb/enttec_pro.h"

namespace footlight::drivers {
namespace {

Result<EnttecProConfig> config_of(const PortRequest& request) {
  if (request.universes.size() != 1)
    return fail(ErrorCode::kBadInput, "{}: carries one universe, {} were asked for", name_of(request),
                request.universes.size());
  return EnttecProConfig{.universe = request.universes[0],
                         .name = name_of(request),
                         .blackout_on_exit = request.blackout_on_exit,
                         .wait_for_device = request.wait_for_device};
}

Result<std::unique_ptr<Sink>> open_mock_sink(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(auto usb, mock::mock_of_target(request.target, true));
  FL_ASSIGN(EnttecProConfig config, config_of(request));
  return EnttecProSink::open(std::move(config), mock::make_mock_connector(std::move(usb), clock), clock);
}

Result<std::unique_ptr<Source>> open_mock_source(const PortRequest& request, Clock& clock) {
  FL_ASSIGN(auto usb, mock::mock_of_target(request.target, false));
  FL_ASSIGN(EnttecProConfig config, config_of(request));
  return EnttecProSource::open(std::move(config), mock::make_mock_connector(std::move(usb), clock), clock);
}

}  // namespace

extern constinit const DriverInfo mock_driver{
    .id = "mock",
    .full_name = "Device models inside this program",
    .usb_ids = {},
    .capabilities = kCanOutput | kCanInput | kKeepsLookAlive,
    .notes =
        "mock:enttec-pro runs the ENTTEC driver without hardware; as a source it plays a slow sine over all slots.",
    .open_sink = open_mock_sink,
    .open_source = open_mock_source,
};

}  // namespace footlight::drivers
