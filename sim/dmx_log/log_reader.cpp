#include <algorithm>
#include <array>
#include <cerrno>
#include <map>
#include <mutex>
#include <optional>
#include <set>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zstd.h>

#include "sim/core/check.h"
#include "sim/dmx_log/block.h"
#include "sim/dmx_log/crc32c.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/format.h"
#include "sim/dmx_log/log_output.h"
#include "sim/file_kind.h"

namespace footlight {

using dmx_log::BlockHeader;
using dmx_log::Bytes;
using dmx_log::UniverseState;

static_assert(kLogBlockBytesMax == dmx_log::kRawBytesMax);

namespace {

constexpr std::size_t kScanBytes = 64u << 10;

class Input {
 public:
  virtual ~Input() = default;
  [[nodiscard]] virtual std::uint64_t size() const = 0;
  // Fills `out`; fails if the file has fewer bytes there.
  virtual Status read(std::uint64_t offset, std::span<std::uint8_t> out) const = 0;
};

// Uses pread, not a mapping: if the file is truncated while it is read, the result is an error instead of a signal.
class FileInput final : public Input {
 public:
  FileInput(int fd, std::uint64_t size, std::string path) : fd_(fd), size_(size), path_(std::move(path)) {}
  FileInput(const FileInput&) = delete;
  FileInput& operator=(const FileInput&) = delete;
  ~FileInput() override { ::close(fd_); }

  std::uint64_t size() const override { return size_; }
  Status read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    std::size_t done = 0;
    while (done < out.size()) {
      const ssize_t count = ::pread(fd_, out.data() + done, out.size() - done, static_cast<off_t>(offset + done));
      if (count < 0 && errno == EINTR) continue;
      if (count < 0) return dmx_log::fail_errno(errno, path_, "cannot read");
      if (count == 0) return fail(ErrorCode::kIo, "{}: became shorter while it was read", path_);
      done += static_cast<std::size_t>(count);
    }
    return {};
  }

 private:
  int fd_;
  std::uint64_t size_;
  std::string path_;
};

class MemoryInput final : public Input {
 public:
  explicit MemoryInput(Bytes bytes) : bytes_(std::move(bytes)) {}
  std::uint64_t size() const override { return bytes_.size(); }
  Status read(std::uint64_t offset, std::span<std::uint8_t> out) const override {
    FL_CHECK(offset <= bytes_.size() && out.size() <= bytes_.size() - offset);
    std::copy_n(bytes_.begin() + static_cast<std::ptrdiff_t>(offset), out.size(), out.begin());
    return {};
  }

 private:
  Bytes bytes_;
};

// What the readers of one log have met.
class SharedDamage {
 public:
  void add(const LogDamage& damage) {
    const std::lock_guard lock(mutex_);
    if (offsets_.size() == kLogDamageCountedMax || !offsets_.insert(damage.offset).second) return;
    ++met_.count;
    met_.bytes += damage.size_bytes;
    if (met_.first.size() < kLogDamageListedMax) met_.first.push_back(damage);
  }
  [[nodiscard]] LogReader::DamageMet met() const {
    const std::lock_guard lock(mutex_);
    return met_;
  }

 private:
  mutable std::mutex mutex_;
  std::set<std::uint64_t> offsets_;  // guarded by mutex_
  LogReader::DamageMet met_;         // guarded by mutex_
};

struct FoundBlock {
  std::uint64_t offset = 0;
  BlockHeader header;
  [[nodiscard]] std::uint64_t end() const { return offset + dmx_log::kBlockHeaderBytes + header.compressed_bytes; }
};

}  // namespace

struct LogReader::Impl {
  Impl(std::shared_ptr<const Input> input_in, std::string name, const LogReaderOptions& options_in)
      : input(std::move(input_in)), options(options_in), zstd(ZSTD_createDCtx(), &ZSTD_freeDCtx) {
    info.path = std::move(name);
    info.file_bytes = input->size();
  }

