// A model of a DMX line with RDM responders, byte for byte: what a controller receives. Simultaneous answers of several
// responders collide.
//
// Messages are built by its own code, not the driver's (drivers/rdm): a mistake in one does not hide the same mistake
// in the other.
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
  // --- Settings.
  std::uint64_t uid = 0x7FF0'0000'0001;  // 48 bits
  std::string manufacturer = "Footlight";
  std::string model = "Model of a spot";
  std::string version = "1.0";
  std::uint16_t model_id = 1, category = 0x0102;
  std::uint32_t software = 0x0001'0000;
  std::vector<RdmPersonality> personalities = {{"Basic", 8}, {"Extended", 16}};
  std::vector<RdmSensor> sensors = {{"Lamp", 0, 1, 42}};
  std::uint16_t control_field = 0;  // of the answer to DISC_MUTE: 1 proxy, 2 sub-devices, 4 boot loader, 8 proxied

  // --- Settable parameters, current values.
  std::string label = "Spot";
  std::uint8_t personality = 1;
  std::uint16_t start_address = 1;
  bool identifies = false;
  std::uint8_t fan_percent = 50;  // parameter 0x8001, manufacturer-specific
  bool muted = false;

  // --- Faults.
  bool never_confirms_mute = false;
  bool stays_unmuted = false;  // confirms the mute but still answers discovery
  bool label_is_locked = false;
  int ignores = 0;                    // number of next requests to ignore
  int damages = 0;                    // number of next answers with a wrong checksum
  std::size_t preamble = 7;           // octets of FE before its answer to discovery
  std::uint16_t ack_timer_units = 0;  // ACK_TIMER for every get except of its queue, in units of 100 ms; 0: answers at
                                      // once
  bool keeps_queue = true;            // false: drops its queued answers and refuses QUEUED_MESSAGE
  std::size_t answer_size_max = 231;  // longer answers come in parts (ACK_OVERFLOW)

  // --- Observed.
  std::uint64_t request_count = 0;

  // Its answer on the line; empty: none.
  Bytes answer(std::span<const std::uint8_t> request);

 private:
  struct Reply {
    std::uint8_t type = 0;  // 0 ack, 2 nack
    Bytes data;
  };
  Reply act(bool set, unsigned parameter, std::span<const std::uint8_t> data);
  Bytes respond(std::span<const std::uint8_t> request, unsigned parameter, std::uint8_t type, const Bytes& data,
                unsigned command);

  std::map<unsigned, Bytes> rest_;  // by parameter: parts not sent yet
  struct Queued {
    unsigned parameter = 0, command = 0;
    Reply reply;
  };
  std::deque<Queued> queue_;
};

class RdmLineModel {
 public:
  std::vector<RdmResponderModel> responders;
  // The bytes on the line after this request.
  Bytes answer(std::span<const std::uint8_t> request);
};

// Three responders, as on `mock:enttec-pro`: two spots and a dimmer behind a proxy.
[[nodiscard]] RdmLineModel example_rdm_line();

}  // namespace footlight::drivers::mock
