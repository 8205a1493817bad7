#include <algorithm>
#include <cstring>

#include "sim/dmx_log/bytes.h"
#include "sim/dmx_log/crc32c.h"
#include "sim/dmx_log/format.h"
#include "tests/sim/dmx_log/exercise.h"
#include "tests/sim/dmx_log/support.h"

using namespace footlight;
using namespace footlight::testing;

namespace {

// About a dozen blocks in some kilobytes.
std::vector<OwnedFrame> few_frames() {
  auto frames = random_frames(11, 60, 2);
  for (OwnedFrame& frame : frames) {
    for (std::size_t slot = 20; slot < frame.slots.size(); ++slot) frame.slots[slot] = 3;
  }
  return frames;
}

std::vector<std::uint8_t> small_log(const std::vector<OwnedFrame>& frames, DurationNs end_ns = kNsPerS) {
  LogWriterOptions options;
  options.block_span_ns = 12 * kNsPerMs;
  options.universes = {1, 8};
  options.origin_ns = 77;
  return log_bytes(frames, end_ns, options);
}

bool is_subsequence(const std::vector<OwnedFrame>& part, const std::vector<OwnedFrame>& whole) {
  auto at = whole.begin();
  for (const OwnedFrame& frame : part) {
    at = std::find(at, whole.end(), frame);
    if (at == whole.end()) return false;
    ++at;
  }
  return true;
}

std::vector<std::uint64_t> block_offsets(const std::vector<std::uint8_t>& bytes) {
  std::vector<std::uint64_t> offsets;
  const std::uint8_t magic[4] = {'F', 'L', 'K', 0xB1};
  for (auto at = bytes.begin(); (at = std::search(at, bytes.end(), magic, magic + 4)) != bytes.end(); ++at) {
    offsets.push_back(static_cast<std::uint64_t>(at - bytes.begin()));
  }
  return offsets;
}

std::string error_of(std::vector<std::uint8_t> bytes, ErrorCode code = ErrorCode::kBadInput) {
  const auto reader = LogReader::open_bytes(std::move(bytes), "a.dmxlog");
  REQUIRE(!reader);
  CHECK(reader.error().code == code);
  CHECK(reader.error().message.starts_with("a.dmxlog: "));
  return reader.error().message;
}

}  // namespace

TEST_CASE("the checksum is CRC-32C: the vectors of RFC 3720, B.4") {
  std::vector<std::uint8_t> bytes(32, 0);
  CHECK(dmx_log::crc32c(bytes) == 0x8A9136AAu);
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0xFF});
  CHECK(dmx_log::crc32c(bytes) == 0x62A8AB43u);
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<std::uint8_t>(i);
  CHECK(dmx_log::crc32c(bytes) == 0x46DD794Eu);
  const std::string digits = "123456789";
  CHECK(dmx_log::crc32c({reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()}) == 0xE3069283u);
}

TEST_CASE("a log cut off at any byte returns the frames of its whole blocks") {
  const auto frames = few_frames();
  const auto bytes = small_log(frames);
  const auto offsets = block_offsets(bytes);
  REQUIRE(offsets.size() > 5);
  REQUIRE(bytes.size() < 12'000);
  std::size_t most = 0;
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    CAPTURE(size);
    std::vector<std::uint8_t> cut(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size));
    auto reader = LogReader::open_bytes(std::move(cut), "a.dmxlog");
    if (size < offsets[0]) {
      REQUIRE(!reader);
      continue;
    }
    REQUIRE(reader);
    REQUIRE(!reader->info().finished);
    const auto got = all_frames(*reader);
    REQUIRE(got.size() <= frames.size());
    REQUIRE(std::equal(got.begin(), got.end(), frames.begin()));
    REQUIRE(got.size() == reader->info().frames);
    REQUIRE(got.size() >= most);  // a longer file never returns fewer
    most = got.size();
    // Bytes after the last whole block are always reported.
    const auto whole = std::find(offsets.begin(), offsets.end(), size);
    if (whole != offsets.end() || size == offsets[0]) CHECK(reader->info().damage_count == 0);
  }
  CHECK(most == frames.size());
}

