// Automatic copies of edited rigs, for recovery after a crash.
//
// A copy is a rig file "rig.toml" with its folder "rig_files" and a file "about.toml" (which rig it is of), in a folder
// of its own. It is written by a thread, some seconds after a change, and removed when the rig is saved. Each session
// locks its folder; the lock ends with the program, however it ends. A copy whose folder is not locked is what a
// session lost.
#pragma once

#include <cstdint>
#include <future>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/result.h"
#include "tools/footlight/edit/rig_file.h"

namespace footlight::tools {

// A folder that only this session uses, until the object is destroyed or the program ends.
class FolderClaim {
 public:
  // Nothing: another session has it, or it cannot be made.
  [[nodiscard]] static std::optional<FolderClaim> take(const std::string& folder);
  FolderClaim(FolderClaim&& other) noexcept;
  FolderClaim& operator=(FolderClaim&& other) noexcept;
  FolderClaim(const FolderClaim&) = delete;
  FolderClaim& operator=(const FolderClaim&) = delete;
  ~FolderClaim();
  [[nodiscard]] const std::string& folder() const { return folder_; }
  // Removes the folder with its files.
  void remove();
  // Others may claim it from now on.
  void release();

 private:
  FolderClaim(std::string folder, int fd) : folder_(std::move(folder)), fd_(fd) {}
  std::string folder_;
  int fd_ = -1;
};

// What another session lost.
struct LostEdits {
  FolderClaim claim;
  std::int64_t written_s = 0;  // Unix time of the copy
  std::string path;            // of the rig, absolute
  std::string target;
  std::optional<FileMark> known;
  bool older = false;   // the target was saved or changed since; the copy cannot be saved over it
  bool others = false;  // the target is a file that the session had not opened; the copy cannot be saved over it
};
// The newest copy of this rig. `state`: state_folder(); empty: there is none.
[[nodiscard]] std::optional<LostEdits> find_lost_edits(const std::string& state, const std::string& path);
// Reads it. The rig is saved to where the lost session would have saved it.
[[nodiscard]] Result<RigFile> open_lost_edits(const LostEdits& lost);

// Removes the copy, unless another session has its folder or it is another copy by now.
void discard_lost_edits(const LostEdits& lost);

class Autosave {
 public:
  // From a change to the start of its copy. A copy of 10,000 fixtures takes at most 4 s of CPU time in a build with
  // sanitizers ('rig edit -o' of them, less 'rig edit' without -o), with reading it again. The first one also takes the
  // time to copy the definitions.
  static constexpr DurationNs kAfterNs = 3 * kNsPerS;

  // `file` outlives this. No folder is made before the first copy. `claim`: the folder of what was recovered; its copy
  // stays until it is replaced or removed.
  Autosave(const RigFile& file, std::string state, std::optional<FolderClaim> claim = {});
  ~Autosave();  // waits for the thread; the copy stays
  Autosave(const Autosave&) = delete;
  Autosave& operator=(const Autosave&) = delete;

  // Called for every picture. `revision` differs for different contents of the rig. `unsaved`: the rig is not as in its
  // file. Returns why a copy could not be written, once for each reason.
  [[nodiscard]] std::optional<Error> step(TimeNs now_ns, std::uint64_t revision, bool unsaved);
  // Writes the copy now if it is not the newest, and waits for it: at the end of the program by a signal.
  [[nodiscard]] Status write_now(std::uint64_t revision);
  // Removes the copy: the rig was saved, or its edits are not wanted.
  void forget();

 private:
  struct Copy;
  Status begin(std::uint64_t revision);
  Status claim_folder();
  [[nodiscard]] Status take_result();

  const RigFile& file_;
  std::string state_;
  std::optional<FolderClaim> claim_;
  std::unique_ptr<Copy> copy_;            // what the thread writes from
  std::future<Status> writing_;           // valid: a copy is being written
  std::optional<std::uint64_t> written_;  // revision of the copy
  std::optional<std::uint64_t> begun_;    // revision that is being written
  std::optional<TimeNs> changed_ns_;      // of the first change that is not in a copy
  std::string told_;                      // the last message
};

}  // namespace footlight::tools
