#include "tools/footlight/displays/clip.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace footlight::tools {
namespace {

// A picture is shown that much early: files round the times of pictures, and so do those who ask for them.
constexpr DurationNs kEarlyNs = 1000;
// Seeks begin so much before the picture when those from the picture itself came too late.
constexpr DurationNs kBackFirstNs = kNsPerS / 2;
constexpr int kTriesMax = 4;

}  // namespace

Result<std::unique_ptr<Clip>> Clip::open(const std::string& path) {
  FL_ASSIGN(auto reader, VideoReader::open(path));
  const std::string& transfer = reader->facts().transfer;
  if (transfer == "smpte2084" || transfer == "arib-std-b67") {
    return fail(ErrorCode::kUnsupported,
                "{}: its light is HDR ({}), which displays do not show; convert it to BT.709 with 8 bits", path,
                transfer);
  }
  std::unique_ptr<Clip> clip(new Clip(path, std::move(reader)));
  FL_ASSIGN(clip->times_, clip->reader_->read_times());
  clip->stands_for_.resize(clip->count());
  for (std::size_t i = 0; i < clip->count(); ++i) clip->stands_for_[i] = i;
  FL_ASSIGN(const std::optional<std::size_t> first, clip->decode_next());
  if (!first) {
    return fail(ErrorCode::kBadInput, "{}: none of its {} pictures can be decoded; export it again", path,
                clip->count());
  }
  clip->replace(0, *first, *first);
  return clip;
}

std::size_t Clip::index_at(DurationNs time_ns) const {
  const auto after = std::upper_bound(times_.starts_ns.begin(), times_.starts_ns.end(), time_ns + kEarlyNs);
  return static_cast<std::size_t>(std::max<std::ptrdiff_t>(after - times_.starts_ns.begin() - 1, 0));
}

Result<const drivers::Picture*> Clip::picture(std::size_t index) {
  // Decoding may find that another one is shown in its place.
  for (int tries = 0; decoded_ != stands_for_[index]; ++tries) {
    if (tries == kTriesMax) {
      return fail(ErrorCode::kBadInput, "{}: picture {} can be decoded at times only; export it again", path_, index);
    }
    FL_TRY(decode(stands_for_[index]));
  }
  return &picture_;
}

std::size_t Clip::replaced() const {
  std::size_t count = 0;
  for (std::size_t i = 0; i < stands_for_.size(); ++i) {
    if (stands_for_[i] != i) ++count;
  }
  return count;
}

void Clip::replace(std::size_t first, std::size_t end, std::size_t by) {
  for (std::size_t i = first; i < end; ++i) stands_for_[i] = by;
}

Result<std::optional<std::size_t>> Clip::decode_next() {
  std::optional<DurationNs> time_ns;
  FL_ASSIGN(const drivers::PictureStep step, reader_->next(picture_, time_ns, 0));
  decoded_.reset();
  if (step == drivers::PictureStep::kPicture) decoded_ = index_at(time_ns.value_or(0));
  return decoded_;
}

// After this the next picture is `index` or one before it, if the file has one there.
Status Clip::go_to(std::size_t index) {
  const DurationNs wanted_ns = times_.starts_ns[index];
  for (DurationNs back_ns = 0;; back_ns = back_ns == 0 ? kBackFirstNs : 4 * back_ns) {
    const DurationNs from_ns = std::max<DurationNs>(wanted_ns - back_ns, 0);
    FL_TRY(reader_->seek(from_ns));
    FL_ASSIGN(const std::optional<std::size_t> next, decode_next());
    if ((next && *next <= index) || from_ns == 0) return {};
  }
}

// Decodes until `index`. If the file goes past it, the pictures in between are lost, and replaced from then on.
Status Clip::decode(std::size_t index) {
  // From a key picture between here and there rather than through all pictures before.
  const auto keys = times_.keys.begin();
  const bool nearer =
      decoded_ && *decoded_ < index &&
      std::find(keys + static_cast<std::ptrdiff_t>(*decoded_) + 1, keys + static_cast<std::ptrdiff_t>(index) + 1,
                true) != keys + static_cast<std::ptrdiff_t>(index) + 1;
  const bool next = decoded_ && *decoded_ + 1 == index;
  if (!decoded_ || *decoded_ > index || (nearer && !next)) FL_TRY(go_to(index));
  std::optional<std::size_t> before;
  while (decoded_ && *decoded_ < index) {
    before = decoded_;
    FL_ASSIGN(decoded_, decode_next());
  }
  if (decoded_ == index) return {};
  const std::size_t end = decoded_.value_or(count());
  if (before) {
    replace(*before + 1, end, *before);
  } else if (decoded_) {  // the first whole picture comes after it
    replace(0, end, end);
  } else {
    return fail(ErrorCode::kBadInput, "{}: its pictures cannot be decoded any more; was it changed?", path_);
  }
  return {};
}

DurationNs clip_time_ns(const fixtures::DisplayVideo& video, DurationNs show_ns, DurationNs duration_ns) {
  const auto moved = static_cast<DurationNs>(std::llround(video.speed * static_cast<double>(show_ns)));
  const DurationNs time_ns = std::llround(video.start_s * 1e9) + moved;
  if (!video.loop) return std::clamp<DurationNs>(time_ns, 0, duration_ns - 1);
  const DurationNs rest_ns = time_ns % duration_ns;
  return rest_ns < 0 ? rest_ns + duration_ns : rest_ns;
}

}  // namespace footlight::tools