  void note_damage(std::uint64_t offset, std::uint64_t size_bytes, std::string what) {
    if (damage_offsets.size() == kLogDamageCountedMax) return;
    if (!damage_offsets.insert(offset).second) return;  // already recorded on an earlier pass
    ++info.damage_count;
    info.damage_bytes += size_bytes;
    shared_damage->add({offset, size_bytes, what});
    if (info.damage.size() < kLogDamageListedMax) info.damage.push_back({offset, size_bytes, std::move(what)});
  }

  Status open() {
    std::array<std::uint8_t, dmx_log::kFileHeaderFixedBytes> fixed{};
    const auto count = static_cast<std::size_t>(std::min<std::uint64_t>(fixed.size(), input->size()));
    if (count == 0) return fail(ErrorCode::kBadInput, "{}: is empty; expected a DMX log", info.path);
    const auto head = std::span(fixed).first(count);
    FL_TRY(input->read(0, head));
    FL_ASSIGN(const auto header, read_header(head));
    if (header && header->version_major != dmx_log::kVersionMajor && options.check_checksums) return unsupported(head);
    if (header) take_header(*header);
    FL_TRY(read_tail());
    if (!header || !has_magic(head)) FL_TRY(do_without_header(head));
    if (!info.finished) FL_TRY(scan());
    at = first_block;
    return {};
  }

  static bool has_magic(std::span<const std::uint8_t> head) {
    const std::size_t count = std::min(head.size(), sizeof dmx_log::kFileMagic);
    return std::equal(head.begin(), head.begin() + static_cast<std::ptrdiff_t>(count), dmx_log::kFileMagic);
  }

  [[nodiscard]] tl::unexpected<Error> unsupported(std::span<const std::uint8_t> head) const {
    return fail(ErrorCode::kUnsupported, "{}: is a DMX log of version {}.{}, this program reads version {}.x",
                info.path, head[8] | head[9] << 8, head[10] | head[11] << 8, dmx_log::kVersionMajor);
  }

  // nullopt if the header is damaged or cut short.
  Result<std::optional<dmx_log::FileHeader>> read_header(std::span<const std::uint8_t> head) {
    const auto size = dmx_log::file_header_size(head);
    if (!size || *size > input->size()) return std::nullopt;
    Bytes bytes(*size);
    FL_TRY(input->read(0, bytes));
    auto header = dmx_log::decode_file_header(bytes, options.check_checksums);
    if (header) first_block = *size;
    return header;
  }

  // Blocks need only their start from the header. The search for the first block stops at the maximum length of a
  // header unless the file begins with the bytes of a log, so that other files are not read to their end.
  Status do_without_header(std::span<const std::uint8_t> head) {
    info.version_major = dmx_log::kVersionMajor;  // the only version whose blocks find_block() recognises
    first_block = dmx_log::kFileHeaderFixedBytes;
    const std::uint64_t search_end =
        has_magic(head) ? UINT64_MAX : dmx_log::kFileHeaderBytesMax + dmx_log::kBlockHeaderBytes;
    FL_ASSIGN(const auto block, find_block(first_block, search_end, false));
    if (block) first_block = block->offset;
    if (block || info.finished) {
      note_damage(0, first_block, "the header is damaged: the start of the recording is unknown");
      return {};
    }
    if (!has_magic(head)) {
      return fail(ErrorCode::kBadInput, "{}: is not a DMX log: it does not begin with the bytes of one{}", info.path,
                  head[0] == 'O' ? "; an OLA Show must be converted first" : "");
    }
    if (head.size() < dmx_log::kFileHeaderFixedBytes) {
      return fail(ErrorCode::kBadInput, "{}: ends inside its header, at byte {}; it holds no frame", info.path,
                  head.size());
    }
    if ((head[8] | head[9] << 8) != dmx_log::kVersionMajor) return unsupported(head);
    return fail(ErrorCode::kBadInput, "{}: the header is damaged or cut short and no block follows; it holds no frame",
                info.path);
  }

  void take_header(dmx_log::FileHeader header) {
    info.version_major = header.version_major;
    info.version_minor = header.version_minor;
    info.origin_ns = header.origin_ns;
    info.wall_start_unix_ns = header.wall_start_unix_ns;
    std::sort(header.universes.begin(), header.universes.end());
    for (const Universe universe : header.universes) {
      if (info.universes.empty() || info.universes.back().universe != universe) {
        info.universes.push_back({});
        info.universes.back().universe = universe;
      }
    }
  }

