#include <algorithm>
#include <optional>
#include <utility>

#include <zstd.h>

#include "sim/core/check.h"
#include "sim/dmx_log/block.h"
#include "sim/dmx_log/crc32c.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/format.h"
#include "sim/dmx_log/log_output.h"

namespace footlight {

using dmx_log::Bytes;

namespace {

constexpr DurationNs kPauseNs = 2 * kNsPerMs;  // between frames: not within a burst

}  // namespace

struct LogWriter::Impl {
  Impl(std::unique_ptr<dmx_log::LogOutput> output_in, const LogWriterOptions& options_in)
      : output(std::move(output_in)), options(options_in), zstd(ZSTD_createCCtx(), &ZSTD_freeCCtx) {}

  Status write(const Bytes& bytes) {
    const Status status = output->write(bytes);
    if (status) {
      stats.bytes += bytes.size();
    } else {
      error = status.error();
    }
    return status;
  }

  Status write_block() {
    if (encoder.empty()) return {};
    dmx_log::BlockHeader header;
    header.frame_count = encoder.frame_count();
    header.number = static_cast<std::uint32_t>(stats.blocks);
    header.first_ns = encoder.first_ns();
    header.last_ns = encoder.last_ns();
    encoder.encode(raw);
    FL_CHECK_LE(raw.size(), dmx_log::kRawBytesMax);
    header.raw_bytes = static_cast<std::uint32_t>(raw.size());
    packed.resize(dmx_log::kBlockHeaderBytes + ZSTD_compressBound(raw.size()));
    const std::size_t size = ZSTD_compressCCtx(zstd.get(), packed.data() + dmx_log::kBlockHeaderBytes,
                                               packed.size() - dmx_log::kBlockHeaderBytes, raw.data(), raw.size(),
                                               options.compression_level);
    if (ZSTD_isError(size) != 0) {
      error = Error{ErrorCode::kIo, fmt::format("{}: cannot compress: {}", output->path(), ZSTD_getErrorName(size))};
      return tl::unexpected<Error>(*error);
    }
    packed.resize(dmx_log::kBlockHeaderBytes + size);
    header.compressed_bytes = static_cast<std::uint32_t>(size);
    header.payload_crc = dmx_log::crc32c(std::span(packed).subspan(dmx_log::kBlockHeaderBytes));
    const Bytes head = encode(header);
    std::copy(head.begin(), head.end(), packed.begin());
    const std::uint64_t offset = stats.bytes;
    FL_TRY(write(packed));
    if (options.sync_blocks) {
      if (const Status status = output->sync(); !status) {
        error = status.error();
        return status;
      }
    }
    index.add({offset, header.first_ns});
    ++stats.blocks;
    return {};
  }

  bool block_is_full(DurationNs time_ns) const {
    if (encoder.empty()) return false;
    const std::size_t base = encoder.base_bytes_bound();
    // With many universes the block's base is large. The block must hold enough changes to be efficient, but fit the
    // limit of the format.
    const std::size_t limit = std::min(base + std::max(options.block_bytes, 4 * base), dmx_log::kRawBytesMax - 4096);
    if (encoder.raw_bytes_bound() > limit) return true;
    // A player decompresses a block in the pause before it. Frames of several universes come in bursts: wait shortly
    // for the end of one.
    const DurationNs age_ns = time_ns - encoder.first_ns();
    const bool pause = time_ns - encoder.last_ns() >= kPauseNs;
    return age_ns >= options.block_span_ns && (pause || age_ns >= options.block_span_ns + options.block_span_ns / 4);
  }

