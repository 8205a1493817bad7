// An emulated tty: the real termios and /sys readers on one side, a serial model on the other. The node is a
// pseudo-terminal. A thread here carries bytes between its far end and the model. A handler of umockdev gets what a
// pseudo-terminal does not pass on: breaks, and requests for the line status. A program that uses it must run under
// libumockdev-preload, see run_under_umockdev().
#pragma once

#include <umockdev.h>

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/mock/serial_model.h"
#include "tests/support/umockdev_bed.h"

namespace footlight::testing {

class TtySocket {
 public:
  // tty: "ttyACM0" is placed where the kernel's driver of the communication class puts it, "ttyUSB0" where those of
  // serial converters do. The testbed and the model outlive the socket.
  TtySocket(Testbed& testbed, drivers::mock::SerialModel& model, std::string tty, int socket = 1);
  ~TtySocket();
  TtySocket(const TtySocket&) = delete;
  TtySocket& operator=(const TtySocket&) = delete;

  void plug();
  void unplug();
  template <class F>
  decltype(auto) with_model(F&& f) {
    const std::lock_guard lock(mutex_);
    return f();
  }
  template <class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, std::chrono::system_clock::now() + patience, f);
  }
  // The last setting of the line; 0: none yet.
  [[nodiscard]] unsigned baud();
  [[nodiscard]] bool has_two_stop_bits();

 private:
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, TtySocket* self);
  void carry();  // the thread

  Testbed& testbed_;
  drivers::mock::SerialModel& model_;
  const std::string tty_;
  const int socket_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // All below: guarded by mutex_.
  bool plugged_ = false;
  unsigned baud_ = 0;
  bool two_stop_bits_ = false;
  int far_end_ = -1;
  int stop_fd_ = -1;
  std::thread thread_;
};

}  // namespace footlight::testing
