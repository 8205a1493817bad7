// Stations and files for tests of MVR-xchange.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include <poll.h>

#include "drivers/net/mvr_xchange_group.h"
#include "tests/support/must.h"

namespace footlight::testing {

inline constexpr const char* kDeskUuid = "4aa291a1-1a62-45fe-aabc-e90e5e2399a8";
inline constexpr const char* kViewUuid = "a7669ff9-bd61-4486-aea6-c190f8ba6b8c";
inline constexpr const char* kOldFile = "00000000-0000-4000-8000-000000000001";
inline constexpr const char* kNewFile = "00000000-0000-4000-8000-000000000002";

inline drivers::MvrFileBytes some_file(std::size_t size) {
  auto bytes = std::make_shared<std::vector<std::uint8_t>>(size);
  for (std::size_t i = 0; i < size; ++i) (*bytes)[i] = static_cast<std::uint8_t>((i * 2'654'435'761u) >> 13);
  return bytes;
}

inline drivers::MvrCommit commit_of(const char* uuid, const char* comment = "") {
  drivers::MvrCommit commit;
  commit.file_uuid = uuid;
  commit.comment = comment;
  return commit;
}

inline drivers::MvrMessage request_of(const std::string& file, std::vector<std::string> from = {}) {
  drivers::MvrMessage request;
  request.type = drivers::MvrMessageType::kRequest;
  request.file_uuid = file;
  request.from_stations = std::move(from);
  return request;
}

class MemorySink final : public drivers::MvrFileSink {
 public:
  Status write(std::span<const std::uint8_t> part, std::uint64_t total_bytes) override {
    bytes.insert(bytes.end(), part.begin(), part.end());
    total = total_bytes;
    if (bytes.size() > bytes_max) return fail(ErrorCode::kIo, "the disk is full");
    return {};
  }
  std::vector<std::uint8_t> bytes;
  std::uint64_t total = 0;
  std::size_t bytes_max = SIZE_MAX;
};

// Waits until something is readable or writable; at most 100 ms, so that a test that waits for nothing ends.
inline void poll_some(std::vector<pollfd>& waiting) {
  (void)::poll(waiting.data(), waiting.size(), 100);
  waiting.clear();
}

}  // namespace footlight::testing
