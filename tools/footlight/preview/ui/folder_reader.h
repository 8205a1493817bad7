// Reads the entries of a folder on a thread, in parts, so that a folder of 100,000 files or on a slow network does not
// hold the window up.
//
// The thread shares nothing with this but what it has read, and nobody waits for it: a folder that never answers is
// left behind, with its thread.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/core/result.h"
#include "tools/footlight/preview/ui/file_list.h"

namespace footlight::tools {

class FolderReader {
 public:
  static constexpr std::size_t kPartMax = 4096;  // entries of one take()

  // Begins at once.
  explicit FolderReader(const std::string& folder);
  ~FolderReader();
  FolderReader(const FolderReader&) = delete;
  FolderReader& operator=(const FolderReader&) = delete;

  [[nodiscard]] const std::string& folder() const { return folder_; }
  // What was read since the last call, at most kPartMax: folders and files, also through links; no pipes and devices.
  [[nodiscard]] std::vector<FileEntry> take();
  // All of it was taken, or there is an error.
  [[nodiscard]] bool ended() const;
  // Why the folder, or the rest of it, cannot be read: names the folder.
  [[nodiscard]] std::optional<Error> error() const;

 private:
  struct Shared;
  std::string folder_;
  std::shared_ptr<Shared> shared_;
};

}  // namespace footlight::tools
