#include "drivers/transport/tty_opener.h"

#include <asm/termbits.h>
#include <fcntl.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/inotify.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <utility>
#include <vector>

#include "drivers/permission.h"
#include "drivers/transport/tty_marks.h"
#include "drivers/transport/wakeup.h"

namespace footlight::drivers {
namespace {

tl::unexpected<Error> tty_error(int number, const std::string& where, std::string_view action) {
  switch (number) {
    case ENOENT:
    case ENXIO:
    case ENODEV:
    case EIO: return fail(ErrorCode::kDisconnected, "{}: unplugged", where);
    case EACCES:
    case EPERM: return fail(ErrorCode::kPermission, "{}: permission denied; see: footlight devices", where);
    case EBUSY:
      return fail(ErrorCode::kPermission, "{}: in use by another program; see: sudo fuser -v {}", where, where);
    default: return fail(ErrorCode::kIo, "{}: {}: {}", where, action, std::strerror(number));
  }
}

class TtyTransport final : public Transport {
 public:
  TtyTransport(Fd fd, std::string where, std::string serial, std::shared_ptr<Wakeup> wakeup, Clock& clock)
      : fd_(std::move(fd)),
        where_(std::move(where)),
        serial_(std::move(serial)),
        wakeup_(std::move(wakeup)),
        clock_(clock) {}
  ~TtyTransport() override { (void)::ioctl(fd_.get(), TIOCNXCL); }

  std::string where() const override { return where_; }
  std::string serial() const override { return serial_; }

  Status wait(TimeNs deadline_ns) override {
    while (true) {
      FL_TRY(usable());
      if (wakeup_->take_wake() || clock_.now_ns() >= deadline_ns) return {};
      FL_TRY(poll_for(0, deadline_ns));  // POLLHUP and POLLERR are always reported
    }
  }

  Status write(std::span<const std::uint8_t> bytes, TimeNs deadline_ns) override {
    std::size_t written = 0;
    while (written < bytes.size()) {
      FL_TRY(usable());
      const ssize_t count = ::write(fd_.get(), bytes.data() + written, bytes.size() - written);
      if (count > 0) {
        written += static_cast<std::size_t>(count);
        continue;
      }
      if (count < 0 && errno != EAGAIN && errno != EINTR) return tty_error(errno, where_, "write");
      if (clock_.now_ns() >= deadline_ns)
        return fail(ErrorCode::kTimeout, "{}: took {} of {} bytes in time", where_, written, bytes.size());
      FL_TRY(poll_for(POLLOUT, deadline_ns));
    }
    return {};
  }

  Result<std::size_t> read(std::span<std::uint8_t> into, TimeNs deadline_ns) override {
    while (true) {
      FL_TRY(usable());
      if (wakeup_->take_wake()) return 0;
      const ssize_t count = ::read(fd_.get(), into.data(), into.size());
      if (count > 0) return static_cast<std::size_t>(count);
      if (count < 0 && errno != EAGAIN && errno != EINTR) return tty_error(errno, where_, "read");
      if (clock_.now_ns() >= deadline_ns) return 0;
      FL_TRY(poll_for(POLLIN, deadline_ns));
    }
  }

  Status set_line(const LineSettings& settings, TimeNs) override {
    settings_ = settings;
    marks_ = false;
    parser_.reset();
    FL_TRY(apply());
    if (::ioctl(fd_.get(), TCFLSH, TCIOFLUSH) != 0 && errno == EIO) return tty_error(errno, where_, "flush");
    // For chips with a latency timer. If the driver refuses, bytes arrive some ms later.
    serial_struct serial{};
    if (::ioctl(fd_.get(), TIOCGSERIAL, &serial) == 0) {
      constexpr int kLowLatency = 1 << 13;  // ASYNC_LOW_LATENCY
      const int flags = settings.latency_ms < 16 ? serial.flags | kLowLatency : serial.flags & ~kLowLatency;
      if (flags != serial.flags) {
        serial.flags = flags;
        (void)::ioctl(fd_.get(), TIOCSSERIAL, &serial);
      }
    }
    return {};
  }

  Status set_break(bool on, TimeNs) override {
    FL_TRY(usable());
    if (::ioctl(fd_.get(), on ? TIOCSBRK : TIOCCBRK) == 0) return {};
    return tty_error(errno, where_, on ? "begin a break" : "end a break");
  }

  Result<bool> transmitter_empty(TimeNs) override {
    FL_TRY(usable());
    unsigned status = 0;
    if (::ioctl(fd_.get(), TIOCSERGETLSR, &status) == 0) return (status & TIOCSER_TEMT) != 0;
    if (errno == EIO || errno == ENODEV) return tty_error(errno, where_, "read the line status");
    // The driver has no such request: read the fill of the kernel's buffer instead.
    int waiting = 0;
    if (::ioctl(fd_.get(), TIOCOUTQ, &waiting) != 0) return tty_error(errno, where_, "read the line status");
    return waiting == 0;
  }

  Result<std::size_t> read_line(std::span<LineByte> into, TimeNs deadline_ns) override {
    if (!marks_) {
      marks_ = true;
      FL_TRY(apply());
    }
    while (unread_ == line_bytes_.size()) {
      std::array<std::uint8_t, kUsbTransferSizeMax> bytes;
      FL_ASSIGN(const std::size_t count, read(bytes, deadline_ns));
      if (count == 0) return 0;
      line_bytes_.clear();
      unread_ = 0;
      parser_.take(std::span(bytes).first(count), clock_.now_ns(), line_bytes_);
    }
    const std::size_t count = std::min(into.size(), line_bytes_.size() - unread_);
    std::copy_n(line_bytes_.begin() + static_cast<std::ptrdiff_t>(unread_), count, into.begin());
    unread_ += count;
    return count;
  }

