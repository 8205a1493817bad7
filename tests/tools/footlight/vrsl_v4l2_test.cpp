// Video devices of the kernel, with a model of v4l2loopback in place of the system's calls.
#include <doctest/doctest.h>

#include <linux/videodev2.h>

#include <cerrno>
#include <cstring>
#include <deque>
#include <random>

#include "drivers/vrsl/grid.h"
#include "tests/support/must.h"
#include "tools/footlight/vrsl/v4l2_pictures.h"

namespace footlight::tools {
namespace {

using drivers::Picture;
using drivers::PictureStep;
using testing::must;

constexpr int kOutputFd = 50, kInputFd = 51;

// A loopback device: a picture that is written can be read once. It checks what the kernel would check.
class LoopbackModel final : public V4l2Calls {
 public:
  int open(const std::string& path, bool output) override {
    if (path != "/dev/video9" || gone) return -ENOENT;
    if (open_error != 0) return -open_error;
    ++opened;
    return output ? kOutputFd : kInputFd;
  }
  int close(int fd) override {
    ++closed;
    if (fd == kInputFd) streaming = false;
    return 0;
  }
  int control(int fd, unsigned long request, void* argument) override {
    if (gone) return -ENODEV;
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto& capability = *static_cast<v4l2_capability*>(argument);
        std::strcpy(reinterpret_cast<char*>(capability.card), "Model");
        capability.capabilities = V4L2_CAP_DEVICE_CAPS;
        capability.device_caps = capabilities;
        return 0;
      }
      case VIDIOC_G_FMT: return format_of(fd, *static_cast<v4l2_format*>(argument), false);
      case VIDIOC_S_FMT: return format_of(fd, *static_cast<v4l2_format*>(argument), true);
      case VIDIOC_S_PARM: return 0;
      case VIDIOC_REQBUFS: {
        auto& wanted = *static_cast<v4l2_requestbuffers*>(argument);
        if (wanted.type != V4L2_BUF_TYPE_VIDEO_CAPTURE || wanted.memory != V4L2_MEMORY_MMAP) return -EINVAL;
        wanted.count = 2;  // a device may give fewer
        buffers.assign(wanted.count, std::vector<std::uint8_t>(format.sizeimage));
        return 0;
      }
      case VIDIOC_QUERYBUF: {
        auto& buffer = *static_cast<v4l2_buffer*>(argument);
        if (buffer.index >= buffers.size()) return -EINVAL;
        buffer.length = format.sizeimage;
        buffer.m.offset = buffer.index * 4096;
        return 0;
      }
      case VIDIOC_QBUF: queued.push_back(static_cast<v4l2_buffer*>(argument)->index); return 0;
      case VIDIOC_STREAMON: streaming = *static_cast<int*>(argument) == V4L2_BUF_TYPE_VIDEO_CAPTURE; return 0;
      case VIDIOC_DQBUF: return take(*static_cast<v4l2_buffer*>(argument));
      default: return -ENOTTY;
    }
  }
  ssize_t write(int fd, const void* bytes, std::size_t size) override {
    if (gone) return -ENODEV;
    if (fd != kOutputFd || size != format.sizeimage) return -EINVAL;
    const auto* const first = static_cast<const std::uint8_t*>(bytes);
    waiting.emplace_back(first, first + size);
    return static_cast<ssize_t>(size);
  }
  void* map(int /*fd*/, std::size_t size, std::uint64_t offset) override {
    ++mapped;
    return size == format.sizeimage ? buffers[offset / 4096].data() : nullptr;
  }
  void unmap(void* /*memory*/, std::size_t /*size*/) override { --mapped; }
  int wait_readable(int /*fd*/, int /*wait_ms*/) override { return gone || (streaming && !waiting.empty()) ? 1 : 0; }