TEST_CASE("a flipped bit anywhere is reported, and every frame that is still returned is correct") {
  const auto frames = few_frames();
  const auto bytes = small_log(frames);
  int opened = 0;
  for (std::size_t at = 0; at < bytes.size(); ++at) {
    for (const int mask : {0x01, 0x80, 0xFF}) {
      CAPTURE(at);
      CAPTURE(mask);
      auto damaged = bytes;
      damaged[at] = static_cast<std::uint8_t>(damaged[at] ^ mask);
      auto reader = LogReader::open_bytes(std::move(damaged), "a.dmxlog");
      REQUIRE(reader);
      ++opened;
      const auto got = all_frames(*reader);
      REQUIRE(is_subsequence(got, frames));
      REQUIRE(reader->info().damage_count > 0);
      REQUIRE(reader->info().recovered());
      REQUIRE(got.size() + 30 > frames.size());  // one block at most
    }
  }
  CHECK(opened > 0);
}

TEST_CASE("all readers of a log know of the damage that one of them has met") {
  auto bytes = small_log(few_frames());
  const auto offsets = block_offsets(bytes);
  REQUIRE(offsets.size() > 2);
  bytes[offsets[1] + dmx_log::kBlockHeaderBytes] ^= 0xFF;
  auto first = LogReader::open_bytes(std::move(bytes), "a.dmxlog");
  REQUIRE(first);
  LogReader second = first->again();
  CHECK(first->damage_met().count == 0);  // nothing was read
  (void)all_frames(second);
  const LogReader::DamageMet met = first->damage_met();
  CHECK(met.count == 1);
  REQUIRE(met.first.size() == 1);
  CHECK(met.first[0].offset == offsets[1]);
  CHECK(first->info().damage_count == 0);
  CHECK(met.bytes == met.first[0].size_bytes);
  (void)all_frames(*first);
  CHECK(second.damage_met().count == 1);  // the same once more
  CHECK(second.damage_met().bytes == met.bytes);
}

TEST_CASE("more damaged parts than are listed are counted, with their bytes") {
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < 300; ++i) {
    OwnedFrame frame;
    frame.universe = 1;
    frame.time_ns = i * 10 * kNsPerMs;
    frame.slots = {static_cast<std::uint8_t>(i), 5};
    frames.push_back(frame);
  }
  LogWriterOptions options;
  options.block_span_ns = 5 * kNsPerMs;
  auto bytes = log_bytes(frames, 4 * kNsPerS, options);
  const auto offsets = block_offsets(bytes);
  REQUIRE(offsets.size() > 201);
  for (std::size_t i = 0; i < 200; i += 2) bytes[offsets[i] + dmx_log::kBlockHeaderBytes] ^= 0xFF;
  std::uint64_t size = 0;
  for (std::size_t i = 0; i < 200; i += 2) size += offsets[i + 1] - offsets[i];
  auto reader = LogReader::open_bytes(std::move(bytes), "a.dmxlog");
  REQUIRE(reader);
  (void)all_frames(*reader);
  CHECK(reader->info().damage.size() == kLogDamageListedMax);
  CHECK(reader->info().damage_count == 100);
  CHECK(reader->info().damage_bytes == size);
  CHECK(reader->damage_met().count == 100);
  CHECK(reader->damage_met().first.size() == kLogDamageListedMax);
  CHECK(reader->damage_met().bytes == size);
}

TEST_CASE("one flipped bit anywhere in the header loses the origin and the clock, but no frame, finished or not") {
  const auto frames = few_frames();
  LogWriterOptions options;
  options.block_span_ns = 12 * kNsPerMs;
  options.universes = {1, 8};
  options.origin_ns = 77;
  options.wall_start_unix_ns = 1'700'000'000 * kNsPerS;
  const auto whole = log_bytes(frames, kNsPerS, options);
  const auto header_bytes = block_offsets(whole).front();
  const auto unfinished = [&] {
    const auto trailer = dmx_log::decode_trailer(std::span(whole).last(dmx_log::kTrailerBytes), true);
    REQUIRE(trailer);
    return std::vector<std::uint8_t>(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(trailer->index_offset));
  }();
  for (const auto& bytes : {whole, unfinished}) {
    for (std::size_t bit = 0; bit < 8 * header_bytes; ++bit) {
      CAPTURE(bit);
      auto damaged = bytes;
      damaged[bit / 8] = static_cast<std::uint8_t>(damaged[bit / 8] ^ 1u << bit % 8);
      auto reader = LogReader::open_bytes(damaged, "a.dmxlog");
      REQUIRE_MESSAGE(reader, reader.error().message);
      REQUIRE(all_frames(*reader) == frames);
      const LogInfo& info = reader->info();
      REQUIRE(info.damage_count == 1);
      CHECK(info.damage[0].offset == 0);
      CHECK(info.damage[0].size_bytes == header_bytes);
      CHECK(info.damage[0].what == "the header is damaged: the start of the recording is unknown");
      CHECK(info.origin_ns == 0);
      CHECK(info.wall_start_unix_ns == 0);
      CHECK(info.version_major == 1);
      REQUIRE(reader->seek(frames.back().time_ns));
      CHECK(reader->snapshot().size() == 2);
    }
  }
}

