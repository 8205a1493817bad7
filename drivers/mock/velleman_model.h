// A Velleman K8062, modelled from its host's side: the reports, and the line that its processor makes of them.
//
// A whole look, 512 slots after a start, leaves on line 0, once: it repeats nothing by itself. It counts slots with
// code of its own, report by report as they come, and not with the driver's encoder.
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
  // --- What it is; free to change before it is plugged in.
  bool upgraded = false;  // the replacement firmware: reports of 64 bytes

  // --- What it saw; only to be read.
  std::uint64_t report_count = 0;
  std::uint64_t broken_count = 0;  // reports of the wrong size, of no type, before a start, or past slot 512
  std::uint64_t cut_count = 0;     // looks that another start ended

  void power_on() override;
  void data_out(std::uint8_t endpoint, std::span<const std::uint8_t> bytes) override;

 protected:
  Shape shape() const override;

 private:
  [[nodiscard]] bool take(std::span<const std::uint8_t> slots, std::size_t zeros);

  std::array<std::uint8_t, 512> coming_{};
  std::size_t next_ = 512;  // slot that comes next; 512: none is awaited
};

}  // namespace footlight::drivers::mock
