#include "tools/footlight/preview/ui/file_list.h"

#include <algorithm>
#include <filesystem>
#include <iterator>

#include <fmt/format.h>

#include "fixtures/files/import/text.h"
#include "tools/footlight/preview/ui/name_order.h"
#include "tools/footlight/preview/ui/words.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

struct NameEnd {
  std::string_view end;
  FileKind kind;
};
constexpr NameEnd kEnds[] = {
    {".toml", FileKind::kRig},        {".mvr", FileKind::kRig},         {".qxw", FileKind::kRig},
    {".gdtf", FileKind::kDefinition}, {".qxf", FileKind::kDefinition},  {".json", FileKind::kDefinition},
    {".ies", FileKind::kDefinition},  {".ldt", FileKind::kDefinition},  {".dmxlog", FileKind::kLog},
    {".part", FileKind::kLog},        {".show", FileKind::kLog},        {".osf", FileKind::kLog},
    {".pcap", FileKind::kLog},        {".pcapng", FileKind::kLog},      {".sr", FileKind::kLog},
};

bool is_below(std::string_view path, std::string_view folder) {
  return path.size() > folder.size() && path.starts_with(folder) && path[folder.size()] == '/';
}

}  // namespace

FileKind kind_of_name(std::string_view name) {
  const std::string small = fixtures::lower(name);
  for (const NameEnd& each : kEnds) {
    if (small.size() > each.end.size() && small.ends_with(each.end)) return each.kind;
  }
  return FileKind::kOther;
}

bool fits(FileFilter filter, FileKind kind) {
  if (kind == FileKind::kFolder || filter == FileFilter::kAll) return true;
  switch (filter) {
    case FileFilter::kRigs: return kind == FileKind::kRig;
    case FileFilter::kDefinitions: return kind == FileKind::kDefinition;
    case FileFilter::kLogs: return kind == FileKind::kLog;
    default: return kind != FileKind::kOther;
  }
}

void FileList::clear() {
  entries_.clear();
  keys_.clear();
  small_.clear();
  sorted_.clear();
  shown_.clear();
  words_.clear();
  marked_ = -1;
  marked_name_.clear();
}

bool FileList::shows(std::size_t index) const {
  const FileEntry& entry = entries_[index];
  return (hidden_ || !entry.hidden()) && fits(filter_, entry.kind) && has_words(small_[index], words_);
}

bool FileList::before(std::size_t a, std::size_t b) const {
  const FileEntry& x = entries_[a];
  const FileEntry& y = entries_[b];
  if ((x.kind == FileKind::kFolder) != (y.kind == FileKind::kFolder)) return x.kind == FileKind::kFolder;
  if (column_ == FileColumn::kBytes && x.bytes != y.bytes) return (x.bytes < y.bytes) != descending_;
  if (column_ == FileColumn::kModified && x.modified_s != y.modified_s) {
    return (x.modified_s < y.modified_s) != descending_;
  }
  int order = keys_[a].compare(keys_[b]);
  if (order == 0) order = x.name.compare(y.name);
  return column_ == FileColumn::kName && descending_ ? order > 0 : order < 0;
}

void FileList::add(std::vector<FileEntry> entries) {
  const auto middle = static_cast<std::ptrdiff_t>(sorted_.size());
  for (FileEntry& entry : entries) {
    keys_.push_back(order_key(entry.name));
    small_.push_back(small_letters(entry.name));
    sorted_.push_back(static_cast<std::uint32_t>(entries_.size()));
    entries_.push_back(std::move(entry));
  }
  const auto order = [this](std::uint32_t a, std::uint32_t b) { return before(a, b); };
  std::sort(sorted_.begin() + middle, sorted_.end(), order);
  std::inplace_merge(sorted_.begin(), sorted_.begin() + middle, sorted_.end(), order);
  show();
}

void FileList::show() {
  shown_.clear();
  std::copy_if(sorted_.begin(), sorted_.end(), std::back_inserter(shown_),
               [this](std::uint32_t index) { return shows(index); });
  mark_name(std::string(marked_name_));
}

void FileList::set_filter(FileFilter filter) {
  filter_ = filter;
  show();
}

void FileList::set_hidden(bool shows) {
  hidden_ = shows;
  show();
}