TEST_CASE("Blocks beyond 1 MiB of damage are found only if the file begins with the bytes of a log") {
  const auto frames = few_frames();
  const auto log = small_log(frames);
  const auto header_bytes = static_cast<std::ptrdiff_t>(block_offsets(log).front());
  // An unfinished log whose header and first 2 MiB are damaged.
  std::vector<std::uint8_t> bytes(log.begin(), log.begin() + header_bytes);
  bytes[20] ^= 1;
  bytes.insert(bytes.end(), 2u << 20, std::uint8_t{0xEE});
  const std::uint64_t first = bytes.size();
  bytes.insert(bytes.end(), log.begin() + header_bytes, log.end() - 1);  // without its trailer's last byte
  auto reader = LogReader::open_bytes(bytes, "a.dmxlog");
  REQUIRE_MESSAGE(reader, reader.error().message);
  CHECK(all_frames(*reader) == frames);
  CHECK(reader->info().damage[0].offset == 0);
  CHECK(reader->info().damage[0].size_bytes == first);
  bytes[0] = 0xEE;
  CHECK(error_of(bytes).find("not a DMX log") != std::string::npos);
}

TEST_CASE("a log file is recognised by its blocks when its first bytes are damaged, whatever its name") {
  const TempFolder folder;
  auto bytes = small_log(few_frames());
  std::fill_n(bytes.begin(), 24, std::uint8_t{0xEE});
  for (const std::string name : {"a.dmxlog", "a.bin"}) {
    write_bytes(folder.file(name), std::string(bytes.begin(), bytes.end()));
    const auto format = detect_log_format(folder.file(name));
    REQUIRE_MESSAGE(format, format.error().message);
    CHECK(*format == LogFormat::kDmxLog);
    const auto report = convert_file(folder.file(name), folder.file("whole.dmxlog"), {.overwrite = true});
    REQUIRE(report);
    CHECK(report->frames == few_frames().size());
  }
}

TEST_CASE("a damaged block is reported with its place, and the next block restores the changes in it") {
  std::vector<OwnedFrame> frames;
  for (int i = 0; i < 6; ++i) {
    OwnedFrame frame;
    frame.universe = i == 2 ? 5 : 1;  // universe 5 has frames only in the block that will be damaged
    frame.time_ns = i * 100 * kNsPerMs;
    frame.slots.assign(512, static_cast<std::uint8_t>(10 + i));
    frames.push_back(frame);
  }
  LogWriterOptions options;
  options.block_span_ns = 50 * kNsPerMs;  // a block for each frame
  auto bytes = log_bytes(frames, kNsPerS, options);
  const auto offsets = block_offsets(bytes);
  REQUIRE(offsets.size() == 6);
  bytes[offsets[2] + dmx_log::kBlockHeaderBytes + 5] ^= 0x10;

  LogReader reader = open_log(bytes);
  std::vector<OwnedFrame> got;
  LogFrame frame;
  int restored = 0;
  while (*reader.next(frame)) {
    if (frame.restored) {
      ++restored;
      CHECK(frame.universe == 5);
      CHECK(frame.time_ns == frames[3].time_ns);
      CHECK(frame.levels[0] == 12);
      CHECK(frame.changes.size() == 1);
    } else {
      got.push_back(own(frame));
    }
  }
  CHECK(restored == 1);
  auto expected = frames;
  expected.erase(expected.begin() + 2);
  CHECK(got == expected);
  REQUIRE(reader.info().damage.size() == 1);
  CHECK(reader.info().damage[0].offset == offsets[2]);
  CHECK(reader.info().damage[0].size_bytes == offsets[3] - offsets[2]);
  CHECK(reader.info().damage[0].what == "the checksum of the block is wrong");

  // A time inside the damage has the state before it.
  REQUIRE(reader.seek(frames[2].time_ns + 1));
  REQUIRE(reader.snapshot().size() == 1);
  CHECK(reader.snapshot()[0].levels[0] == 11);
  REQUIRE(reader.seek(frames[3].time_ns));
  CHECK(reader.snapshot().size() == 2);
}

