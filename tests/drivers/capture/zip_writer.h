// A zip of files that are not compressed (PKWARE's APPNOTE 6.3, sections 4.3.7, 4.3.12, 4.3.16), in memory.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace footlight::testing {

class ZipWriter {
 public:
  void add(std::string_view name, std::span<const std::uint8_t> bytes) {
    const auto offset = static_cast<std::uint32_t>(out_.size());
    const std::uint32_t crc = crc32(bytes);
    const auto head = [&](std::vector<std::uint8_t>& to) {
      put(to, 20, 2);           // version needed
      put(to, 0, 2);            // flags
      put(to, 0, 2);            // stored
      put(to, 0x5A21'0000, 4);  // some time
      put(to, crc, 4);
      put(to, bytes.size(), 4);
      put(to, bytes.size(), 4);
      put(to, name.size(), 2);
      put(to, 0, 2);  // extra field
    };
    put(out_, 0x04034B50, 4);
    head(out_);
    out_.insert(out_.end(), name.begin(), name.end());
    out_.insert(out_.end(), bytes.begin(), bytes.end());
    put(directory_, 0x02014B50, 4);
    put(directory_, 20, 2);  // version made by
    head(directory_);
    put(directory_, 0, 2);  // comment
    put(directory_, 0, 2);  // disk
    put(directory_, 0, 2);  // attributes
    put(directory_, 0, 4);
    put(directory_, offset, 4);
    directory_.insert(directory_.end(), name.begin(), name.end());
    ++count_;
  }
  void add(std::string_view name, std::string_view text) {
    add(name, std::span(reinterpret_cast<const std::uint8_t*>(text.data()), text.size()));
  }
  [[nodiscard]] std::vector<std::uint8_t> finish() const {
    std::vector<std::uint8_t> zip = out_;
    zip.insert(zip.end(), directory_.begin(), directory_.end());
    put(zip, 0x06054B50, 4);
    put(zip, 0, 4);  // disks
    put(zip, count_, 2);
    put(zip, count_, 2);
    put(zip, directory_.size(), 4);
    put(zip, out_.size(), 4);
    put(zip, 0, 2);  // comment
    return zip;
  }

 private:
  static void put(std::vector<std::uint8_t>& to, std::uint64_t value, int byte_count) {
    for (int i = 0; i < byte_count; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  }
  static std::uint32_t crc32(std::span<const std::uint8_t> bytes) {
    std::uint32_t crc = ~0u;
    for (const std::uint8_t byte : bytes) {
      crc ^= byte;
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xEDB88320u : 0u);
    }
    return ~crc;
  }

  std::vector<std::uint8_t> out_;
  std::vector<std::uint8_t> directory_;
  std::uint64_t count_ = 0;
};

}  // namespace footlight::testing
