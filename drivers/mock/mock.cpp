// The driver row for the models in drivers/mock/: `mock:enttec-pro` and all others.
#include "drivers/driver.h"

namespace footlight::drivers {

extern constinit const DriverInfo mock_driver{
    .id = "mock",
    .full_name = "Device models inside this program",
    .usb_ids = {},
    .capabilities = kCanOutput | kCanInput | kKeepsSnapshotAlive,
    .notes = "mock: with a driver's id runs that driver without hardware; as a source it plays a slow sine.",
};

}  // namespace footlight::drivers