TEST_CASE("a file that is not a log is refused with a reason") {
  CHECK(error_of({}).find("is empty") != std::string::npos);
  CHECK(error_of({'O', 'L', 'A', ' ', 'S', 'h', 'o', 'w', '\n'}).find("OLA Show") != std::string::npos);
  CHECK(error_of(std::vector<std::uint8_t>(1000, 0)).find("not a DMX log") != std::string::npos);
  CHECK(error_of(std::vector<std::uint8_t>(1000, 0xFF)).find("not a DMX log") != std::string::npos);
  CHECK(error_of({0x89, 'D', 'M'}).find("ends inside its header") != std::string::npos);
  // A transfer in text mode changes the line ends of the magic.
  CHECK(error_of({0x89, 'D', 'M', 'X', 'L', '\n', 0x1A, 1, 0, 0, 0}).find("not a DMX log") != std::string::npos);
  const auto missing = LogReader::open("/nonexistent/a.dmxlog");
  REQUIRE(!missing);
  CHECK(missing.error().code == ErrorCode::kNotFound);
  CHECK(!LogReader::open("/"));
}

TEST_CASE("a log of a later major version is refused, of a later minor version read") {
  // A version with a matching checksum. A flipped bit of it would be damage instead.
  const auto log = small_log(few_frames());
  dmx_log::FileHeader later;
  later.version_major = 2;
  auto bytes = encode(later);
  bytes.insert(bytes.end(), log.begin() + static_cast<std::ptrdiff_t>(block_offsets(log).front()), log.end());
  CHECK(error_of(bytes, ErrorCode::kUnsupported).find("version 2.0, this program reads version 1.x") !=
        std::string::npos);

  dmx_log::FileHeader header;
  header.version_minor = 9;
  CHECK(LogReader::open_bytes(encode(header), "a.dmxlog")->info().version_minor == 9);
}

