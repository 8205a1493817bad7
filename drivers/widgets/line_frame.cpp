#include "drivers/widgets/line_frame.h"

namespace footlight::drivers {

void LineFrameParser::reset() {
  in_frame_ = false;
  size_ = given_size_ = 0;
}

std::optional<LineFrameParser::Frame> LineFrameParser::give() {
  if (given_size_ == 0) {
    ++counters_.frames;
    if (size_ < frame_.size()) ++counters_.short_frames;
  } else if (size_ == frame_.size()) {
    --counters_.short_frames;  // it has grown to its full length
  }
  given_size_ = size_;
  return Frame{std::span(frame_).first(size_), stamp_ns_};
}

std::optional<LineFrameParser::Frame> LineFrameParser::take(const LineByte& byte) {
  if (byte.is_break) {
    std::optional<Frame> ended;
    if (in_frame_ && size_ > given_size_) ended = give();
    if (in_frame_ && size_ > 0) expected_size_ = size_;
    in_frame_ = true;
    size_ = given_size_ = 0;
    return ended;
  }
  if (!in_frame_) {
    ++counters_.stray_bytes;
    return std::nullopt;
  }
  if (byte.framing_error || byte.lost_before) {
    ++(byte.framing_error ? counters_.framing_errors : counters_.overruns);
    reset();
    return std::nullopt;
  }
  if (size_ == frame_.size()) {
    ++counters_.stray_bytes;
    return std::nullopt;
  }
  frame_[size_++] = byte.value;
  stamp_ns_ = byte.stamp_ns;
  if (size_ == frame_.size() || size_ == expected_size_) return give();
  return std::nullopt;
}

}  // namespace footlight::drivers
