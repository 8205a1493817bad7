#include "tests/support/zip_bytes.h"

#include <algorithm>

namespace footlight::testing {
namespace {

void put(std::string& out, std::uint64_t value, int bytes) {
  for (int i = 0; i < bytes; ++i) out += static_cast<char>(static_cast<unsigned char>(value >> (8 * i)));
}

// CRC-32 of ISO 3309, bit by bit.
std::uint32_t sum_of(std::string_view bytes) {
  std::uint32_t sum = 0xFFFFFFFF;
  for (const char c : bytes) {
    sum ^= static_cast<unsigned char>(c);
    for (int bit = 0; bit < 8; ++bit) sum = (sum >> 1) ^ ((sum & 1) != 0 ? 0xEDB88320u : 0u);
  }
  return ~sum;
}

// RFC 1951, stored blocks.
std::string deflated(std::string_view content) {
  std::string out;
  do {
    const std::string_view block = content.substr(0, 0xFFFF);
    content.remove_prefix(block.size());
    out += content.empty() ? '\x01' : '\x00';
    put(out, block.size(), 2);
    put(out, ~block.size() & 0xFFFF, 2);
    out += block;
  } while (!content.empty());
  return out;
}

// RFC 1951, one block with its own codes: a zero, then copies of 258 bytes from one byte back at two bits each. That is
// the maximum of deflate: 1032 to 1. Holds 1 + 258 n bytes, at least as many as requested.
std::string deflated_zeros(std::uint64_t count) {
  std::string out;
  unsigned bits = 0, filled = 0;
  const auto put_bits = [&](unsigned value, unsigned width) {  // least significant first
    bits |= value << filled;
    for (filled += width; filled >= 8; filled -= 8, bits >>= 8) out += static_cast<char>(bits & 0xFF);
  };
  put_bits(1, 1);  // the last block
  put_bits(2, 2);  // with its own codes
  put_bits(286 - 257, 5);
  put_bits(0, 5);       // one distance
  put_bits(18 - 4, 4);  // lengths of the codes for lengths, in the order of the standard: 18 is '0', 1 '10', 2 '11'
  for (const char length : std::string_view("001000000000000202")) put_bits(static_cast<unsigned>(length - '0'), 3);
  const auto one = [&] { put_bits(0b01, 2); };
  const auto two = [&] { put_bits(0b11, 2); };
  const auto none = [&](unsigned run) {
    put_bits(0, 1);
    put_bits(run - 11, 7);
  };
  two();      // the zero byte: '10'
  none(138);  // 1 to 255 do not occur
  none(117);
  two();  // the end: '11'
  none(28);
  one();  // a copy of 258 bytes: '0'
  one();  // from one byte back: '0'
  put_bits(0b01, 2);
  const std::uint64_t copies = (count + 256) / 258;
  std::uint64_t left = copies;
  for (; left > 0 && filled != 0; --left) put_bits(0, 2);
  out.append(left / 4, '\0');
  for (left %= 4; left > 0; --left) put_bits(0, 2);
  put_bits(0b11, 2);
  put_bits(0, 7);
  return out;
}

}  // namespace

std::string make_zip(const std::vector<ZipEntry>& entries) {
  std::string body, directory;
  for (const ZipEntry& entry : entries) {
    const std::string packed = entry.zeros > 0     ? deflated_zeros(entry.zeros)
                               : entry.method == 8 ? deflated(entry.content)
                                                   : entry.content;
    const std::uint64_t truth = entry.zeros > 0 ? 1 + (entry.zeros + 256) / 258 * 258 : entry.content.size();
    const std::uint64_t size = entry.claimed_size >= 0 ? static_cast<std::uint64_t>(entry.claimed_size) : truth;
    const bool is_long = size >= 0xFFFFFFFF;
    std::string extra;
    if (is_long) {
      put(extra, 1, 2);  // zip64
      put(extra, 16, 2);
      put(extra, size, 8);
      put(extra, packed.size(), 8);
    }
    std::string common;
    put(common, 20, 2);
    put(common, entry.flags, 2);
    put(common, entry.zeros > 0 ? 8 : entry.method, 2);
    put(common, 0, 4);  // time and date
    put(common, sum_of(entry.content) ^ (entry.wrong_sum ? 1u : 0u), 4);
    put(common, is_long ? 0xFFFFFFFF : packed.size(), 4);
    put(common, is_long ? 0xFFFFFFFF : size, 4);
    put(common, entry.name.size(), 2);
    const std::size_t at = body.size();
    put(body, 0x04034b50, 4);
    body += common;
    put(body, extra.size(), 2);
    body += entry.name + extra + packed;
    put(directory, 0x02014b50, 4);
    put(directory, 20, 2);
    directory += common;
    put(directory, extra.size(), 2);
    put(directory, 0, 6);  // length of the comment, disk, inner attributes
    put(directory, 0, 4);  // outer attributes
    put(directory, at, 4);
    directory += entry.name + extra;
  }
  const std::size_t at = body.size();
  body += directory;
  put(body, 0x06054b50, 4);
  put(body, 0, 4);
  put(body, entries.size(), 2);
  put(body, entries.size(), 2);
  put(body, directory.size(), 4);
  put(body, at, 4);
  put(body, 0, 2);
  return body;
}

}  // namespace footlight::testing
