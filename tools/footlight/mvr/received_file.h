// A rig that another station sends: beside its target until it is whole.
#pragma once

#include <cstdint>
#include <cstdio>
#include <span>
#include <string>

#include "drivers/net/mvr_xchange_station.h"
#include "sim/core/result.h"

namespace footlight::tools {

class ReceivedFile final : public drivers::MvrFileSink {
 public:
  struct Options {
    bool overwrite = false;  // replaces the file at `path`; else a file that is there when this one is whole stays
    bool shows = false;      // how far it is, on standard error if this is a terminal
  };
  ReceivedFile(std::string path, const Options& options);
  // Removes what was not finished.
  ~ReceivedFile() override;
  ReceivedFile(const ReceivedFile&) = delete;
  ReceivedFile& operator=(const ReceivedFile&) = delete;

  // Errors (kIo): the folder is missing or may not be written.
  [[nodiscard]] Status open();
  Status write(std::span<const std::uint8_t> bytes, std::uint64_t total_bytes) override;
  // Reads it as a rig and gives it its name. Returns a line about the rig.
  [[nodiscard]] Result<std::string> finish();
  [[nodiscard]] std::uint64_t bytes() const { return bytes_; }

 private:
  [[nodiscard]] tl::unexpected<Error> failed() const;
  [[nodiscard]] Status take_name();

  const std::string path_;
  const std::string part_;  // ends in ".mvr", so that the reader expects one
  const bool overwrite_;
  const bool shows_;
  std::FILE* file_ = nullptr;
  bool part_exists_ = false;
  std::uint64_t bytes_ = 0;
  int percent_ = -1;
};

}  // namespace footlight::tools
