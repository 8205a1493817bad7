// Files that a test holds in memory.
#pragma once

#include <algorithm>
#include <cstring>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "fixtures/files.h"

namespace footlight::testing {

class MemoryFiles final : public fixtures::Files {
 public:
  explicit MemoryFiles(std::map<std::string, std::string, std::less<>> files) : files_(std::move(files)) {
    for (const auto& [name, content] : files_) names_.push_back(name);
  }
  [[nodiscard]] const std::vector<std::string>& names() const override { return names_; }
  [[nodiscard]] Result<fixtures::Bytes> read(std::string_view name, std::uint64_t size_max_bytes) const override {
    const auto at = files_.find(name);
    if (at == files_.end()) return fail(ErrorCode::kNotFound, "{}: not there", shown_name(name));
    if (at->second.size() > size_max_bytes) return fail(ErrorCode::kBadInput, "{}: too large", shown_name(name));
    const auto* first = reinterpret_cast<const std::byte*>(at->second.data());
    return fixtures::Bytes(first, first + at->second.size());
  }
  [[nodiscard]] std::string shown_name(std::string_view name) const override { return "memory:" + std::string(name); }

 private:
  std::map<std::string, std::string, std::less<>> files_;
  std::vector<std::string> names_;
};

}  // namespace footlight::testing
