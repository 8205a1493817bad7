// An MVR file that is offered to other stations, and offered again when it changes.
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "drivers/net/mvr_xchange_station.h"
#include "drivers/net/net.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"

namespace footlight::tools {

[[nodiscard]] std::string uuid_text(const drivers::Cid& uuid);  // "1b4e28ba-2fa1-81d2-883f-0016d3cca427"

// Fails unless the file at `path` is an MVR file that can be read as a rig; messages call it `shown`. Returns a line
// about the rig: "24 fixtures, 3 assumptions".
[[nodiscard]] Result<std::string> check_mvr(const std::string& path, const std::string& shown);

class SharedFile {
 public:
  struct Revision {
    drivers::MvrCommit commit;  // its UUID is a digest of the content, so that the same file is the same revision
    drivers::MvrFileBytes bytes;
  };
  // Reads the file, at most 2 GiB, and checks it. Fails if it changes meanwhile.
  [[nodiscard]] static Result<SharedFile> open(const std::string& path, const std::string& comment);
  [[nodiscard]] const Revision& first() const { return first_; }
  // A new revision, if the file has another size or time than before and kept both for a second. An error is returned
  // once for each change; what is offered stays. A file that changes while it is read is read again. Asks the file
  // system twice a second at most.
  [[nodiscard]] Result<std::optional<Revision>> poll(TimeNs now_ns);

 private:
  struct Mark {
    std::uintmax_t size = 0;
    std::filesystem::file_time_type time;
    bool operator==(const Mark&) const = default;
  };
  SharedFile() = default;
  [[nodiscard]] static std::optional<Mark> mark_of(const std::string& path);
  [[nodiscard]] Result<Revision> read() const;
  // Nothing: the file changed, so that the content that was checked may be another one than what was read.
  [[nodiscard]] Result<std::optional<Revision>> read_unchanged();

  std::string path_;
  std::string comment_;
  Revision first_;
  std::string last_uuid_;
  std::optional<Mark> known_;    // of what is offered, or was refused
  std::optional<Mark> changed_;  // seen since, and when
  TimeNs changed_ns_ = 0;
  TimeNs next_ns_ = 0;
};

}  // namespace footlight::tools
