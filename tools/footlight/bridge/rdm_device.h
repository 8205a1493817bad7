// One device in the list of `footlight rdm list`.
#pragma once

#include <string>

namespace footlight::tools {

struct RdmDevice {
  std::string uid;
  std::string manufacturer, model, label, software;  // as reported by the device; may be empty
  std::string category;
  int footprint = 0;      // slots
  int start_address = 0;  // 0: no slots
  int personality = 0, personalities = 0;
  std::string personality_name;
  int sub_devices = 0;
  int sensors = 0;
  bool is_proxy = false, is_proxied = false;
  std::string trouble;  // why the rest is empty
};

}  // namespace footlight::tools
