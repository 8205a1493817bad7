// Replaces libgpiod_chip.cpp in builds without libgpiod.
#include "drivers/gpio/gpio_chip.h"

namespace footlight::drivers {
namespace {

class NoChips final : public GpioChips {
 public:
  Result<std::unique_ptr<GpioLine>> request(const GpioLineRequest& request) override {
    return fail(ErrorCode::kUnsupported,
                "{}/{}: this build has no GPIO; 'sudo apt install libgpiod-dev', then build again with "
                "-DFOOTLIGHT_GPIO=ON; 'gpio:mock/2=1.25' runs without",
                request.chip, request.line);
  }
};

}  // namespace

std::shared_ptr<GpioChips> make_gpio_chips() { return std::make_shared<NoChips>(); }
bool built_with_gpio() { return false; }

}  // namespace footlight::drivers
