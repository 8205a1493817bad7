#include "drivers/usb_match.h"

#include <algorithm>

namespace footlight::drivers {
namespace {

constexpr char lower(char c) { return c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c; }

bool begins_with(std::string_view text, std::string_view beginning) {
  return text.size() >= beginning.size() && std::equal(beginning.begin(), beginning.end(), text.begin(),
                                                       [](char a, char b) { return lower(a) == lower(b); });
}

}  // namespace

UsbMatch match_usb_device(std::uint16_t usb_vendor, std::uint16_t usb_product, std::string_view manufacturer,
                          std::string_view product) {
  UsbMatch match;
  for (const DriverInfo* driver : drivers()) {
    for (const UsbModelId& model : driver->usb_ids) {
      if (model.vendor != usb_vendor || model.product != usb_product) continue;
      match.ids_are_known = true;
      // These devices cannot be distinguished from many others: the user must name them.
      const bool has_words = !model.manufacturer_text.empty() || !model.product_text.empty();
      if ((model.quirks & kQuirkGenericUsbIds) != 0 && !has_words) continue;
      if (!begins_with(manufacturer, model.manufacturer_text) || !begins_with(product, model.product_text)) continue;
      match.driver = driver;
      match.model = &model;
      return match;
    }
  }
  return match;
}

}  // namespace footlight::drivers