  // If the index is valid the file is finished; otherwise blocks reach up to the end of the file.
  Status read_tail() {
    data_end = input->size();
    if (input->size() < first_block + dmx_log::kTrailerBytes) return {};
    std::array<std::uint8_t, dmx_log::kTrailerBytes> tail{};
    const std::uint64_t tail_offset = input->size() - tail.size();
    FL_TRY(input->read(tail_offset, tail));
    const auto trailer = dmx_log::decode_trailer(tail, options.check_checksums);
    if (!trailer) return {};
    if (trailer->index_offset < dmx_log::kFileHeaderFixedBytes || trailer->index_offset > tail_offset ||
        tail_offset - trailer->index_offset != trailer->index_bytes) {
      return {};
    }
    Bytes bytes(trailer->index_bytes);
    FL_TRY(input->read(trailer->index_offset, bytes));
    const auto index = dmx_log::decode_index(bytes, options.check_checksums);
    if (!index) {
      note_damage(trailer->index_offset, bytes.size(), "the index is damaged");
      data_end = trailer->index_offset;
      return {};
    }
    for (const dmx_log::IndexEntry& entry : index->entries) {
      if (entry.offset < dmx_log::kFileHeaderFixedBytes || entry.offset >= trailer->index_offset) {
        note_damage(trailer->index_offset, bytes.size(), "the index names places outside the file");
        return {};
      }
    }
    data_end = trailer->index_offset;
    info.finished = true;
    info.duration_ns = index->end_ns;
    info.frames = index->frames;
    info.changes = index->changes;
    info.blocks = index->blocks;
    info.late_stamps = index->late_stamps;
    entries = index->entries;
    std::map<Universe, LogUniverseInfo> merged;
    for (const LogUniverseInfo& universe : info.universes) merged[universe.universe] = universe;
    for (const dmx_log::IndexUniverse& universe : index->universes) {
      merged[universe.universe] = {universe.universe,   universe.frames,   universe.changes,
                                   universe.slot_count, universe.first_ns, universe.last_ns};
    }
    info.universes.clear();
    for (const auto& [number, universe] : merged) info.universes.push_back(universe);
    return {};
  }

  // For an unfinished log: from header to header.
  Status scan() {
    dmx_log::IndexThinner index;
    DurationNs newest_ns = 0;
    std::uint64_t offset = first_block;
    while (true) {
      FL_ASSIGN(const std::optional<FoundBlock> block, find_block(offset));
      if (!block) break;
      offset = block->end();
      if (block->header.first_ns < newest_ns) continue;  // next_block() reports it
      newest_ns = block->header.last_ns;
      index.add({block->offset, block->header.first_ns});
      ++info.blocks;
      info.frames += block->header.frame_count;
    }
    info.duration_ns = newest_ns;
    entries = index.entries();
    return {};
  }

  Result<std::optional<FoundBlock>> block_at(std::uint64_t offset) {
    if (offset > data_end || data_end - offset < dmx_log::kBlockHeaderBytes) return std::nullopt;
    std::array<std::uint8_t, dmx_log::kBlockHeaderBytes> bytes{};
    FL_TRY(input->read(offset, bytes));
    const auto header = dmx_log::decode_block_header(bytes, options.check_checksums);
    if (!header) return std::nullopt;
    return FoundBlock{offset, *header};
  }

