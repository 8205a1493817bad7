#include "drivers/transport/either_opener.h"

#include <utility>

namespace footlight::drivers {
namespace {

class EitherOpener final : public Opener {
 public:
  EitherOpener(std::unique_ptr<Opener> libusb, std::unique_ptr<Opener> tty, LookForDevice look, Clock& clock)
      : libusb_(std::move(libusb)), tty_(std::move(tty)), look_(std::move(look)), clock_(clock) {}

  Result<std::unique_ptr<Transport>> connect() override {
    const std::optional<SeenDevice> seen = look_();
    note_arrival(seen);
    tried_ = seen && seen->kind == TransportKind::kTty ? tty_.get() : libusb_.get();
    auto transport = tried_->connect();
    if (transport || tried_ == tty_.get() || !seen) return transport;
    const ErrorCode code = transport.error().code;
    if (code == ErrorCode::kNotFound || code == ErrorCode::kPermission) {
      if (clock_.now_ns() < left_to_libusb_until_ns_) return transport;
    } else if (code != ErrorCode::kUnsupported) {
      return transport;
    }
    auto other = tty_->connect();
    if (other) return other;
    return transport;  // its message names the fix for libusb, the preferred way
  }
  void wait(TimeNs deadline_ns) override { tried_->wait(deadline_ns); }
  void wake() override {
    libusb_->wake();
    tty_->wake();
  }
  void abort() override {
    libusb_->abort();
    tty_->abort();
  }
  std::string identity() override { return libusb_->identity(); }

 private:
  // A device that is there at the first call has been there for an unknown time, so libusb already lists it.
  void note_arrival(const std::optional<SeenDevice>& seen) {
    const std::string node = seen ? seen->node : "";
    if (looked_ && node != node_) left_to_libusb_until_ns_ = clock_.now_ns() + kAnnouncementNs;
    looked_ = true;
    node_ = node;
  }

  const std::unique_ptr<Opener> libusb_, tty_;
  const LookForDevice look_;
  Clock& clock_;
  // Used by the device thread only.
  Opener* tried_ = libusb_.get();
  bool looked_ = false;
  std::string node_;  // at the last call of look_(); empty: none was plugged in
  TimeNs left_to_libusb_until_ns_ = INT64_MIN;
};

}  // namespace

std::unique_ptr<Opener> make_either_opener(std::unique_ptr<Opener> libusb, std::unique_ptr<Opener> tty,
                                           LookForDevice look, Clock& clock) {
  return std::make_unique<EitherOpener>(std::move(libusb), std::move(tty), std::move(look), clock);
}

}  // namespace footlight::drivers
