// The fixed parts of a .dmxlog file: header, block header, index, trailer. Layout and reasons: docs/formats/dmxlog.md.
// Bytes only, no I/O. Every decode function checks each length and each range before using it.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/dmx.h"
#include "sim/dmx_log/bytes.h"

namespace footlight::dmx_log {

inline constexpr std::uint8_t kFileMagic[8] = {0x89, 'D', 'M', 'X', 'L', '\r', '\n', 0x1A};
inline constexpr std::uint8_t kEndMagic[8] = {'D', 'M', 'X', 'L', 'E', 'N', 'D', '\n'};
inline constexpr std::uint32_t kBlockMagic = 0xB14B4C46;  // bytes 'F' 'L' 'K' 0xB1
inline constexpr std::uint32_t kIndexMagic = 0xB1584946;  // bytes 'F' 'I' 'X' 0xB1
inline constexpr int kVersionMajor = 1;
inline constexpr int kVersionMinor = 0;

inline constexpr std::size_t kFileHeaderFixedBytes = 40;  // before the list of universes
inline constexpr std::size_t kFileHeaderBytesMax = 1u << 20;
inline constexpr std::size_t kBlockHeaderBytes = 48;
inline constexpr std::size_t kTrailerBytes = 24;
inline constexpr std::size_t kIndexFixedBytes = 56;
inline constexpr std::size_t kIndexUniverseBytes = 40;
inline constexpr std::size_t kIndexEntryBytes = 16;
inline constexpr std::size_t kIndexEntriesMax = 65'536;
inline constexpr std::size_t kIndexBytesMax =
    kIndexFixedBytes + kIndexUniverseBytes * kUniverseMax + kIndexEntryBytes * kIndexEntriesMax + 4;
inline constexpr std::size_t kRawBytesMax = 128u << 20;
inline constexpr std::size_t kCompressedBytesMax = 130u << 20;
inline constexpr std::int64_t kTimeLimitNs = std::int64_t{1} << 61;  // 73 years, limit of times and of origins, so that
                                                                     // sums fit

struct FileHeader {
  int version_major = kVersionMajor;
  int version_minor = kVersionMinor;
  TimeNs origin_ns = 0;
  std::int64_t wall_start_unix_ns = 0;
  std::vector<Universe> universes;
};

[[nodiscard]] Bytes encode(const FileHeader& header);
// The header size stored in the first kFileHeaderFixedBytes; nullopt if it is invalid.
[[nodiscard]] std::optional<std::size_t> file_header_size(std::span<const std::uint8_t> fixed_part);
// Decodes a whole header after its magic and version were checked; nullopt if it is damaged.
[[nodiscard]] std::optional<FileHeader> decode_file_header(std::span<const std::uint8_t> bytes, bool check_checksum);

struct BlockHeader {
  std::uint32_t compressed_bytes = 0;
  std::uint32_t raw_bytes = 0;
  std::uint32_t frame_count = 0;
  std::uint32_t number = 0;  // counts blocks from 0
  DurationNs first_ns = 0;   // times of the first and the last frame
  DurationNs last_ns = 0;
  std::uint32_t payload_crc = 0;  // CRC-32C of the compressed bytes
};

[[nodiscard]] Bytes encode(const BlockHeader& header);
[[nodiscard]] std::optional<BlockHeader> decode_block_header(std::span<const std::uint8_t> bytes, bool check_checksum);

struct IndexUniverse {
  Universe universe = 0;
  int slot_count = 0;
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  DurationNs first_ns = 0;
  DurationNs last_ns = 0;
};

struct IndexEntry {
  std::uint64_t offset = 0;  // of a block header in the file
  DurationNs first_ns = 0;
};

struct Index {
  DurationNs end_ns = 0;
  std::uint64_t frames = 0;
  std::uint64_t changes = 0;
  std::uint64_t blocks = 0;
  std::uint64_t late_stamps = 0;
  std::vector<IndexUniverse> universes;
  std::vector<IndexEntry> entries;  // ascending in both
};

[[nodiscard]] Bytes encode(const Index& index);
[[nodiscard]] std::optional<Index> decode_index(std::span<const std::uint8_t> bytes, bool check_checksum);

struct Trailer {
  std::uint64_t index_offset = 0;
  std::uint32_t index_bytes = 0;
};

[[nodiscard]] Bytes encode(const Trailer& trailer);
[[nodiscard]] std::optional<Trailer> decode_trailer(std::span<const std::uint8_t> bytes, bool check_checksum);

// Keeps the place of every block, or of every second, fourth, ... block if there are many: never more than
// kIndexEntriesMax. So a recording of months needs no more memory than one of minutes.
class IndexThinner {
 public:
  void add(const IndexEntry& entry) {
    if (seen_++ % stride_ != 0) return;
    if (entries_.size() == kIndexEntriesMax) {
      for (std::size_t i = 0; i < kIndexEntriesMax / 2; ++i) entries_[i] = entries_[2 * i];
      entries_.resize(kIndexEntriesMax / 2);
      stride_ *= 2;
      if ((seen_ - 1) % stride_ != 0) return;
    }
    entries_.push_back(entry);
  }
  [[nodiscard]] const std::vector<IndexEntry>& entries() const { return entries_; }

 private:
  std::vector<IndexEntry> entries_;
  std::uint64_t seen_ = 0;
  std::uint64_t stride_ = 1;
};

}  // namespace footlight::dmx_log
