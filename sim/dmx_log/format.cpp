#include "sim/dmx_log/format.h"

#include <algorithm>

#include "sim/dmx_log/crc32c.h"

namespace footlight::dmx_log {
namespace {

void put_crc(Bytes& out) { put_u32(out, crc32c(out)); }

// Checks the last four bytes, the checksum of all bytes before them.
bool crc_holds(std::span<const std::uint8_t> bytes, bool check) {
  if (bytes.size() < 4) return false;
  if (!check) return true;
  Cursor cursor(bytes.last(4));
  return cursor.u32() == crc32c(bytes.first(bytes.size() - 4));
}

bool time_holds(std::int64_t time_ns) { return time_ns >= 0 && time_ns <= kTimeLimitNs; }

}  // namespace

Bytes encode(const FileHeader& header) {
  Bytes out;
  const std::size_t size = kFileHeaderFixedBytes + 2 * header.universes.size() + 4;
  out.reserve(size);
  for (const std::uint8_t byte : kFileMagic) put_u8(out, byte);
  put_u16(out, static_cast<std::uint16_t>(header.version_major));
  put_u16(out, static_cast<std::uint16_t>(header.version_minor));
  put_u32(out, static_cast<std::uint32_t>(size));
  put_i64(out, header.origin_ns);
  put_i64(out, header.wall_start_unix_ns);
  put_u32(out, static_cast<std::uint32_t>(header.universes.size()));
  put_u32(out, 0);
  for (const Universe universe : header.universes) put_u16(out, static_cast<std::uint16_t>(universe));
  put_crc(out);
  return out;
}

std::optional<std::size_t> file_header_size(std::span<const std::uint8_t> fixed_part) {
  Cursor cursor(fixed_part);
  cursor.take(12);
  const std::size_t size = cursor.u32();
  if (!cursor.ok() || size < kFileHeaderFixedBytes + 4 || size > kFileHeaderBytesMax) return std::nullopt;
  return size;
}

std::optional<FileHeader> decode_file_header(std::span<const std::uint8_t> bytes, bool check_checksum) {
  if (!crc_holds(bytes, check_checksum)) return std::nullopt;
  Cursor cursor(bytes);
  cursor.take(8);
  FileHeader header;
  header.version_major = cursor.u16();
  header.version_minor = cursor.u16();
  cursor.take(4);
  header.origin_ns = cursor.i64();
  header.wall_start_unix_ns = cursor.i64();
  const std::uint32_t count = cursor.u32();
  cursor.take(4);
  if (!cursor.ok() || header.origin_ns < -kTimeLimitNs || header.origin_ns > kTimeLimitNs) return std::nullopt;
  if (count > static_cast<std::uint32_t>(kUniverseMax) || cursor.left() < 2 * std::size_t{count} + 4) {
    return std::nullopt;
  }
  header.universes.reserve(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const Universe universe = cursor.u16();
    if (!is_universe(universe)) return std::nullopt;
    header.universes.push_back(universe);
  }
  return header;
}

Bytes encode(const BlockHeader& header) {
  Bytes out;
  out.reserve(kBlockHeaderBytes);
  put_u32(out, kBlockMagic);
  put_u32(out, header.compressed_bytes);
  put_u32(out, header.raw_bytes);
  put_u32(out, header.frame_count);
  put_u32(out, header.number);
  put_u32(out, 0);
  put_i64(out, header.first_ns);
  put_i64(out, header.last_ns);
  put_u32(out, header.payload_crc);
  put_crc(out);
  return out;
}

std::optional<BlockHeader> decode_block_header(std::span<const std::uint8_t> bytes, bool check_checksum) {
  if (bytes.size() != kBlockHeaderBytes || !crc_holds(bytes, check_checksum)) return std::nullopt;
  Cursor cursor(bytes);
  if (cursor.u32() != kBlockMagic) return std::nullopt;
  BlockHeader header;
  header.compressed_bytes = cursor.u32();
  header.raw_bytes = cursor.u32();
  header.frame_count = cursor.u32();
  header.number = cursor.u32();
  cursor.take(4);
  header.first_ns = cursor.i64();
  header.last_ns = cursor.i64();
  header.payload_crc = cursor.u32();
  if (header.compressed_bytes > kCompressedBytesMax || header.raw_bytes > kRawBytesMax) return std::nullopt;
  // A frame takes at least its tag and its time.
  if (header.frame_count == 0 || header.frame_count > header.raw_bytes / 2) return std::nullopt;
  if (!time_holds(header.first_ns) || !time_holds(header.last_ns) || header.last_ns < header.first_ns) {
    return std::nullopt;
  }
  return header;
}

Bytes encode(const Index& index) {
  Bytes out;
  const std::size_t size =
      kIndexFixedBytes + kIndexUniverseBytes * index.universes.size() + kIndexEntryBytes * index.entries.size() + 4;
  out.reserve(size);
  put_u32(out, kIndexMagic);
  put_u32(out, static_cast<std::uint32_t>(size));
  put_i64(out, index.end_ns);
  put_u64(out, index.frames);
  put_u64(out, index.changes);
  put_u64(out, index.blocks);
  put_u64(out, index.late_stamps);
  put_u32(out, static_cast<std::uint32_t>(index.universes.size()));
  put_u32(out, static_cast<std::uint32_t>(index.entries.size()));
  for (const IndexUniverse& universe : index.universes) {
    put_u16(out, static_cast<std::uint16_t>(universe.universe));
    put_u16(out, static_cast<std::uint16_t>(universe.slot_count));
    put_u32(out, 0);
    put_u64(out, universe.frames);
    put_u64(out, universe.changes);
    put_i64(out, universe.first_ns);
    put_i64(out, universe.last_ns);
  }
  for (const IndexEntry& entry : index.entries) {
    put_u64(out, entry.offset);
    put_i64(out, entry.first_ns);
  }
  put_crc(out);
  return out;
}

std::optional<Index> decode_index(std::span<const std::uint8_t> bytes, bool check_checksum) {
  if (!crc_holds(bytes, check_checksum)) return std::nullopt;
  Cursor cursor(bytes);
  Index index;
  if (cursor.u32() != kIndexMagic || cursor.u32() != bytes.size()) return std::nullopt;
  index.end_ns = cursor.i64();
  index.frames = cursor.u64();
  index.changes = cursor.u64();
  index.blocks = cursor.u64();
  index.late_stamps = cursor.u64();
  const std::uint32_t universe_count = cursor.u32();
  const std::uint32_t entry_count = cursor.u32();
  if (!cursor.ok() || !time_holds(index.end_ns)) return std::nullopt;
  if (universe_count > static_cast<std::uint32_t>(kUniverseMax) || entry_count > kIndexEntriesMax) return std::nullopt;
  if (cursor.left() != kIndexUniverseBytes * universe_count + kIndexEntryBytes * entry_count + 4) return std::nullopt;
  index.universes.reserve(universe_count);
  for (std::uint32_t i = 0; i < universe_count; ++i) {
    IndexUniverse universe;
    universe.universe = cursor.u16();
    universe.slot_count = cursor.u16();
    cursor.take(4);
    universe.frames = cursor.u64();
    universe.changes = cursor.u64();
    universe.first_ns = cursor.i64();
    universe.last_ns = cursor.i64();
    if (!is_universe(universe.universe) || universe.slot_count > kSlotCountMax || !time_holds(universe.first_ns) ||
        !time_holds(universe.last_ns)) {
      return std::nullopt;
    }
    index.universes.push_back(universe);
  }
  index.entries.reserve(entry_count);
  for (std::uint32_t i = 0; i < entry_count; ++i) {
    IndexEntry entry;
    entry.offset = cursor.u64();
    entry.first_ns = cursor.i64();
    if (!index.entries.empty() &&
        (entry.offset <= index.entries.back().offset || entry.first_ns < index.entries.back().first_ns)) {
      return std::nullopt;
    }
    if (!time_holds(entry.first_ns)) return std::nullopt;
    index.entries.push_back(entry);
  }
  return index;
}

Bytes encode(const Trailer& trailer) {
  Bytes out;
  put_u64(out, trailer.index_offset);
  put_u32(out, trailer.index_bytes);
  put_crc(out);
  for (const std::uint8_t byte : kEndMagic) put_u8(out, byte);
  return out;
}

std::optional<Trailer> decode_trailer(std::span<const std::uint8_t> bytes, bool check_checksum) {
  if (bytes.size() != kTrailerBytes || !crc_holds(bytes.first(16), check_checksum)) return std::nullopt;
  if (!std::equal(bytes.end() - 8, bytes.end(), std::begin(kEndMagic))) return std::nullopt;
  Cursor cursor(bytes);
  Trailer trailer;
  trailer.index_offset = cursor.u64();
  trailer.index_bytes = cursor.u32();
  if (trailer.index_bytes > kIndexBytesMax) return std::nullopt;
  return trailer;
}

}  // namespace footlight::dmx_log
