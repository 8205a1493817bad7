// Reads the samples of a sigrok capture (.sr): a zip with the text "metadata" and the samples in one or more files.
// Streamed: memory does not grow with the capture, nor with the sizes that the zip declares.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/capture/sigrok_metadata.h"
#include "sim/core/result.h"

namespace footlight::drivers {

// Reading stops here: 12 minutes at 24 MHz.
inline constexpr std::uint64_t kSigrokSampleBytesMax = std::uint64_t{16} << 30;

class SigrokFile {
 public:
  // kBadInput if it is not a logic capture; the message names what is missing.
  [[nodiscard]] static Result<SigrokFile> open(const std::string& path);
  // A capture in memory, which must outlive it; `name` replaces the path in messages.
  [[nodiscard]] static Result<SigrokFile> open_bytes(std::span<const std::uint8_t> bytes, const std::string& name);
  SigrokFile(SigrokFile&&) noexcept;
  ~SigrokFile();

  [[nodiscard]] const SigrokMetadata& metadata() const;
  // The next whole samples; empty at the end, or if the file is damaged. Valid until the next call.
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
