// A rig that is edited, and the rig file that it is saved to.
//
// A rig of another program is saved as "show.toml" beside "show.mvr"; the imported file is never written. A rig file is
// saved to itself, if nobody else changed it since it was read. What is written is whole: it is renamed into place, and
// definitions are in the folder before the rig file names them. Killing the program loses no file.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "fixtures/files/import/import_rig.h"
#include "sim/core/result.h"

namespace footlight::tools {

// What tells one content of a file from another: its size and a sum of 64 bits (FNV-1a).
struct FileMark {
  std::uint64_t size = 0;
  std::uint64_t sum = 0;
  bool operator==(const FileMark&) const = default;
};
// Nothing: there is no such file, or it cannot be read.
[[nodiscard]] std::optional<FileMark> mark_of_file(const std::string& path);

// Whether a rig file can have this path: kBadInput for a name with nothing before its ending, a folder, a pipe and a
// device. Folders above are not looked at.
[[nodiscard]] Status check_rig_target(const std::string& path);

struct SaveReport {
  std::string path;
  std::string old;  // where the file from before is kept; empty: it was not kept now
  int shared = 0;   // fixtures that share slots and are marked so in the file
};

class RigFile {
 public:
  // Reads a rig of any format. `library` and `go_on` as for fixtures::import_rig().
  [[nodiscard]] static Result<RigFile> open(const std::string& path, const fixtures::Library* library,
                                            fixtures::Diagnostics& diagnostics, const fixtures::GoOn& go_on = {});
  // A rig that is in no file: saved under this name, if there is no such file.
  [[nodiscard]] static RigFile made(fixtures::ImportedRig imported, const std::string& target);
  // A rig that was read from an automatic copy of another file (autosave.h).
  [[nodiscard]] static RigFile recovered(fixtures::ImportedRig imported, const std::string& path,
                                         const std::string& target, const std::optional<FileMark>& known);

  [[nodiscard]] const fixtures::ImportedRig& imported() const { return imported_; }
  [[nodiscard]] fixtures::ImportedRig& imported() { return imported_; }
  [[nodiscard]] const fixtures::Rig& rig() const { return imported_.rig; }
  [[nodiscard]] fixtures::Rig& rig() { return imported_.rig; }
  [[nodiscard]] const std::string& path() const { return path_; }                // that it was read from; empty: none
  [[nodiscard]] const std::string& target() const { return target_; }            // that save() writes
  [[nodiscard]] const std::optional<FileMark>& known() const { return known_; }  // of the target

  // Writes the rig. Fixtures that share slots get shares_address in the file, so that it can be read again. The first
  // save over a file keeps it as "show.toml~", if there is none or if the file has comments, which are lost.
  // Permissions stay. Locks the folder meanwhile; waits for another program that saves in it, at most 1 s.
  // Errors: the target is a link, read-only, or was made or changed by others; the folder is locked for longer; the
  // text could not be read as a rig; export_rig_toml().
  [[nodiscard]] Result<SaveReport> save();
  // The same to another file, which is that of the rig from then on; after an error it is the one from before.
  // replaces: the user knows of the file that is there, which is kept as save() does; else one is an error.
  [[nodiscard]] Result<SaveReport> save_as(const std::string& path, bool replaces);

 private:
  RigFile() = default;

  fixtures::ImportedRig imported_;
  std::string path_;
  std::string target_;
  std::optional<FileMark> known_;  // nothing: the target did not exist
  bool saved_ = false;
};

enum class RigFiles {
  kWrite,    // definitions and meshes are written, or are there already
  kThere,    // they are there from the last time
  kReplace,  // they are written, also over other files of the folder
};
// Writes a rig as RigFile::save() does, to any path: nothing is kept, and `path` is replaced.
[[nodiscard]] Result<SaveReport> write_rig(fixtures::ImportedRig& imported, const std::string& path,
                                           RigFiles files = RigFiles::kWrite);

}  // namespace footlight::tools
