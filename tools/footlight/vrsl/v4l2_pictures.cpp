#include "tools/footlight/vrsl/v4l2_pictures.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <vector>

#include "drivers/vrsl/grid.h"
#include "tools/footlight/vrsl/yuv.h"

namespace footlight::tools {
namespace {

constexpr unsigned kBuffersWanted = 4;

class SystemV4l2Calls final : public V4l2Calls {
 public:
  int open(const std::string& path, bool output) override {
    const int fd = ::open(path.c_str(), (output ? O_WRONLY : O_RDWR | O_NONBLOCK) | O_CLOEXEC);
    return fd < 0 ? -errno : fd;
  }
  int close(int fd) override { return ::close(fd); }
  int control(int fd, unsigned long request, void* argument) override {
    while (true) {
      if (::ioctl(fd, request, argument) >= 0) return 0;
      if (errno != EINTR) return -errno;
    }
  }
  ssize_t write(int fd, const void* bytes, std::size_t size) override {
    const ssize_t written = ::write(fd, bytes, size);
    return written < 0 ? -errno : written;
  }
  void* map(int fd, std::size_t size, std::uint64_t offset) override {
    void* const memory = ::mmap(nullptr, size, PROT_READ, MAP_SHARED, fd, static_cast<off_t>(offset));
    return memory == MAP_FAILED ? nullptr : memory;
  }
  void unmap(void* memory, std::size_t size) override { ::munmap(memory, size); }
  int wait_readable(int fd, int wait_ms) override {
    pollfd waiting = {fd, POLLIN, 0};
    return std::max(0, ::poll(&waiting, 1, wait_ms));
  }
};

// An open device.
class V4l2Device {
 public:
  explicit V4l2Device(V4l2Calls& calls) : calls_(calls) {}
  ~V4l2Device() { close(); }
  V4l2Device(const V4l2Device&) = delete;
  V4l2Device& operator=(const V4l2Device&) = delete;

  Status open(const std::string& path, bool output) {
    close();
    const int fd = calls_.open(path, output);
    if (fd == -ENOENT || fd == -ENODEV || fd == -ENXIO) {
      return fail(ErrorCode::kNotFound, "there is no such device{}",
                  output ? "; v4l2loopback makes one: sudo modprobe v4l2loopback video_nr=9" : "");
    }
    if (fd == -EACCES || fd == -EPERM) {
      return fail(ErrorCode::kPermission,
                  "this user may not use it; run 'sudo usermod -aG video $USER' and log in again");
    }
    if (fd == -EBUSY) return fail(ErrorCode::kIo, "another program uses it");
    if (fd < 0) return fail(ErrorCode::kIo, "cannot be opened: {}", std::strerror(-fd));
    fd_ = fd;
    v4l2_capability capability = {};
    FL_TRY(control(VIDIOC_QUERYCAP, capability, "is no video device"));
    const std::uint32_t able =
        (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
    const std::uint32_t needed =
        output ? V4L2_CAP_VIDEO_OUTPUT | V4L2_CAP_READWRITE : V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
    if ((able & needed) == needed) return {};
    return fail(ErrorCode::kUnsupported, "\"{}\" {}", reinterpret_cast<const char*>(capability.card),
                output ? "takes no pictures; expected a v4l2loopback device" : "gives no pictures now");
  }
  void close() {
    if (fd_ >= 0) calls_.close(fd_);
    fd_ = -1;
  }
  template <class Argument>
  Status control(unsigned long request, Argument& argument, const char* refusal) {
    const int result = calls_.control(fd_, request, &argument);
    if (result >= 0) return {};
    if (result == -EBUSY) return fail(ErrorCode::kIo, "{}: another program uses it", refusal);
    return fail(result == -EINVAL || result == -ENOTTY ? ErrorCode::kUnsupported : ErrorCode::kIo, "{}: {}", refusal,
                std::strerror(-result));
  }
  [[nodiscard]] int fd() const { return fd_; }
  [[nodiscard]] V4l2Calls& calls() const { return calls_; }

 private:
  V4l2Calls& calls_;
  int fd_ = -1;
};

std::string text_of_pixels(std::uint32_t code) {
  std::string text;
  for (int shift = 0; shift < 32; shift += 8) {
    const auto letter = static_cast<char>(code >> shift & 0x7F);
    text += letter >= ' ' ? letter : '?';
  }
  return text;
}

class V4l2Output final : public drivers::PictureOutput {
 public:
  V4l2Output(const drivers::PictureTarget& target, bool yuyv, V4l2Calls& calls)
      : target_(target), yuyv_(yuyv), device_(calls) {}