  bool gone = false;
  int open_error = 0;
  std::uint32_t capabilities = V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_READWRITE | V4L2_CAP_STREAMING;
  bool fixed_format = false;
  std::uint32_t buffer_flags = 0;
  v4l2_pix_format format = {};
  std::deque<std::vector<std::uint8_t>> waiting;
  int opened = 0, closed = 0, mapped = 0;
  bool streaming = false;

 private:
  int format_of(int fd, v4l2_format& wanted, bool set) {
    const std::uint32_t type = fd == kOutputFd ? V4L2_BUF_TYPE_VIDEO_OUTPUT : V4L2_BUF_TYPE_VIDEO_CAPTURE;
    if (wanted.type != type) return -EINVAL;
    if (set && fd == kOutputFd && !fixed_format) format = wanted.fmt.pix;
    if (format.width == 0) return -EINVAL;
    wanted.fmt.pix = format;  // a reader gets the format of the writer
    return 0;
  }
  int take(v4l2_buffer& buffer) {
    if (!streaming || waiting.empty() || queued.empty()) return -EAGAIN;
    buffer.index = queued.front();
    queued.pop_front();
    buffer.bytesused = static_cast<std::uint32_t>(waiting.front().size());
    buffer.flags = buffer_flags;
    std::copy(waiting.front().begin(), waiting.front().end(), buffers[buffer.index].begin());
    waiting.pop_front();
    return 0;
  }

  std::vector<std::vector<std::uint8_t>> buffers;
  std::deque<std::uint32_t> queued;
};

drivers::PictureTarget device_target(std::vector<EndpointOption> options = {}) {
  drivers::PictureTarget target;
  target.endpoint = "vrsl:1-3@/dev/video9";
  target.name = "/dev/video9";
  target.width = 960;
  target.height = 104;
  target.options = std::move(options);
  return target;
}

Picture grid_of(unsigned seed, std::vector<std::uint8_t>& levels) {
  std::mt19937 random(seed);
  levels.resize(std::size_t{3} * kSlotCountMax);
  for (std::uint8_t& level : levels) level = static_cast<std::uint8_t>(random());
  Picture picture;
  must(drivers::GridCodec::make({.width = 960, .height = 104})).encode(levels, picture);
  return picture;
}

std::string refusal_of(LoopbackModel& model, std::vector<EndpointOption> options = {}) {
  const auto output = open_v4l2_output(device_target(std::move(options)), model);
  return output ? std::string() : output.error().message;
}