TEST_CASE("wrong lengths are detected") {
  const auto frames = few_frames();
  const auto bytes = small_log(frames);
  const auto offsets = block_offsets(bytes);
  const auto with_header = [&](auto change) {
    auto changed = bytes;
    const auto place = std::span(changed).subspan(offsets[1], dmx_log::kBlockHeaderBytes);
    auto header = dmx_log::decode_block_header(place, true);
    REQUIRE(header);
    change(*header);
    const auto encoded = encode(*header);  // with a valid checksum
    std::copy(encoded.begin(), encoded.end(), place.begin());
    LogReader reader = open_log(std::move(changed));
    CHECK(is_subsequence(all_frames(reader), frames));
    return reader.info().damage_count;
  };
  CHECK(with_header([](auto&) {}) == 0);
  CHECK(with_header([](auto& header) { header.compressed_bytes = 0xFFFFFFFF; }) > 0);
  CHECK(with_header([](auto& header) { header.compressed_bytes = 100'000'000; }) > 0);
  CHECK(with_header([](auto& header) { header.raw_bytes = 128u << 20; }) > 0);
  CHECK(with_header([](auto& header) { header.raw_bytes = 0xFFFFFFFF; }) > 0);
  CHECK(with_header([](auto& header) { header.frame_count = 1'000'000'000; }) > 0);
  CHECK(with_header([](auto& header) { header.frame_count += 1; }) > 0);
  CHECK(with_header([](auto& header) { header.last_ns = header.first_ns; }) > 0);
  CHECK(with_header([](auto& header) { header.last_ns = INT64_MAX; }) > 0);
  CHECK(with_header([](auto& header) { header.first_ns = -1; }) > 0);
  CHECK(with_header([](auto& header) { header.first_ns = INT64_MIN; }) > 0);

  dmx_log::Trailer trailer{UINT64_MAX - 10, 1000};
  auto lying = bytes;
  const auto encoded = encode(trailer);
  std::copy(encoded.begin(), encoded.end(), lying.end() - static_cast<std::ptrdiff_t>(encoded.size()));
  LogReader reader = open_log(lying);
  CHECK(!reader.info().finished);
  CHECK(all_frames(reader) == frames);
}

TEST_CASE("a varint of more than 64 bits and one that ends early are errors") {
  const std::vector<std::uint8_t> longest = {0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0xFF, 0x01};
  dmx_log::Cursor good(longest);
  CHECK(good.varint() == UINT64_MAX);
  CHECK(good.ok());
  auto too_long = longest;
  too_long[9] = 0x02;
  dmx_log::Cursor bad(too_long);
  CHECK(bad.varint() == 0);
  CHECK(!bad.ok());
  const std::vector<std::uint8_t> open_end = {0x80, 0x80};
  dmx_log::Cursor ends(open_end);
  (void)ends.varint();
  CHECK(!ends.ok());
}

TEST_CASE("the index never holds more than 65,536 places and keeps the first and a constant stride") {
  dmx_log::IndexThinner index;
  for (std::uint64_t i = 0; i < 400'000; ++i) index.add({i, static_cast<DurationNs>(i)});
  const auto& entries = index.entries();
  REQUIRE(entries.size() <= dmx_log::kIndexEntriesMax);
  REQUIRE(entries.size() > dmx_log::kIndexEntriesMax / 2 - 2);
  for (std::size_t i = 0; i < entries.size(); ++i) REQUIRE(entries[i].offset == i * 8);
}

// 20,000 inputs, the same each time: logs with bytes flipped, removed, duplicated or overwritten; half of them read
// with the checksums ignored, so that the damage reaches the decoder; and the contents of blocks, past the compression.
TEST_CASE("20,000 mutated logs are read without a crash") {
  const auto base = small_log(few_frames());
  const auto other = log_bytes(random_frames(12, 200, 4), kNsPerS);
  dmx_log::BlockEncoder encoder;
  const auto frames = random_frames(13, 150, 3);
  for (const OwnedFrame& frame : frames) encoder.add(frame.time_ns, frame.view(), true);
  const auto frame_count = encoder.frame_count();
  std::vector<std::uint8_t> raw;
  encoder.encode(raw);

  Random random(2026);
  const auto mutate = [&](std::vector<std::uint8_t> bytes) {
    for (int rounds = random.between(1, 4); rounds > 0 && !bytes.empty(); --rounds) {
      const auto at = static_cast<std::ptrdiff_t>(random.below(bytes.size()));
      const auto left = static_cast<std::uint64_t>(static_cast<std::ptrdiff_t>(bytes.size()) - at);
      const auto count = static_cast<std::ptrdiff_t>(1 + random.below(std::min<std::uint64_t>(left, 64)));
      const auto begin = bytes.begin() + at;
      switch (random.below(7)) {
        case 0: bytes[static_cast<std::size_t>(at)] ^= static_cast<std::uint8_t>(1u << random.below(8)); break;
        case 1: bytes[static_cast<std::size_t>(at)] = random.byte(); break;
        case 2: bytes.resize(static_cast<std::size_t>(at)); break;
        case 3: bytes.erase(begin, begin + count); break;
        case 4: {
          const std::vector<std::uint8_t> part(begin, begin + count);
          bytes.insert(begin, part.begin(), part.end());
          break;
        }
        case 5: std::fill_n(begin, count, random.below(2) == 0 ? std::uint8_t{0xFF} : std::uint8_t{0}); break;
        default: {
          const auto from = random.below(other.size());
          const auto length = std::min<std::uint64_t>({64, other.size() - from, left});
          std::copy_n(other.begin() + static_cast<std::ptrdiff_t>(from), length, begin);
        }
      }
    }
    return bytes;
  };
  std::uint64_t read = 0;
  for (int i = 0; i < 8'000; ++i) read += exercise_log(mutate(base), i % 2 == 0);
  for (int i = 0; i < 12'000; ++i) exercise_block(mutate(raw), frame_count, 0, frames.back().time_ns);
  CHECK(read > 0);
}