  Status open() {
    FL_TRY(device_.open(target_.name, true));
    const auto width = static_cast<std::uint32_t>(target_.width);
    const auto height = static_cast<std::uint32_t>(target_.height);
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    v4l2_pix_format& pixels = format.fmt.pix;
    pixels.width = width;
    pixels.height = height;
    pixels.pixelformat = yuyv_ ? V4L2_PIX_FMT_YUYV : V4L2_PIX_FMT_RGB24;
    pixels.field = V4L2_FIELD_NONE;
    pixels.bytesperline = width * (yuyv_ ? 2 : 3);
    pixels.sizeimage = pixels.bytesperline * height;
    pixels.colorspace = yuyv_ ? V4L2_COLORSPACE_REC709 : V4L2_COLORSPACE_SRGB;
    pixels.quantization = yuyv_ ? V4L2_QUANTIZATION_LIM_RANGE : V4L2_QUANTIZATION_FULL_RANGE;
    const v4l2_pix_format wanted = pixels;
    FL_TRY(device_.control(VIDIOC_S_FMT, format, "refuses the format of the pictures"));
    if (pixels.width != wanted.width || pixels.height != wanted.height || pixels.pixelformat != wanted.pixelformat ||
        pixels.bytesperline != wanted.bytesperline) {
      return fail(ErrorCode::kUnsupported,
                  "has {}x{} {} instead of {}x{} {}: another program fixed its format; end that program, or name its "
                  "size: ?size={}x{}",
                  pixels.width, pixels.height, text_of_pixels(pixels.pixelformat), wanted.width, wanted.height,
                  text_of_pixels(wanted.pixelformat), pixels.width, pixels.height);
    }
    v4l2_streamparm rate = {};
    rate.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    rate.parm.output.timeperframe = {1'000, static_cast<std::uint32_t>(std::lround(target_.pictures_hz * 1'000))};
    (void)device_.control(VIDIOC_S_PARM, rate, "rate");  // only for readers that ask for it
    return {};
  }

  Status show(const drivers::Picture& picture, DurationNs /*time_ns*/) override {
    if (device_.fd() < 0) {
      const Status opened = open();
      if (!opened) {
        device_.close();  // its format may be another one
        return opened;
      }
    }
    const std::vector<std::uint8_t>& bytes = yuyv_ ? pack(picture) : picture.rgb;
    const ssize_t written = device_.calls().write(device_.fd(), bytes.data(), bytes.size());
    if (written == static_cast<ssize_t>(bytes.size())) return {};
    if (written == -ENODEV) device_.close();  // removed: opened again with the next picture
    return fail(ErrorCode::kIo, "a picture was not taken: {}",
                written < 0 ? std::strerror(static_cast<int>(-written)) : "only a part was written");
  }