bool contains(const std::string& text, const char* part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_CASE("pictures cross a loopback device as RGB exactly and as YUYV with at most two levels lost") {
  for (const char* const pixels : {"rgb", "yuyv"}) {
    CAPTURE(pixels);
    LoopbackModel model;
    const auto output = must(open_v4l2_output(device_target({{"pixels", pixels}}), model));
    const auto input = must(open_v4l2_input(device_target(), model));
    for (unsigned seed = 1; seed <= 5; ++seed) {  // more than there are buffers
      std::vector<std::uint8_t> sent, got(std::size_t{3} * kSlotCountMax);
      must(output->show(grid_of(seed, sent), 0));
      Picture picture;
      std::optional<DurationNs> time_ns;
      REQUIRE(must(input->next(picture, time_ns, kNsPerMs)) == PictureStep::kPicture);
      CHECK_FALSE(time_ns.has_value());
      drivers::GridReading reading;
      must(must(drivers::GridCodec::make({.width = 960, .height = 104})).decode(picture.view(), got, reading));
      int largest = 0;
      for (std::size_t i = 0; i < got.size(); ++i) largest = std::max(largest, std::abs(got[i] - sent[i]));
      CHECK(largest <= (std::string(pixels) == "rgb" ? 0 : 2));
    }
    Picture picture;
    std::optional<DurationNs> time_ns;
    CHECK(must(input->next(picture, time_ns, kNsPerMs)) == PictureStep::kNothing);
  }
}

TEST_CASE("a picture that the device marks as damaged is not returned") {
  LoopbackModel model;
  const auto output = must(open_v4l2_output(device_target(), model));
  const auto input = must(open_v4l2_input(device_target(), model));
  std::vector<std::uint8_t> levels;
  must(output->show(grid_of(1, levels), 0));
  model.buffer_flags = V4L2_BUF_FLAG_ERROR;
  Picture picture;
  std::optional<DurationNs> time_ns;
  CHECK(must(input->next(picture, time_ns, 0)) == PictureStep::kNothing);
}

TEST_CASE("a device that disappears is opened again, by output and input") {
  LoopbackModel model;
  const auto output = must(open_v4l2_output(device_target(), model));
  auto input = must(open_v4l2_input(device_target(), model));
  std::vector<std::uint8_t> levels;
  Picture picture;
  std::optional<DurationNs> time_ns;
  model.gone = true;
  CHECK(output->show(grid_of(1, levels), 0).error().code == ErrorCode::kIo);
  CHECK_FALSE(output->show(grid_of(1, levels), 0).has_value());
  CHECK(input->next(picture, time_ns, 0).error().code == ErrorCode::kIo);
  CHECK(input->next(picture, time_ns, 0).error().code == ErrorCode::kIo);
  model.gone = false;
  must(output->show(grid_of(1, levels), 0));
  CHECK(must(input->next(picture, time_ns, 0)) == PictureStep::kPicture);
  input.reset();
  CHECK(model.mapped == 0);
}

TEST_CASE("a device that returns with another format gets no picture until it has the format of the pictures") {
  LoopbackModel model;
  const auto output = must(open_v4l2_output(device_target(), model));
  std::vector<std::uint8_t> levels;
  const v4l2_pix_format own = model.format;
  model.gone = true;
  CHECK_FALSE(output->show(grid_of(1, levels), 0).has_value());
  model.gone = false;
  model.fixed_format = true;
  model.format.width = 640;
  model.format.height = 156;  // as many bytes
  for (int i = 0; i < 2; ++i) {
    CHECK(contains(output->show(grid_of(1, levels), 0).error().message, "another program fixed its format"));
  }
  CHECK(model.waiting.empty());
  model.format = own;
  must(output->show(grid_of(1, levels), 0));
  CHECK(model.waiting.size() == 1);
}

TEST_CASE("devices that cannot be used are refused with the reason and the next step") {
  LoopbackModel model;
  model.gone = true;
  CHECK(contains(refusal_of(model), "modprobe v4l2loopback"));
  model.gone = false;
  model.open_error = EACCES;
  CHECK(contains(refusal_of(model), "usermod -aG video"));
  model.open_error = 0;
  model.capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  CHECK(contains(refusal_of(model), "takes no pictures"));
  model.capabilities |= V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_READWRITE;
  model.fixed_format = true;
  model.format.width = 640;
  model.format.height = 480;
  model.format.pixelformat = V4L2_PIX_FMT_YUYV;
  CHECK(contains(refusal_of(model), "has 640x480 YUYV instead of 960x104 RGB3"));
  model.format.pixelformat = V4L2_PIX_FMT_MJPEG;
  CHECK(contains(open_v4l2_input(device_target(), model).error().message, "format MJPG; expected RGB3"));
  model.format = {};
  CHECK(contains(open_v4l2_input(device_target(), model).error().message, "start the program that writes"));
  CHECK(contains(refusal_of(model, {{"pixels", "bgr"}}), "rgb or yuyv"));
  CHECK(contains(refusal_of(model, {{"quality", "3"}}), "not an option"));
  CHECK(model.opened == model.closed);
}

TEST_CASE("without the device the system's calls give the same error") {
  drivers::PictureTarget target = device_target();
  target.name = "/dev/video-footlight-test";
  CHECK(open_v4l2_output(target).error().code == ErrorCode::kNotFound);
  CHECK(open_v4l2_input(target).error().code == ErrorCode::kNotFound);
  target.name = "/dev/null";
  CHECK(contains(open_v4l2_output(target).error().message, "is no video device"));
}

}  // namespace footlight::tools
