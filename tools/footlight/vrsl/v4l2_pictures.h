// Pictures to and from video devices of the kernel (V4L2): v4l2loopback devices out and in, cameras and grabbers in.
// By the kernel's own calls; no library is used.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "drivers/vrsl/picture_port.h"

namespace footlight::tools {

// The calls of the system that a port makes; tests replace them. Results are those of the system, with -errno for -1.
class V4l2Calls {
 public:
  virtual ~V4l2Calls() = default;
  virtual int open(const std::string& path, bool output) = 0;
  virtual int close(int fd) = 0;
  virtual int control(int fd, unsigned long request, void* argument) = 0;  // ioctl()
  virtual ssize_t write(int fd, const void* bytes, std::size_t size) = 0;
  // The memory of a buffer at the offset that the device gave; nullptr: refused.
  virtual void* map(int fd, std::size_t size, std::uint64_t offset) = 0;
  virtual void unmap(void* memory, std::size_t size) = 0;
  virtual int wait_readable(int fd, int wait_ms) = 0;  // poll(): 0 after the time, 1 if readable or in an error state
};
[[nodiscard]] V4l2Calls& system_v4l2_calls();

// True for /dev/video0, /dev/video1 and so on, and for names below /dev/v4l/.
[[nodiscard]] bool is_v4l2_target(std::string_view name);

// Options:
//   pixels   rgb (default): every level exactly; yuyv: for programs that read no RGB, colours have half the width
// The device gets the picture's size. Errors: kNotFound, kPermission, kUnsupported (no output, or it refuses the format
// or the size), kBadInput; the message begins with the endpoint.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_v4l2_output(const drivers::PictureTarget& target);
// Options: none. Reads RGB, YUYV, UYVY and planar 4:2:0 in the size that the device has. A device that disappears is
// opened again.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_v4l2_input(const drivers::PictureTarget& target);

// As above, with other calls.
[[nodiscard]] Result<std::unique_ptr<drivers::PictureOutput>> open_v4l2_output(const drivers::PictureTarget& target,
                                                                               V4l2Calls& calls);
[[nodiscard]] Result<std::unique_ptr<drivers::PictureInput>> open_v4l2_input(const drivers::PictureTarget& target,
                                                                             V4l2Calls& calls);

}  // namespace footlight::tools