 private:
  const std::vector<std::uint8_t>& pack(const drivers::Picture& picture) {
    const auto width = static_cast<std::size_t>(picture.width);
    const auto height = static_cast<std::size_t>(picture.height);
    luma_.resize(width * height);
    u_.resize(width * height / 4);
    v_.resize(width * height / 4);
    packed_.resize(2 * width * height);
    const auto stride = static_cast<std::ptrdiff_t>(width);
    to_yuv_.convert(picture.view(), {{luma_.data(), u_.data(), v_.data()}, {stride, stride / 2, stride / 2}});
    for (std::size_t i = 0; i < width * height; i += 2) {
      const std::size_t chroma = i / width / 2 * (width / 2) + i % width / 2;
      packed_[2 * i] = luma_[i];
      packed_[2 * i + 1] = u_[chroma];
      packed_[2 * i + 2] = luma_[i + 1];
      packed_[2 * i + 3] = v_[chroma];
    }
    return packed_;
  }

  const drivers::PictureTarget target_;
  const bool yuyv_;
  V4l2Device device_;
  RgbToYuv to_yuv_{YuvCoding{}};
  std::vector<std::uint8_t> luma_, u_, v_, packed_;
};

// The pixels of a format in a buffer. nullopt: not supported.
struct PixelLayout {
  YuvView view;
  std::size_t bytes = 0;  // of a whole picture
  bool is_rgb = false;
};

std::optional<PixelLayout> layout_of(const v4l2_pix_format& pixels) {
  PixelLayout layout;
  layout.view.width = static_cast<int>(pixels.width);
  layout.view.height = static_cast<int>(pixels.height);
  const std::size_t height = pixels.height;
  const auto line = [&](std::uint32_t least) { return std::size_t{std::max(pixels.bytesperline, least)}; };
  switch (pixels.pixelformat) {
    case V4L2_PIX_FMT_RGB24:
      layout.is_rgb = true;
      layout.view.strides[0] = static_cast<std::ptrdiff_t>(line(3 * pixels.width));
      layout.bytes = line(3 * pixels.width) * height;
      return layout;
    case V4L2_PIX_FMT_YUYV:
    case V4L2_PIX_FMT_UYVY: {
      const auto stride = static_cast<std::ptrdiff_t>(line(2 * pixels.width));
      layout.view.strides = {stride, stride, stride};
      layout.view.steps = {2, 4, 4};
      layout.view.shift_y = 0;
      layout.bytes = line(2 * pixels.width) * height;
      return layout;
    }
    case V4L2_PIX_FMT_YUV420: {
      const std::size_t stride = line(pixels.width);
      const std::size_t chroma_stride = (stride + 1) / 2;
      layout.view.strides = {static_cast<std::ptrdiff_t>(stride), static_cast<std::ptrdiff_t>(chroma_stride),
                             static_cast<std::ptrdiff_t>(chroma_stride)};
      layout.bytes = stride * height + 2 * chroma_stride * ((height + 1) / 2);
      return layout;
    }
    default: return std::nullopt;
  }
}

YuvCoding coding_of(const v4l2_pix_format& pixels) {
  YuvCoding coding;
  coding.full_range = pixels.quantization == V4L2_QUANTIZATION_FULL_RANGE;
  const bool is_709 = pixels.ycbcr_enc == V4L2_YCBCR_ENC_709 ||
                      (pixels.ycbcr_enc == V4L2_YCBCR_ENC_DEFAULT && pixels.colorspace == V4L2_COLORSPACE_REC709);
  coding.matrix = is_709 ? YuvMatrix::kBt709 : YuvMatrix::kBt601;  // the default of V4L2's other colour spaces
  return coding;
}

class V4l2Input final : public drivers::PictureInput {
 public:
  V4l2Input(const drivers::PictureTarget& target, V4l2Calls& calls) : target_(target), device_(calls) {}
  ~V4l2Input() override { release(); }