  std::unique_ptr<dmx_log::LogOutput> output;
  LogWriterOptions options;
  std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> zstd;
  dmx_log::BlockEncoder encoder;
  dmx_log::IndexThinner index;
  std::vector<dmx_log::IndexUniverse> universes;  // in the order of encoder.states()
  LogWriterStats stats;
  DurationNs last_ns = 0;
  Bytes raw, packed;
  std::optional<Error> error;  // the first error; every later call returns it
  bool closed = false;
};

LogWriter::LogWriter(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
LogWriter::LogWriter(LogWriter&&) noexcept = default;
LogWriter& LogWriter::operator=(LogWriter&&) noexcept = default;

LogWriter::~LogWriter() {
  if (impl_ && !impl_->closed && !impl_->error) (void)impl_->write_block();  // a destructor cannot report an error
}

Result<LogWriter> LogWriter::create(const std::string& path, const LogWriterOptions& options) {
  FL_ASSIGN(auto output, dmx_log::open_file_output(path, options.overwrite));
  return dmx_log::make_writer(std::move(output), options);
}

namespace {

Status check_options(const std::string& path, LogWriterOptions& options) {
  if (options.block_span_ns <= 0 || options.block_span_ns > dmx_log::kTimeLimitNs) {
    return fail(ErrorCode::kBadInput, "{}: expected a block span above 0 ns, got {} ns", path, options.block_span_ns);
  }
  if (options.compression_level < 1 || options.compression_level > 19) {
    return fail(ErrorCode::kBadInput, "{}: expected a compression level from 1 to 19, got {}", path,
                options.compression_level);
  }
  if (options.origin_ns < -dmx_log::kTimeLimitNs || options.origin_ns > dmx_log::kTimeLimitNs) {
    return fail(ErrorCode::kBadInput, "{}: the start of the recording, {} ns, is out of range", path,
                options.origin_ns);
  }
  for (const Universe universe : options.universes) {
    if (!is_universe(universe)) {
      return fail(ErrorCode::kBadInput, "{}: expected universes from 1 to {}, got {}", path, kUniverseMax, universe);
    }
  }
  std::sort(options.universes.begin(), options.universes.end());
  options.universes.erase(std::unique(options.universes.begin(), options.universes.end()), options.universes.end());
  return {};
}

}  // namespace

// Outside the class, so that only this library can use a LogOutput of its own.
struct LogWriterMaker {
  static LogWriter make(std::unique_ptr<LogWriter::Impl> impl) { return LogWriter(std::move(impl)); }
  using Impl = LogWriter::Impl;
};

Result<LogWriter> dmx_log::make_writer(std::unique_ptr<LogOutput> output, const LogWriterOptions& options) {
  LogWriterOptions checked = options;
  FL_TRY(check_options(output->path(), checked));
  auto impl = std::make_unique<LogWriterMaker::Impl>(std::move(output), checked);
  FileHeader header;
  header.origin_ns = checked.origin_ns;
  header.wall_start_unix_ns = checked.wall_start_unix_ns;
  header.universes = checked.universes;
  FL_TRY(impl->write(encode(header)));
  return LogWriterMaker::make(std::move(impl));
}

Status LogWriter::append(const FrameView& frame) {
  if (impl_->error) return tl::unexpected<Error>(*impl_->error);
  FL_CHECK(!impl_->closed);
  FL_CHECK(is_universe(frame.universe));
  FL_CHECK_LE(frame.slots.size(), static_cast<std::size_t>(kSlotCountMax));
  if (frame.start_code != kStartCodeLevels) {
    ++impl_->stats.not_levels;
    return {};
  }
  DurationNs time_ns = impl_->last_ns;
  if (frame.stamp_ns > impl_->options.origin_ns + dmx_log::kTimeLimitNs) {
    return fail(ErrorCode::kBadInput, "{}: a frame is stamped {} ns, more than 73 years after the start",
                impl_->output->path(), frame.stamp_ns);
  }
  if (frame.stamp_ns < impl_->options.origin_ns + impl_->last_ns) {
    ++impl_->stats.late_stamps;
  } else {
    time_ns = frame.stamp_ns - impl_->options.origin_ns;
  }
  if (impl_->block_is_full(time_ns)) FL_TRY(impl_->write_block());

  const std::uint32_t frames_before = impl_->encoder.frame_count();
  const bool changed = impl_->encoder.add(time_ns, frame, impl_->options.keep_repeats);
  if (impl_->encoder.frame_count() == frames_before) {
    ++impl_->stats.repeats_dropped;
    return {};
  }
  impl_->last_ns = time_ns;
  ++impl_->stats.frames;
  impl_->stats.changes += changed ? 1 : 0;

  const auto index = static_cast<std::size_t>(impl_->encoder.find(frame.universe));
  if (index == impl_->universes.size()) {
    impl_->universes.push_back({frame.universe, 0, 0, 0, time_ns, time_ns});
  }
  dmx_log::IndexUniverse& universe = impl_->universes[index];
  ++universe.frames;
  universe.changes += changed ? 1 : 0;
  universe.last_ns = time_ns;
  universe.slot_count = std::max(universe.slot_count, static_cast<int>(impl_->encoder.states()[index].slot_count));
  return {};
}

Status LogWriter::tick(TimeNs now_ns) {
  if (impl_->error) return tl::unexpected<Error>(*impl_->error);
  if (impl_->encoder.empty()) return {};
  const TimeNs due_ns = impl_->options.origin_ns + impl_->encoder.first_ns() + impl_->options.block_span_ns;
  return now_ns >= due_ns ? impl_->write_block() : Status{};
}

Status LogWriter::flush() {
  if (impl_->error) return tl::unexpected<Error>(*impl_->error);
  return impl_->write_block();
}

Status LogWriter::close(TimeNs end_stamp_ns) {
  if (impl_->error) return tl::unexpected<Error>(*impl_->error);
  FL_CHECK(!impl_->closed);
  FL_TRY(impl_->write_block());
  dmx_log::Index index;
  const TimeNs origin_ns = impl_->options.origin_ns;
  index.end_ns = std::clamp(end_stamp_ns, origin_ns + impl_->last_ns, origin_ns + dmx_log::kTimeLimitNs) - origin_ns;
  index.frames = impl_->stats.frames;
  index.changes = impl_->stats.changes;
  index.blocks = impl_->stats.blocks;
  index.late_stamps = impl_->stats.late_stamps;
  index.universes = impl_->universes;
  std::sort(index.universes.begin(), index.universes.end(),
            [](const auto& a, const auto& b) { return a.universe < b.universe; });
  index.entries = impl_->index.entries();
  Bytes tail = encode(index);
  const Bytes trailer = encode(dmx_log::Trailer{impl_->stats.bytes, static_cast<std::uint32_t>(tail.size())});
  tail.insert(tail.end(), trailer.begin(), trailer.end());
  FL_TRY(impl_->write(tail));
  if (const Status status = impl_->output->finish(); !status) {
    impl_->error = status.error();
    return status;
  }
  impl_->closed = true;
  return {};
}

void LogWriter::discard() {
  FL_CHECK(!impl_->closed);
  impl_->output->discard();
  impl_->closed = true;
}

LogWriterStats LogWriter::stats() const { return impl_->stats; }
const std::string& LogWriter::written_path() const { return impl_->output->path(); }

}  // namespace footlight