void FileList::set_words(const std::string& words) {
  words_ = small_letters(words);
  marked_name_.clear();
  show();
  if (words_.find_first_not_of(' ') != std::string::npos) mark(shown_.empty() ? -1 : 0);  // Enter opens it
}

void FileList::sort(FileColumn column, bool descending) {
  if (column_ == column && descending_ == descending) return;
  column_ = column;
  descending_ = descending;
  std::sort(sorted_.begin(), sorted_.end(), [this](std::uint32_t a, std::uint32_t b) { return before(a, b); });
  show();
}

void FileList::mark(int row) {
  marked_ = row >= 0 && row < static_cast<int>(shown_.size()) ? row : -1;
  marked_name_ = marked_ >= 0 ? at(static_cast<std::size_t>(marked_)).name : "";
}

void FileList::mark_next(int step) {
  const int last = static_cast<int>(shown_.size()) - 1;
  if (step == 0 || last < 0) return;
  if (marked_ < 0) return mark(step > 0 ? 0 : last);
  mark(std::clamp(marked_ + step, 0, last));
}

void FileList::mark_name(std::string_view name) {
  marked_ = -1;
  marked_name_ = name;
  if (name.empty()) return;
  for (std::size_t row = 0; row < shown_.size(); ++row) {
    if (at(row).name == name) marked_ = static_cast<int>(row);
  }
}

std::vector<std::string> mounted_media(std::string_view mounts) {
  std::vector<std::string> found;
  for (std::size_t at = 0; at < mounts.size();) {
    const std::size_t end = std::min(mounts.find('\n', at), mounts.size());
    std::string_view line = mounts.substr(at, end - at);
    at = end + 1;
    const std::size_t from = line.find(' ');  // behind the device
    if (from == std::string_view::npos) continue;
    line = line.substr(from + 1, line.find(' ', from + 1) - from - 1);
    std::string path;
    for (std::size_t i = 0; i < line.size(); ++i) {  // "\040" is a space
      const bool coded = line[i] == '\\' && i + 3 < line.size() && line[i + 1] >= '0' && line[i + 1] <= '3';
      if (!coded) {
        path += line[i];
        continue;
      }
      path += static_cast<char>((line[i + 1] - '0') * 64 + (line[i + 2] - '0') * 8 + (line[i + 3] - '0'));
      i += 3;
    }
    if (is_below(path, "/media") || is_below(path, "/run/media")) found.push_back(path);
  }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

std::vector<FilePlace> file_places(const std::string& home, const std::string& rig,
                                   const std::vector<std::string>& recent, std::string_view mounts) {
  std::vector<FilePlace> places;
  const auto add = [&](std::string name, const std::string& path) {
    const auto is_it = [&](const FilePlace& one) { return one.path == path; };
    const bool there = std::any_of(places.begin(), places.end(), is_it);
    if (!path.empty() && !there) places.push_back({std::move(name), path});
  };
  add(tr("home"), home);
  if (!rig.empty()) add(tr("this rig"), parent_of(rig));
  for (const std::string& path : recent) {
    const std::string folder = parent_of(path);
    add(fs::path(folder).filename().string(), folder);
  }
  for (const std::string& path : mounted_media(mounts)) add(fs::path(path).filename().string(), path);
  add(tr("all folders"), "/");
  return places;
}

std::string parent_of(const std::string& folder) {
  std::string path = folder;
  while (path.size() > 1 && path.ends_with('/')) path.pop_back();
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return "/";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::string path_from(const std::string& folder, const std::string& text, const std::string& home) {
  fs::path path = fs::path(folder) / text;  // of two absolute ones the second
  if (text == "~" || text.starts_with("~/")) path = fs::path(home) / (text.size() > 2 ? text.substr(2) : "");
  std::string whole = path.lexically_normal().string();
  while (whole.size() > 1 && whole.ends_with('/')) whole.pop_back();
  return whole;
}

std::string file_size_text(std::uint64_t bytes) {
  if (bytes < 1000) return fmt::format("{} B", bytes);
  double value = static_cast<double>(bytes) / 1000;
  constexpr const char* kUnits[] = {"kB", "MB", "GB", "TB"};
  std::size_t unit = 0;
  while (value >= 999.95 && unit + 1 < std::size(kUnits)) {
    value /= 1000;
    ++unit;
  }
  return fmt::format("{:.1f} {}", value, kUnits[unit]);
}

}  // namespace footlight::tools