  // The first block at or after `offset` that lies whole before data_end. Skipped bytes are recorded as damage. The
  // search stops at `search_end`.
  Result<std::optional<FoundBlock>> find_block(std::uint64_t offset, std::uint64_t search_end = UINT64_MAX,
                                               bool note = true) {
    if (offset >= data_end) return std::nullopt;
    FL_ASSIGN(std::optional<FoundBlock> block, block_at(offset));
    if (block && block->end() <= data_end) return block;
    const bool torn = block.has_value();
    // Search for the next header. Its checksum distinguishes it from the same four bytes inside compressed levels.
    Bytes window;
    constexpr std::array<std::uint8_t, 4> kMagic = {dmx_log::kBlockMagic & 0xFF, dmx_log::kBlockMagic >> 8 & 0xFF,
                                                    dmx_log::kBlockMagic >> 16 & 0xFF, dmx_log::kBlockMagic >> 24};
    std::uint64_t from = offset + 1;
    while (from < data_end && data_end - from >= dmx_log::kBlockHeaderBytes) {
      if (from >= search_end) return std::nullopt;
      window.resize(static_cast<std::size_t>(std::min<std::uint64_t>(kScanBytes, data_end - from)));
      FL_TRY(input->read(from, window));
      auto place = window.begin();
      while (true) {
        place = std::search(place, window.end(), kMagic.begin(), kMagic.end());
        if (place == window.end()) break;
        const std::uint64_t candidate = from + static_cast<std::uint64_t>(place - window.begin());
        FL_ASSIGN(std::optional<FoundBlock> found, block_at(candidate));
        if (found && found->end() <= data_end) {
          if (note) note_damage(offset, candidate - offset, torn ? "the block is cut short" : "no block begins here");
          return found;
        }
        ++place;
      }
      from += window.size() - (kMagic.size() - 1);
      if (window.size() < kScanBytes) break;
    }
    if (note) {
      note_damage(offset, data_end - offset,
                  torn ? "the file ends inside this block" : "the file ends with bytes that are no block");
    }
    return std::nullopt;
  }

  // Reads and decodes the block. False: it is damaged, which is recorded.
  Result<bool> load(const FoundBlock& block) {
    const std::uint64_t size_bytes = block.end() - block.offset;
    packed.resize(block.header.compressed_bytes);
    FL_TRY(input->read(block.offset + dmx_log::kBlockHeaderBytes, packed));
    if (options.check_checksums && dmx_log::crc32c(packed) != block.header.payload_crc) {
      note_damage(block.offset, size_bytes, "the checksum of the block is wrong");
      return false;
    }
    // Checked before memory is allocated, because a damaged header may have any size.
    const unsigned long long content = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (content != block.header.raw_bytes) {
      note_damage(block.offset, size_bytes, "the compressed part has another length than the block header");
      return false;
    }
    raw.resize(block.header.raw_bytes);
    const std::size_t size = ZSTD_decompressDCtx(zstd.get(), raw.data(), raw.size(), packed.data(), packed.size());
    if (ZSTD_isError(size) != 0 || size != raw.size()) {
      note_damage(block.offset, size_bytes, "the block does not decompress");
      return false;
    }
    const Status status = loading.load(raw, block.header.frame_count, block.header.first_ns, block.header.last_ns);
    if (!status) {
      note_damage(block.offset, size_bytes, status.error().message);
      return false;
    }
    return true;
  }

  // Loads the next valid block, in order. False at the end.
  Result<bool> next_block() {
    while (true) {
      FL_ASSIGN(const std::optional<FoundBlock> block, find_block(at));
      if (!block) {
        at = data_end;
        return false;
      }
      at = block->end();
      if (block->header.first_ns < time_ns) {
        note_damage(block->offset, block->end() - block->offset, "the block is earlier than the one before it");
        continue;
      }
      // `decoder` refers to `raw`, which load() overwrites: the old block has no frames left to read. Its states stay:
      // changes inside damage are reported when the next valid block comes.
      FL_ASSIGN(const bool sound, load(*block));
      if (!sound) continue;
      current = *block;
      std::swap(decoder, loading);
      find_restored(loading.states());
      return true;
    }
  }

  // Finds where the block's start differs from the universes' state after the last block. Without damage there is no
  // difference.
  void find_restored(const std::vector<UniverseState>& was_states) {
    restored.clear();
    std::map<Universe, const UniverseState*> old;
    for (const UniverseState& state : was_states) {
      if (state.seen) old[state.universe] = &state;
    }
    for (std::size_t i = 0; i < decoder.states().size(); ++i) {
      const UniverseState& state = decoder.states()[i];
      if (!state.seen) continue;
      const auto known = old.find(state.universe);
      if (known == old.end()) {
        restored.push_back({i, Slots{}});
      } else if (const UniverseState& was = *known->second;
                 was.levels != state.levels || was.slot_count != state.slot_count ||
                 was.terminated != state.terminated || was.priority != state.priority || was.sender != state.sender) {
        restored.push_back({i, was.levels});
      }
    }
    std::reverse(restored.begin(), restored.end());  // taken from the end
  }

