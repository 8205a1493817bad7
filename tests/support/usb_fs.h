// An emulated /dev/bus/usb and /sys: real libusb and real sysfs readers on one side, a device model on the other.
//
// umockdev redirects the system calls of this process to its own folder and passes usbfs ioctls to a handler. The
// handler simulates the kernel for one device: it binds and detaches drivers, keeps transfers in progress, completes
// them from the model, and ends them with ESHUTDOWN at an unplug. A program that uses it must run under
// libumockdev-preload, see run_under_umockdev().
//
// libusb polls the device node for "a transfer has ended". An ordinary file is always ready, so libusb would spin. So
// the node is a FIFO: full (not writable) until a transfer has ended.
//
// Threads: umockdev calls the handler on its own thread; one thread here completes transfers that take time. All
// members are safe to call from the test's thread.
#pragma once

#include <umockdev.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/mock/usb_model.h"
#include "tests/support/umockdev_bed.h"

namespace footlight::testing {

// One socket of a hub, number `socket` from 1, into which a model can be plugged. The testbed outlives it.
class UsbSocket {
 public:
  UsbSocket(Testbed& testbed, drivers::mock::UsbModel& model, int socket = 1);
  ~UsbSocket();
  UsbSocket(const UsbSocket&) = delete;
  UsbSocket& operator=(const UsbSocket&) = delete;

  void plug();    // powers the model on and announces it as udev does
  void unplug();  // ends every transfer in flight, then announces it

  // Runs f() exclusively, then completes the transfers that have become possible.
  template <class F>
  decltype(auto) with_model(F&& f) {
    const Notifier notifier{*this};
    const std::lock_guard lock(mutex_);
    return f();
  }
  template <class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience = std::chrono::seconds(10)) {
    std::unique_lock lock(mutex_);
    return changed_.wait_until(lock, std::chrono::system_clock::now() + patience, f);
  }
  [[nodiscard]] bool claimed();
  [[nodiscard]] std::string kernel_driver();    // bound to interface 0; empty: none
  [[nodiscard]] std::string node() const;       // "/dev/bus/usb/001/002"
  [[nodiscard]] std::string port_path() const;  // "1-1"
  [[nodiscard]] bool transfer_in_flight(std::uint8_t endpoint);

  // As after SIGKILL of a program that had detached the driver: released, with no driver bound.
  void lose_kernel_driver();

  // --- Faults
  std::atomic<int> claim_error{0};      // an errno value for every claim
  std::atomic<int> out_status{0};       // a negative errno value: the result of OUT transfers
  std::atomic<int> out_size_max{-1};    // bytes that an OUT transfer accepts before it completes; -1: all
  std::atomic<bool> out_frozen{false};  // OUT transfers stay in flight
  std::atomic<bool> out_halted{false};  // OUT transfers end with EPIPE until the host clears the halt
  std::atomic<bool> in_frozen{false};   // IN transfers stay in flight

 private:
  using Time = std::chrono::steady_clock::time_point;
  struct Urb {
    UMockdevIoctlData* urb;
    UMockdevIoctlData* buffer;  // nullptr if the transfer has none
    int status = 0;
    int actual_size = 0;
    Time due;
  };
  struct Notifier {
    UsbSocket& socket;
    ~Notifier() { socket.changed_.notify_all(); }
  };

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, UsbSocket* self);
  void answer(UMockdevIoctlClient* client);
  void submit(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void reap(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void discard(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void pass_time();
  void run_control(Urb& urb);
  bool run_bulk(Urb& urb, Time now);  // false: not yet
  void finish(const Urb& urb);
  void complete_in_time();  // the thread
  void bind(const std::string& driver);
  void make_gate();
  void set_gate(bool open);

  Testbed& testbed_;
  drivers::mock::UsbModel& model_;
  const int socket_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  std::condition_variable changed_;
  // All below: guarded by mutex_.
  std::list<Urb> in_flight_, ended_;
  std::string driver_;
  bool plugged_ = false, claimed_ = false, stopping_ = false, gate_open_ = true;
  int gate_fd_ = -1;
  std::thread thread_;  // last member: it uses the others
};

}  // namespace footlight::testing
