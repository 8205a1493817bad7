// An emulated /dev/hidraw* and /sys: the program's transport on one side, a device model on the other.
//
// umockdev redirects the system calls of this process into a folder of its own and hands ioctl(), read() and write() of
// the node to a handler. The node is a FIFO in packet mode, so that poll() is the kernel's own and every report keeps
// its borders. As in the kernel, a file that was opened before an unplug answers ENODEV from then on, after a replug
// too. All files of the node read from one queue; in the kernel each file has its own.
//
// Threads: umockdev calls the handler on a thread of its own. All members are safe to call from the test's thread.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <map>
#include <mutex>
#include <string>

#include "drivers/mock/hid_model.h"
#include "tests/support/umockdev_bed.h"

namespace footlight::testing {

// One socket of a hub, number `socket` from 1, into which a model can be plugged. The testbed outlives it.
class HidSocket {
 public:
  HidSocket(Testbed& testbed, drivers::mock::HidModel& model, int socket = 1);
  ~HidSocket();
  HidSocket(const HidSocket&) = delete;
  HidSocket& operator=(const HidSocket&) = delete;

  void plug();    // powers the model on and announces it
  void unplug();  // files that are open answer ENODEV from now on

  // Runs f() while no other thread uses the model, then writes the model's reports to the node.
  template <class F>
  void with_model(F&& f) {
    {
      const std::lock_guard lock(mutex_);
      f();
      send_reports();
    }
    changed_.notify_all();
  }
  template <class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, std::chrono::system_clock::now() + patience, f);
  }
  [[nodiscard]] bool is_plugged() const { return plugged_; }  // in the function of wait_for() or with_model()
  // HIDIOCGRDESCSIZE: one request of the opener's check, then one of hid_open_path().
  [[nodiscard]] int size_request_count() const { return size_request_count_; }
  [[nodiscard]] std::string node() const;       // "/dev/hidraw1"
  [[nodiscard]] std::string port_path() const;  // "1-1"

  // --- Faults
  std::atomic<int> write_error{0};       // an errno value for every write
  std::atomic<int> write_size_max{-1};   // bytes of a report that are accepted; -1: all
  std::atomic<int> unplug_at_write{-1};  // the write with this number (from 0) fails because the device is gone; -1:
                                         // none

 private:
  static void on_client_connected(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self);
  static void on_client_vanished(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self);
  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self);
  static gboolean on_read(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self);
  static gboolean on_write(UMockdevIoctlBase*, UMockdevIoctlClient* client, HidSocket* self);
  [[nodiscard]] bool is_there_for(UMockdevIoctlClient* client) const;
  void send_reports();
  [[nodiscard]] std::string folder() const;  // in /sys

  Testbed& testbed_;
  drivers::mock::HidModel& model_;
  const int socket_;
  UMockdevIoctlBase* const handler_;

  std::atomic<int> size_request_count_{0};

  std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_.
  bool plugged_ = false;
  bool announced_ = false;
  int plug_count_ = 0;
  std::map<const UMockdevIoctlClient*, int> plug_of_client_;  // per open file, plug_count_ when it was opened
  int write_count_ = 0;
  int fifo_fd_ = -1;  // both ends, so that the FIFO always has a writer
};

}  // namespace footlight::testing
