// Opens what vrsl endpoints name: targets of pictures, and ports that encode for them or decode them.
#pragma once

#include <memory>

#include "drivers/vrsl/picture_port.h"
#include "sim/core/endpoint.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"

namespace footlight::tools {

// By the target's name: "*.png" are files. Errors: kBadInput for a name or an option that nothing takes, and those of
// the target; the message begins with the endpoint. Outputs that are files have the option overwrite=yes: they may be
// replaced.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_picture_output(const drivers::PictureTarget& target);
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_picture_input(const drivers::PictureTarget& target);

// For endpoints of kind kPicture. overwrite: files may be replaced, as with the option overwrite=yes.
[[nodiscard]] Result<std::unique_ptr<Sink>> open_picture_sink(const Endpoint& endpoint, bool overwrite);
[[nodiscard]] Result<std::unique_ptr<Source>> open_picture_source(const Endpoint& endpoint);

}  // namespace footlight::tools