 private:
  Status usable() const {
    if (wakeup_->aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", where_);
    return {};
  }
  Status poll_for(short events, TimeNs deadline_ns) {
    short got = 0;
    if (const int number = wakeup_->poll_until(fd_.get(), events, clock_, deadline_ns, got); number != 0)
      return tty_error(number, where_, "wait");
    // After a hang-up poll() also reports data, and every read() returns 0 bytes. The bytes that had arrived have been
    // read before this call.
    if ((got & (POLLHUP | POLLERR | POLLNVAL)) != 0) return fail(ErrorCode::kDisconnected, "{}: unplugged", where_);
    return {};
  }
  // Sets raw bytes and the baud rate; PARMRK after the first read_line().
  Status apply() {
    termios2 line{};
    if (::ioctl(fd_.get(), TCGETS2, &line) != 0) return tty_error(errno, where_, "read the line settings");
    line.c_iflag = marks_ ? PARMRK | INPCK : IGNBRK | IGNPAR;
    line.c_oflag = 0;
    line.c_lflag = 0;
    line.c_cflag = CS8 | CREAD | CLOCAL | BOTHER | (settings_.stop_bits == 2 ? CSTOPB : 0u);
    line.c_ispeed = line.c_ospeed = static_cast<speed_t>(settings_.baud);
    line.c_cc[VMIN] = 0;
    line.c_cc[VTIME] = 0;
    if (::ioctl(fd_.get(), TCSETS2, &line) != 0) return tty_error(errno, where_, "set the line up");
    return {};
  }

  const Fd fd_;
  const std::string where_;
  const std::string serial_;
  const std::shared_ptr<Wakeup> wakeup_;
  Clock& clock_;
  LineSettings settings_;
  bool marks_ = false;
  TtyMarkParser parser_;
  std::vector<LineByte> line_bytes_;
  std::size_t unread_ = 0;
};

Result<std::unique_ptr<Transport>> open_tty(const FoundDevice& found, const FindOptions& options,
                                            std::shared_ptr<Wakeup> wakeup, Clock& clock) {
  const std::string& path = found.tty;
  Fd fd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.get() < 0 && (errno == EACCES || errno == EPERM))
    return fail(ErrorCode::kPermission, "{}", message_of(advise_on_permission(found, path, errno, options)));
  if (fd.get() < 0) return tty_error(errno, path, "open");
  if (::ioctl(fd.get(), TIOCEXCL) != 0) return tty_error(errno, path, "open");
  auto transport = std::make_unique<TtyTransport>(std::move(fd), path, found.serial, std::move(wakeup), clock);
  FL_TRY(transport->set_line({}, kTimeNever));
  return transport;
}

class TtyOpener final : public Opener {
 public:
  TtyOpener(std::shared_ptr<Chooser> chooser, Clock& clock)
      : chooser_(std::move(chooser)), clock_(clock), watch_(::inotify_init1(IN_CLOEXEC | IN_NONBLOCK)) {
    // Without a watch, wait() lasts until its deadline.
    if (watch_.get() >= 0)
      (void)::inotify_add_watch(watch_.get(), chooser_->options().dev_root.c_str(), IN_CREATE | IN_ATTRIB);
  }
  [[nodiscard]] bool usable() const { return wakeup_->usable(); }

  Result<std::unique_ptr<Transport>> connect() override {
    if (wakeup_->aborted()) return fail(ErrorCode::kDisconnected, "{}: closed", chooser_->driver_id());
    FL_ASSIGN(const FoundDevice found, chooser_->choose());
    if (found.tty.empty())
      return fail(ErrorCode::kNotFound, "{}: has no tty; no driver of the kernel is bound to it", found.port_path);
    auto transport = open_tty(found, chooser_->options(), wakeup_, clock_);
    if (transport) chooser_->pin(found);
    return transport;
  }

  void wait(TimeNs deadline_ns) override {
    while (!wakeup_->aborted() && !wakeup_->take_wake() && clock_.now_ns() < deadline_ns) {
      short got = 0;
      (void)wakeup_->poll_until(watch_.get(), POLLIN, clock_, deadline_ns, got);
      if (got == 0) continue;
      std::array<char, 4096> events;
      while (::read(watch_.get(), events.data(), events.size()) > 0) {
      }
      return;
    }
  }
  void wake() override { wakeup_->wake(); }
  void abort() override { wakeup_->abort(); }
  std::string identity() override { return chooser_->identity(); }

 private:
  const std::shared_ptr<Chooser> chooser_;
  Clock& clock_;
  const Fd watch_;
  const std::shared_ptr<Wakeup> wakeup_ = std::make_shared<Wakeup>();
};

}  // namespace

Result<std::unique_ptr<Opener>> make_tty_opener(std::shared_ptr<Chooser> chooser, Clock& clock) {
  auto opener = std::make_unique<TtyOpener>(std::move(chooser), clock);
  if (!opener->usable()) return fail(ErrorCode::kUnsupported, "the system gives no file descriptors");
  return opener;
}

}  // namespace footlight::drivers