  Status open() {
    FL_TRY(device_.open(target_.name, false));
    FL_TRY(choose_format());
    v4l2_requestbuffers request = {};
    request.count = kBuffersWanted;
    request.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    request.memory = V4L2_MEMORY_MMAP;
    FL_TRY(device_.control(VIDIOC_REQBUFS, request, "gives no buffers"));
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer = buffer_of(i);
      FL_TRY(device_.control(VIDIOC_QUERYBUF, buffer, "does not describe its buffers"));
      void* const memory = device_.calls().map(device_.fd(), buffer.length, buffer.m.offset);
      if (memory == nullptr) return fail(ErrorCode::kIo, "its buffers cannot be mapped");
      buffers_.push_back({memory, buffer.length});
      FL_TRY(device_.control(VIDIOC_QBUF, buffer, "takes no buffer"));
    }
    if (buffers_.empty()) return fail(ErrorCode::kIo, "gives no buffers");
    int type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    return device_.control(VIDIOC_STREAMON, type, "does not start");
  }

  Result<drivers::PictureStep> next(drivers::Picture& picture, std::optional<DurationNs>& /*time_ns*/,
                                    DurationNs wait_ns) override {
    if (device_.fd() < 0) {
      const Status opened = open();
      if (!opened) {
        release();
        return fail(ErrorCode::kIo, "{}", opened.error().message);  // tried again
      }
    }
    if (device_.calls().wait_readable(device_.fd(), static_cast<int>(wait_ns / kNsPerMs)) == 0) {
      return drivers::PictureStep::kNothing;
    }
    v4l2_buffer buffer = buffer_of(0);
    const int taken = device_.calls().control(device_.fd(), VIDIOC_DQBUF, &buffer);
    if (taken == -EAGAIN) return drivers::PictureStep::kNothing;
    if (taken < 0) {
      release();
      return fail(ErrorCode::kIo, "gives no picture: {}", std::strerror(-taken));
    }
    const bool usable = buffer.index < buffers_.size() && (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 &&
                        buffer.bytesused >= layout_.bytes && buffers_[buffer.index].size >= layout_.bytes;
    if (usable) convert(static_cast<const std::uint8_t*>(buffers_[buffer.index].memory), picture);
    if (const Status queued = device_.control(VIDIOC_QBUF, buffer, "takes no buffer"); !queued) {
      release();
      return fail(ErrorCode::kIo, "{}", queued.error().message);
    }
    return usable ? drivers::PictureStep::kPicture : drivers::PictureStep::kNothing;
  }

 private:
  struct Buffer {
    void* memory;
    std::size_t size;
  };

  static v4l2_buffer buffer_of(std::uint32_t index) {
    v4l2_buffer buffer = {};
    buffer.index = index;
    buffer.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    buffer.memory = V4L2_MEMORY_MMAP;
    return buffer;
  }

  // Keeps the format that the device has, if it can be read: a loopback device has that of its writer.
  Status choose_format() {
    v4l2_format format = {};
    format.type = V4L2_BUF_TYPE_VIDEO_CAPTURE;
    FL_TRY(device_.control(VIDIOC_G_FMT, format, "has no format; start the program that writes to it first"));
    const std::uint32_t had = format.fmt.pix.pixelformat;
    for (const std::uint32_t code : {had, V4L2_PIX_FMT_RGB24, V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_YUV420}) {
      if (code != had) {
        format.fmt.pix.pixelformat = code;
        format.fmt.pix.bytesperline = 0;
        if (!device_.control(VIDIOC_S_FMT, format, "format")) continue;
      }
      const auto layout = layout_of(format.fmt.pix);
      if (!layout) continue;
      const std::uint32_t size_max = std::max(format.fmt.pix.width, format.fmt.pix.height);
      if (size_max > drivers::kGridSizeMaxPx || layout->bytes == 0) {
        return fail(ErrorCode::kUnsupported, "has pictures of {}x{}; expected at most {} pixels in both directions",
                    format.fmt.pix.width, format.fmt.pix.height, drivers::kGridSizeMaxPx);
      }
      layout_ = *layout;
      pixels_ = format.fmt.pix;
      to_rgb_ = YuvToRgb(coding_of(pixels_));
      return {};
    }
    return fail(ErrorCode::kUnsupported, "has pictures of the format {}; expected RGB3, YUYV, UYVY or YU12",
                text_of_pixels(had));
  }

  void convert(const std::uint8_t* bytes, drivers::Picture& picture) const {
    YuvView view = layout_.view;
    if (picture.width != view.width || picture.height != view.height) picture.clear(view.width, view.height);
    if (layout_.is_rgb) {
      for (int y = 0; y < view.height; ++y) {
        std::memcpy(picture.at(0, y), bytes + y * view.strides[0], 3 * static_cast<std::size_t>(view.width));
      }
      return;
    }
    if (pixels_.pixelformat == V4L2_PIX_FMT_YUYV) view.planes = {bytes, bytes + 1, bytes + 3};
    if (pixels_.pixelformat == V4L2_PIX_FMT_UYVY) view.planes = {bytes + 1, bytes, bytes + 2};
    if (pixels_.pixelformat == V4L2_PIX_FMT_YUV420) {
      const std::uint8_t* const u = bytes + view.strides[0] * view.height;
      view.planes = {bytes, u, u + view.strides[1] * ((view.height + 1) / 2)};
    }
    to_rgb_.convert(view, 0, view.height, picture);
  }

  void release() {
    for (const Buffer& buffer : buffers_) device_.calls().unmap(buffer.memory, buffer.size);
    buffers_.clear();
    device_.close();  // ends the stream too
  }

  const drivers::PictureTarget target_;
  V4l2Device device_;
  PixelLayout layout_;
  v4l2_pix_format pixels_ = {};
  YuvToRgb to_rgb_{YuvCoding{}};
  std::vector<Buffer> buffers_;
};

// The error of `opened` with the endpoint before it, or the port.
template <class Port, class Opened>
Result<std::unique_ptr<Port>> opened_port(const drivers::PictureTarget& target, std::unique_ptr<Opened> port) {
  const Status opened = port->open();
  if (!opened) return fail(opened.error().code, "{}: {}", target.endpoint, opened.error().message);
  return std::unique_ptr<Port>(std::move(port));
}

}  // namespace

