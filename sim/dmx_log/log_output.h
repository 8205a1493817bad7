// The output of a LogWriter: a file under a .part name, or memory.
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
  // Writes all bytes or none: after a failure the output is as long as before.
  virtual Status write(std::span<const std::uint8_t> bytes) = 0;
  virtual Status sync() = 0;
  // Gives the result its final name.
  virtual Status finish() = 0;
  // Removes what was written. write() must not be called after it.
  virtual void discard() = 0;
  [[nodiscard]] virtual const std::string& path() const = 0;
};

[[nodiscard]] Result<std::unique_ptr<LogOutput>> open_file_output(const std::string& path, bool overwrite);

// Appends to `bytes`, which must outlive it.
[[nodiscard]] std::unique_ptr<LogOutput> memory_output(Bytes& bytes, const std::string& name);

// A writer to this output.
[[nodiscard]] Result<LogWriter> make_writer(std::unique_ptr<LogOutput> output, const LogWriterOptions& options);

// kNotFound, kPermission or kIo with the system's message, for an errno.
[[nodiscard]] tl::unexpected<Error> fail_errno(int error_number, const std::string& path, const std::string& doing);

// As fail_errno(), for a file to be read. If only the .part file of a recording exists, the message names it and
// explains how to use it.
[[nodiscard]] tl::unexpected<Error> fail_open(int error_number, const std::string& path);

}  // namespace footlight::dmx_log