  void fill(LogFrame& frame, const UniverseState& state, DurationNs frame_time_ns, bool changed) {
    frame = {};
    frame.time_ns = frame_time_ns;
    frame.stamp_ns = info.origin_ns + frame_time_ns;
    frame.universe = state.universe;
    frame.sender = state.sender;
    frame.sequence = state.sequence;
    frame.priority = state.priority;
    frame.terminated = state.terminated;
    frame.slot_count = state.slot_count;
    frame.levels = state.levels;
    runs.clear();
    if (changed) {
      for (std::size_t slot = 0; slot < state.levels.size(); ++slot) {
        if (state.levels[slot] == before[slot]) continue;
        if (!runs.empty() && std::size_t{runs.back().first} + runs.back().count == slot) {
          ++runs.back().count;
        } else {
          runs.push_back({static_cast<std::uint16_t>(slot), 1});
        }
      }
    }
    frame.changes = runs;
  }

  // Applies the next frame of the loaded block. nullopt if there is none, or the block breaks off.
  std::optional<dmx_log::BlockDecoder::Step> step() {
    if (!decoder.has_next()) return std::nullopt;
    const DurationNs next_ns = decoder.next_time_ns();
    const auto result = decoder.next(before);
    if (!result) {
      note_damage(current.offset, current.end() - current.offset, result.error().message);
      decoder.clear_frames();
      return std::nullopt;
    }
    time_ns = next_ns;
    return *result;
  }

  Result<bool> next(LogFrame& frame) {
    while (true) {
      if (!restored.empty()) {
        const auto [index, was] = restored.back();
        restored.pop_back();
        before = was;
        time_ns = current.header.first_ns;
        if (time_ns <= floor_ns) continue;
        fill(frame, decoder.states()[index], time_ns, true);
        frame.restored = true;
        return true;
      }
      if (const auto taken = step()) {
        if (time_ns <= floor_ns) continue;  // only if damage misled seek()
        fill(frame, decoder.states()[taken->index], time_ns, taken->changed);
        return true;
      }
      FL_ASSIGN(const bool more, next_block());
      if (!more) return false;
    }
  }

  void rewind() {
    at = first_block;
    time_ns = 0;
    floor_ns = -1;
    restored.clear();
    decoder.clear();
  }

  Status seek(DurationNs target_ns) {
    rewind();
    floor_ns = target_ns;
    // Start with the last entry at or before the target; from there the headers lead to the last such block.
    auto entry = std::upper_bound(entries.begin(), entries.end(), target_ns,
                                  [](DurationNs value, const dmx_log::IndexEntry& e) { return value < e.first_ns; });
    std::uint64_t end = data_end;  // blocks from here on are not usable
    while (end > first_block) {
      // A block may also lie before the first entry if bytes are missing and the index no longer fits.
      const std::uint64_t from = entry == entries.begin() ? first_block : (--entry)->offset;
      FL_ASSIGN(const bool found, load_last(from, end, target_ns));
      if (found) {
        while (decoder.has_next() && decoder.next_time_ns() <= target_ns && step()) {
        }
        return {};
      }
      if (from <= first_block) break;
      end = std::min(end, from);
    }
    return {};
  }

  // Loads the last valid block that starts in the file from `from` to before `end`, and in time at or before target_ns.
  Result<bool> load_last(std::uint64_t from, std::uint64_t end, DurationNs target_ns) {
    std::vector<FoundBlock> candidates;
    DurationNs newest_ns = 0;
    for (std::uint64_t offset = from; offset < end;) {
      FL_ASSIGN(const std::optional<FoundBlock> block, find_block(offset, end));
      if (!block || block->offset >= end || block->header.first_ns > target_ns) break;
      offset = block->end();
      if (block->header.first_ns < newest_ns) continue;  // out of order, as in next_block()
      newest_ns = block->header.last_ns;
      candidates.push_back(*block);
    }
    for (; !candidates.empty(); candidates.pop_back()) {
      FL_ASSIGN(const bool sound, load(candidates.back()));
      if (!sound) continue;
      current = candidates.back();
      at = current.end();
      time_ns = current.header.first_ns;
      std::swap(decoder, loading);
      return true;
    }
    return false;
  }

