// The reports of a Velleman K8062 (kit) or VM116 (built): bytes only, no I/O, no time.
//
// A snapshot is sent as a row of output reports. Runs of zeros are counted instead of sent, since a report of the
// original firmware is 8 bytes and a low-speed device takes one every 10 ms:
//
//   4 zeros+1 slots...   starts a snapshot; `zeros` slots of 0 come before the slots (+1: the start code)
//   5 zeros slots...     continues, in the same way
//   2 slots...           continues, with slots only
//   3 slot               continues, with one slot; the rest of the report is ignored
//   6 count slots...     continues, with `count` slots: 64-byte reports only
//
// A report of type 2, 4 or 5 always carries all the slots that fit, and none may extend past slot 512.
// Sources: k8062forlinux.sourceforge.net/usbproto.php (types 2 to 5); VellemanK8062.cpp of OLA (64-byte reports, type
// 6, the longest run of zeros); wiki.openlighting.org, "Velleman K8062 Upgrade" (10 ms a report).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sim/core/dmx.h"

namespace footlight::drivers {

inline constexpr std::size_t kVellemanReportSize = 8;
inline constexpr std::size_t kVellemanUpgradedReportSize = 64;  // of the replacement firmware
// The most reports that a snapshot may need: 8-byte reports, no two zeros in a row except at the end of a report.
inline constexpr std::size_t kVellemanReportCountMax = 78;

// A snapshot as reports for the output endpoint, without report numbers.
class VellemanReports {
 public:
  // report_size: kVellemanReportSize or kVellemanUpgradedReportSize.
  VellemanReports(std::span<const std::uint8_t, kSlotCountMax> snapshot, std::size_t report_size);
  [[nodiscard]] std::size_t count() const { return count_; }
  [[nodiscard]] std::span<const std::uint8_t> operator[](std::size_t i) const {
    return std::span(bytes_).subspan(i * stride_, stride_);
  }

 private:
  std::span<std::uint8_t> add(std::uint8_t type);

  const std::size_t stride_;
  std::size_t count_ = 0;
  std::array<std::uint8_t, kVellemanReportCountMax * kVellemanReportSize> bytes_{};
};

}  // namespace footlight::drivers
