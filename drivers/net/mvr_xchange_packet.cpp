#include "drivers/net/mvr_xchange_packet.h"

#include <algorithm>

#include "drivers/net/bytes.h"

namespace footlight::drivers {
namespace {

std::uint64_t bytes_max_of(MvrPayload payload) {
  return payload == MvrPayload::kJson ? kMvrJsonBytesMax : kMvrFileBytesMax;
}

Status refuse_size(MvrPayload payload, std::uint64_t bytes) {
  if (bytes <= bytes_max_of(payload)) return {};
  return fail(ErrorCode::kProtocol, "a {} of {} bytes; at most {} are taken",
              payload == MvrPayload::kJson ? "message" : "file", bytes, bytes_max_of(payload));
}

}  // namespace

std::array<std::uint8_t, kMvrPacketHeaderBytes> build_mvr_header(const MvrPacketHeader& header) {
  std::array<std::uint8_t, kMvrPacketHeaderBytes> bytes = {};
  write_u32_be(bytes, 0, kMvrPacketMark);
  write_u32_be(bytes, 4, kMvrPacketVersion);
  write_u32_be(bytes, 8, header.number);
  write_u32_be(bytes, 12, header.count);
  write_u32_be(bytes, 16, static_cast<std::uint32_t>(header.payload));
  write_u32_be(bytes, 20, static_cast<std::uint32_t>(header.payload_bytes >> 32));
  write_u32_be(bytes, 24, static_cast<std::uint32_t>(header.payload_bytes & 0xFFFF'FFFFu));
  return bytes;
}

Result<MvrPacketHeader> parse_mvr_header(std::span<const std::uint8_t, kMvrPacketHeaderBytes> bytes) {
  if (const std::uint32_t mark = read_u32_be(bytes, 0); mark != kMvrPacketMark) {
    return fail(ErrorCode::kProtocol, "no MVR-xchange packet: it begins with {}, expected {}", mark, kMvrPacketMark);
  }
  if (const std::uint32_t version = read_u32_be(bytes, 4); version != kMvrPacketVersion) {
    return fail(ErrorCode::kProtocol, "a packet of version {}; only version {} is known", version, kMvrPacketVersion);
  }
  MvrPacketHeader header;
  header.number = read_u32_be(bytes, 8);
  header.count = read_u32_be(bytes, 12);
  const std::uint32_t kind = read_u32_be(bytes, 16);
  if (kind > static_cast<std::uint32_t>(MvrPayload::kFile)) {
    return fail(ErrorCode::kProtocol, "a packet of kind {}; expected 0 (JSON) or 1 (file)", kind);
  }
  header.payload = static_cast<MvrPayload>(kind);
  if (header.number >= header.count || header.count > kMvrPacketsMax) {
    return fail(ErrorCode::kProtocol, "packet {} of {}: expected numbers from 0, and at most {} packets", header.number,
                header.count, kMvrPacketsMax);
  }
  header.payload_bytes = std::uint64_t{read_u32_be(bytes, 20)} << 32 | read_u32_be(bytes, 24);
  FL_TRY(refuse_size(header.payload, header.payload_bytes));
  return header;
}

std::string build_mvr_json(std::string_view json) {
  MvrPacketHeader header;
  header.payload_bytes = json.size();
  const auto bytes = build_mvr_header(header);
  std::string packet(bytes.begin(), bytes.end());
  packet += json;
  return packet;
}

Status MvrPacketReader::begin_packet() {
  FL_ASSIGN(const MvrPacketHeader header, parse_mvr_header(header_bytes_));
  if (!in_message_) {
    in_message_ = true;
    first_ = header;
    next_number_ = 0;
    message_bytes_ = 0;
  }
  if (header.number != next_number_ || header.count != first_.count || header.payload != first_.payload) {
    return fail(ErrorCode::kProtocol, "packet {} of {} (kind {}): expected packet {} of {} (kind {})", header.number,
                header.count, static_cast<std::uint32_t>(header.payload), next_number_, first_.count,
                static_cast<std::uint32_t>(first_.payload));
  }
  ++next_number_;
  message_bytes_ += header.payload_bytes;  // no overflow: both are at most some GiB
  FL_TRY(refuse_size(header.payload, message_bytes_));
  left_bytes_ = header.payload_bytes;
  return {};
}

Status MvrPacketReader::end_packet(MvrPacketReceiver& receiver) {
  header_size_ = 0;
  if (next_number_ < first_.count) return {};
  in_message_ = false;
  if (first_.payload == MvrPayload::kFile) return receiver.receive_file_end();
  const std::string json = std::move(json_);
  json_.clear();
  return receiver.receive_json(json);
}

Status MvrPacketReader::read(std::span<const std::uint8_t> bytes, MvrPacketReceiver& receiver) {
  while (!bytes.empty()) {
    FL_ASSIGN(const std::size_t size, read_message(bytes, receiver));
    bytes = bytes.subspan(size);
  }
  return {};
}

Result<std::size_t> MvrPacketReader::read_message(const std::span<const std::uint8_t> all,
                                                  MvrPacketReceiver& receiver) {
  std::span<const std::uint8_t> bytes = all;
  while (true) {
    if (header_size_ < kMvrPacketHeaderBytes) {
      const std::size_t size = std::min(bytes.size(), kMvrPacketHeaderBytes - header_size_);
      std::copy_n(bytes.begin(), size, header_bytes_.begin() + static_cast<std::ptrdiff_t>(header_size_));
      header_size_ += size;
      bytes = bytes.subspan(size);
      if (header_size_ < kMvrPacketHeaderBytes) return all.size();
      FL_TRY(begin_packet());
    }
    const std::size_t size = static_cast<std::size_t>(std::min<std::uint64_t>(bytes.size(), left_bytes_));
    const auto part = bytes.first(size);
    if (first_.payload == MvrPayload::kJson) {
      json_.append(reinterpret_cast<const char*>(part.data()), part.size());
    } else if (!part.empty()) {
      FL_TRY(receiver.receive_file_part(part, message_bytes_));
    }
    left_bytes_ -= size;
    bytes = bytes.subspan(size);
    if (left_bytes_ > 0) return all.size();
    FL_TRY(end_packet(receiver));
    if (bytes.empty() || !in_message_) return all.size() - bytes.size();
  }
}

}  // namespace footlight::drivers