  std::span<const LogSnapshot> snapshot() {
    snapshots.clear();
    for (const UniverseState& state : decoder.states()) {
      if (!state.seen) continue;
      snapshots.push_back({state.universe, state.time_ns, state.sender, state.sequence, state.priority,
                           state.terminated, state.slot_count, state.levels});
    }
    std::sort(snapshots.begin(), snapshots.end(),
              [](const LogSnapshot& a, const LogSnapshot& b) { return a.universe < b.universe; });
    return snapshots;
  }

  std::shared_ptr<const Input> input;  // of all readers of this log; its reads change nothing
  LogReaderOptions options;
  LogInfo info;
  std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> zstd;
  std::set<std::uint64_t> damage_offsets;
  std::shared_ptr<SharedDamage> shared_damage = std::make_shared<SharedDamage>();  // of all readers of this log

  std::uint64_t first_block = dmx_log::kFileHeaderFixedBytes;  // the earliest possible start, until the header was read
  std::uint64_t data_end = 0;
  std::vector<dmx_log::IndexEntry> entries;

  std::uint64_t at = 0;      // where the search for the next block starts
  DurationNs time_ns = 0;    // of the newest frame returned
  DurationNs floor_ns = -1;  // frames up to here are included in the state that seek() restored
  FoundBlock current;
  Bytes packed, raw;
  dmx_log::BlockDecoder decoder, loading;
  std::vector<std::pair<std::size_t, Slots>> restored;  // states of `decoder` to report, with the levels they had
  Slots before{};
  std::vector<SlotRun> runs;
  std::vector<LogSnapshot> snapshots;
};

LogReader::LogReader(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LogReader::LogReader(LogReader&&) noexcept = default;
LogReader& LogReader::operator=(LogReader&&) noexcept = default;
LogReader::~LogReader() = default;

Result<LogReader> LogReader::open(const std::string& path, const LogReaderOptions& options) {
  FL_TRY(refuse_pipe_input(path));
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return dmx_log::fail_open(errno, path);
  struct stat status {};
  const bool known = ::fstat(fd, &status) == 0;
  auto input = std::make_shared<FileInput>(fd, known ? static_cast<std::uint64_t>(status.st_size) : 0, path);
  if (!known) return dmx_log::fail_errno(errno, path, "cannot read");
  if (!S_ISREG(status.st_mode)) return fail(ErrorCode::kBadInput, "{}: is not a regular file", path);
  auto impl = std::make_unique<Impl>(std::move(input), path, options);
  FL_TRY(impl->open());
  return LogReader(std::move(impl));
}

Result<LogReader> LogReader::open_bytes(std::vector<std::uint8_t> bytes, const std::string& name,
                                        const LogReaderOptions& options) {
  auto impl = std::make_unique<Impl>(std::make_shared<MemoryInput>(std::move(bytes)), name, options);
  FL_TRY(impl->open());
  return LogReader(std::move(impl));
}

LogReader LogReader::again() const {
  auto impl = std::make_unique<Impl>(impl_->input, impl_->info.path, impl_->options);
  impl->info = impl_->info;
  impl->damage_offsets = impl_->damage_offsets;
  impl->shared_damage = impl_->shared_damage;
  impl->first_block = impl_->first_block;
  impl->data_end = impl_->data_end;
  impl->entries = impl_->entries;
  impl->rewind();
  return LogReader(std::move(impl));
}

const LogInfo& LogReader::info() const { return impl_->info; }
LogReader::DamageMet LogReader::damage_met() const { return impl_->shared_damage->met(); }
Result<bool> LogReader::next(LogFrame& frame) { return impl_->next(frame); }
Status LogReader::seek(DurationNs time_ns) { return impl_->seek(time_ns); }
Status LogReader::rewind() {
  impl_->rewind();
  return {};
}
std::span<const LogSnapshot> LogReader::snapshot() { return impl_->snapshot(); }

}  // namespace footlight
