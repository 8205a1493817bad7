// A DMX line with RDM responders on it, byte for byte: what a controller hears when it asks. Several that answer at
// once talk over each other.
//
// Messages are put together with code of its own, not with the driver's (drivers/rdm): a mistake in one does not hide
// the same mistake in the other.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "drivers/mock/usb_model.h"

namespace footlight::drivers::mock {

struct RdmPersonality {
  std::string name;
  std::uint16_t footprint = 0;
};

struct RdmSensor {
  std::string name;
  std::uint8_t type = 0;  // temperature
  std::uint8_t unit = 1;  // degrees Celsius
  std::int16_t value = 0;
};

class RdmResponderModel {
 public:
  // --- What it is.
  std::uint64_t uid = 0x7FF0'0000'0001;  // 48 bits
  std::string manufacturer = "Footlight";
  std::string model = "Model of a spot";
  std::string version = "1.0";
  std::uint16_t model_id = 1, category = 0x0102;
  std::uint32_t software = 0x0001'0000;
  std::vector<RdmPersonality> personalities = {{"Basic", 8}, {"Extended", 16}};
  std::vector<RdmSensor> sensors = {{"Lamp", 0, 1, 42}};
  std::uint16_t control_field = 0;  // of the answer to DISC_MUTE: 1 proxy, 2 sub-devices, 4 boot loader, 8 proxied

  // --- What can be set, as it is now.
  std::string label = "Spot";
  std::uint8_t personality = 1;
  std::uint16_t start_address = 1;
  bool identifies = false;
  std::uint8_t fan_percent = 50;  // parameter 0x8001 of the maker's own
  bool muted = false;

  // --- How it fails.
  bool never_confirms_mute = false;
  bool stays_unmuted = false;  // confirms, and answers discovery all the same
  bool label_is_locked = false;
  int ignores = 0;                  // so many requests from now on
  int damages = 0;                  // the next so many answers have a wrong checksum
  std::size_t preamble = 7;         // octets of FE before its answer to discovery
  std::uint16_t asks_for_time = 0;  // ACK_TIMER for every get but of its queue, in units of 100 ms; 0: answers at once
  bool keeps_queue = true;          // false: forgets what it promised, and refuses QUEUED_MESSAGE
  std::size_t answer_size_max = 231;  // longer ones come in parts (ACK_OVERFLOW)

  // --- What it saw.
  std::uint64_t request_count = 0;

  // What it puts on the line; empty: nothing.
  Bytes answer(std::span<const std::uint8_t> request);

 private:
  struct Reply {
    std::uint8_t type = 0;  // 0 ack, 2 nack
    Bytes data;
  };
  Reply act(bool set, unsigned parameter, std::span<const std::uint8_t> data);
  Bytes respond(std::span<const std::uint8_t> request, unsigned parameter, std::uint8_t type, const Bytes& data,
                unsigned command);

  std::map<unsigned, Bytes> rest_;  // by parameter: parts that were not given yet
  struct Queued {
    unsigned parameter = 0, command = 0;
    Reply reply;
  };
  std::deque<Queued> queue_;
};

class RdmLineModel {
 public:
  std::vector<RdmResponderModel> responders;
  // What is heard when this request goes over the line.
  Bytes answer(std::span<const std::uint8_t> request);
};

// Three responders, as `mock:enttec-pro` has them: two spots and a dimmer behind a proxy.
[[nodiscard]] RdmLineModel example_rdm_line();

}  // namespace footlight::drivers::mock
