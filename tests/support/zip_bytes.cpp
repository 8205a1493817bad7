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

}  // namespace

std::string make_zip(const std::vector<ZipEntry>& entries) {
  std::string body, directory;
  for (const ZipEntry& entry : entries) {
    const std::string packed = entry.method == 8 ? deflated(entry.content) : entry.content;
    const std::uint64_t size =
        entry.claimed_size >= 0 ? static_cast<std::uint64_t>(entry.claimed_size) : entry.content.size();
    std::string common;
    put(common, 20, 2);
    put(common, entry.flags, 2);
    put(common, entry.method, 2);
    put(common, 0, 4);  // when
    put(common, sum_of(entry.content) ^ (entry.wrong_sum ? 1u : 0u), 4);
    put(common, packed.size(), 4);
    put(common, size, 4);
    put(common, entry.name.size(), 2);
    const std::size_t at = body.size();
    put(body, 0x04034b50, 4);
    body += common;
    put(body, 0, 2);
    body += entry.name + packed;
    put(directory, 0x02014b50, 4);
    put(directory, 20, 2);
    directory += common;
    put(directory, 0, 8);  // lengths of extra and comment, disk, inner attributes
    put(directory, 0, 4);  // outer attributes
    put(directory, at, 4);
    directory += entry.name;
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
