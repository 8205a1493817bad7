// The files of a folder as a list that is sorted and searched, and the places that it begins from. Plain data; what
// reads the folder is folder_reader.h.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace footlight::tools {

// By the end of the name; what is in a file is looked at when it is opened.
enum class FileKind { kFolder, kRig, kDefinition, kLog, kOther };
[[nodiscard]] FileKind kind_of_name(std::string_view name);

struct FileEntry {
  std::string name;  // bytes as the file system has them
  FileKind kind = FileKind::kOther;
  std::uint64_t bytes = 0;      // of a file
  std::int64_t modified_s = 0;  // Unix time; 0: not known
  [[nodiscard]] bool hidden() const { return name.starts_with('.'); }
};

enum class FileFilter { kOpens, kRigs, kDefinitions, kLogs, kAll };
inline constexpr std::array kFileFilters{FileFilter::kOpens, FileFilter::kRigs, FileFilter::kDefinitions,
                                         FileFilter::kLogs, FileFilter::kAll};
[[nodiscard]] bool fits(FileFilter filter, FileKind kind);

enum class FileColumn { kName, kBytes, kModified };

// Folders come first, in each order. Numbers in names count as numbers.
class FileList {
 public:
  void clear();
  // Some of the folder's entries, in any order. The time is that of one pass through the list: docs/window.md.
  void add(std::vector<FileEntry> entries);

  void set_filter(FileFilter filter);
  void set_hidden(bool shows);
  // Entries whose names have all of these words, in any case.
  void set_words(const std::string& words);
  void sort(FileColumn column, bool descending);
  [[nodiscard]] FileFilter filter() const { return filter_; }
  [[nodiscard]] bool shows_hidden() const { return hidden_; }

  [[nodiscard]] std::size_t size() const { return entries_.size(); }
  // What is shown, in its order.
  [[nodiscard]] std::size_t shown() const { return shown_.size(); }
  [[nodiscard]] const FileEntry& at(std::size_t row) const { return entries_[shown_[row]]; }

  // The marked row; -1: none. It stays on its entry while others come.
  [[nodiscard]] int marked() const { return marked_; }
  void mark(int row);
  // By so many rows, within the list; from none to the first or the last one.
  void mark_next(int step);
  // The entry of this name, if it is shown.
  void mark_name(std::string_view name);

 private:
  [[nodiscard]] bool shows(std::size_t index) const;
  [[nodiscard]] bool before(std::size_t a, std::size_t b) const;
  void show();

  std::vector<FileEntry> entries_;
  std::vector<std::string> keys_;      // order_key() of each
  std::vector<std::string> small_;     // its name in small letters
  std::vector<std::uint32_t> sorted_;  // all of them
  std::vector<std::uint32_t> shown_;   // those of sorted_ that are shown
  FileFilter filter_ = FileFilter::kOpens;
  bool hidden_ = false;
  std::string words_;  // small letters
  FileColumn column_ = FileColumn::kName;
  bool descending_ = false;
  int marked_ = -1;
  std::string marked_name_;  // what is marked, or is to be once it comes
};

// A folder that files are often in.
struct FilePlace {
  std::string name;
  std::string path;
  bool operator==(const FilePlace&) const = default;
};
// The home folder, that of the rig, those of recent rigs, and mounted media; each folder once, empty ones left out.
// mounts: the text of /proc/self/mounts.
[[nodiscard]] std::vector<FilePlace> file_places(const std::string& home, const std::string& rig,
                                                 const std::vector<std::string>& recent, std::string_view mounts);
// Mount points below /media and /run/media.
[[nodiscard]] std::vector<std::string> mounted_media(std::string_view mounts);

// The folder above, without its last slash; "/" stays.
[[nodiscard]] std::string parent_of(const std::string& folder);
// What a text leads to that is typed in a folder: "~/shows", "/media/usb", "../b"; else a name in it.
[[nodiscard]] std::string path_from(const std::string& folder, const std::string& text, const std::string& home);
// "1.2 MB", "340 B".
[[nodiscard]] std::string file_size_text(std::uint64_t bytes);

}  // namespace footlight::tools