V4l2Calls& system_v4l2_calls() {
  static SystemV4l2Calls calls;
  return calls;
}

bool is_v4l2_target(std::string_view name) { return name.starts_with("/dev/video") || name.starts_with("/dev/v4l/"); }

Result<std::unique_ptr<drivers::PictureOutput>> open_v4l2_output(const drivers::PictureTarget& target,
                                                                 V4l2Calls& calls) {
  bool yuyv = false;
  for (const EndpointOption& option : target.options) {
    if (option.key != "pixels") return drivers::unused_option(target, option.key);
    if (option.value != "rgb" && option.value != "yuyv") {
      return fail(ErrorCode::kBadInput, "{}: pixels: expected rgb or yuyv, got \"{}\"", target.endpoint, option.value);
    }
    yuyv = option.value == "yuyv";
  }
  if (yuyv && (target.width % 2 != 0 || target.height % 2 != 0)) {
    return fail(ErrorCode::kBadInput, "{}: yuyv needs an even width and height, got {}x{}", target.endpoint,
                target.width, target.height);
  }
  return opened_port<drivers::PictureOutput>(target, std::make_unique<V4l2Output>(target, yuyv, calls));
}

Result<std::unique_ptr<drivers::PictureInput>> open_v4l2_input(const drivers::PictureTarget& target, V4l2Calls& calls) {
  if (!target.options.empty()) return drivers::unused_option(target, target.options.front().key);
  return opened_port<drivers::PictureInput>(target, std::make_unique<V4l2Input>(target, calls));
}

Result<std::unique_ptr<drivers::PictureOutput>> open_v4l2_output(const drivers::PictureTarget& target) {
  return open_v4l2_output(target, system_v4l2_calls());
}

Result<std::unique_ptr<drivers::PictureInput>> open_v4l2_input(const drivers::PictureTarget& target) {
  return open_v4l2_input(target, system_v4l2_calls());
}

}  // namespace footlight::tools
