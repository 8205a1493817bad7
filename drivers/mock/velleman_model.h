// A model of a Velleman K8062: the reports, and the line that its processor makes of them.
//
// A whole snapshot, 512 slots after a start, is sent on line 0 once; the device repeats nothing itself. It counts slots
// with its own code, report by report, and does not use the driver's encoder.
#pragma once

#include <array>
#include <cstdint>

#include "drivers/mock/hid_model.h"

namespace footlight::drivers::mock {

class VellemanModel final : public HidModel {
 public:
  VellemanModel() {
    manufacturer = "Velleman";
    product = "USB DMX Interface";
  }
  // --- Settings; may be changed before it is plugged in.
  bool upgraded = false;  // the replacement firmware: reports of 64 bytes

  // --- Observed; read only.
  std::uint64_t report_count = 0;
  std::uint64_t broken_count = 0;  // reports of wrong size, unknown type, before a start, or past slot 512
  std::uint64_t cut_count = 0;     // snapshots cut short by another start

  void power_on() override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;

 protected:
  Shape shape() const override;

 private:
  [[nodiscard]] bool take(std::span<const std::uint8_t> slots, std::size_t zeros);

  std::array<std::uint8_t, 512> coming_{};
  std::size_t next_ = 512;  // the next slot; 512: none expected
};

}  // namespace footlight::drivers::mock
