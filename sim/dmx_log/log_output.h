// Where a LogWriter's bytes go: a file under a .part name, or memory.
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "sim/core/result.h"
#include "sim/dmx_log/bytes.h"
#include "sim/dmx_log/dmx_log.h"

namespace footlight::dmx_log {

class LogOutput {
 public:
  virtual ~LogOutput() = default;
  // All of it, or nothing: after a failure the output is as long as before.
  virtual Status write(std::span<const std::uint8_t> bytes) = 0;
  virtual Status sync() = 0;
  // Gives the result its final name.
  virtual Status finish() = 0;
  // Removes what was written. Nothing may be written after it.
  virtual void discard() = 0;
  [[nodiscard]] virtual const std::string& path() const = 0;
};

[[nodiscard]] Result<std::unique_ptr<LogOutput>> open_file_output(const std::string& path, bool overwrite);

// Keeps the bytes in `bytes`, which must outlive it.
[[nodiscard]] std::unique_ptr<LogOutput> memory_output(Bytes& bytes, const std::string& name);

// A writer on such an output.
[[nodiscard]] Result<LogWriter> make_writer(std::unique_ptr<LogOutput> output, const LogWriterOptions& options);

// kNotFound, kPermission or kIo with the system's words, for an errno.
[[nodiscard]] tl::unexpected<Error> fail_errno(int error_number, const std::string& path, const std::string& doing);

// The same for a file that is to be read. Where only the .part file of a recording exists, the message names it and how
// to use it.
[[nodiscard]] tl::unexpected<Error> fail_open(int error_number, const std::string& path);

}  // namespace footlight::dmx_log
