// The samples of a sigrok capture (.sr), a zip with the text "metadata" and the samples in one file or many, streamed:
// memory does not grow with the capture, nor with what a zip claims of itself.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/capture/sigrok_metadata.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// Samples beyond this are not read: 12 minutes at 24 MHz.
inline constexpr std::uint64_t kSigrokSampleBytesMax = std::uint64_t{16} << 30;

class SigrokFile {
 public:
  // kBadInput where it is no capture of logic; the message says what is missing.
  [[nodiscard]] static Result<SigrokFile> open(const std::string& path);
  // A capture in memory, which has to outlive it; `name` stands for the path in messages.
  [[nodiscard]] static Result<SigrokFile> open_bytes(std::span<const std::uint8_t> bytes, const std::string& name);
  SigrokFile(SigrokFile&&) noexcept;
  ~SigrokFile();

  [[nodiscard]] const SigrokMetadata& metadata() const;
  // The next samples, whole ones; empty at the end, or where the file is broken. Valid until the next call.
  [[nodiscard]] std::span<const std::uint8_t> read();
  void rewind();
  // Why reading ended early; empty: it did not.
  [[nodiscard]] const std::string& trouble() const;

 private:
  struct Impl;
  explicit SigrokFile(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace footlight::drivers
