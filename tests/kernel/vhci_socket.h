// A USB socket of the running kernel into which a device model can be plugged. vhci_hcd, the kernel's side of USB/IP,
// gets one end of a socket pair, and a thread here answers at the other end from the model.
//
// Needs root and the module vhci-hcd. The protocol: Documentation/usb/usbip_protocol.rst of the kernel.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <list>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/mock/usb_model.h"

namespace footlight::testing {

class VhciSocket {
 public:
  // socket: from 0. Sockets are distributed over the root hubs, since the kernel handles the ports of one hub one by
  // one. The model outlives this object.
  explicit VhciSocket(drivers::mock::UsbModel& model, int socket = 0);
  ~VhciSocket();  // unplugs
  VhciSocket(const VhciSocket&) = delete;
  VhciSocket& operator=(const VhciSocket&) = delete;

  void plug();  // powers the model on; the kernel finds it some 100 ms later
  // Ends every transfer in progress, and new ones until the kernel has noticed, as a host controller does with a device
  // that no longer answers.
  void unplug();
  // "1-1", as in /sys/bus/usb/devices, after the kernel has configured the device; fails the test if it does not.
  [[nodiscard]] std::string port_path() const;

  // Runs f() exclusively, then completes the transfers that have become possible.
  template <class F>
  decltype(auto) with_model(F&& f) {
    const Notifier notifier{*this};
    const std::lock_guard lock(mutex_);
    return f();
  }
  // Waits until f() is true. False if it is not within `patience` of real time.
  template <class F>
  bool wait_for(F&& f, std::chrono::milliseconds patience) {
    std::unique_lock lock(mutex_);
    return changed_.wait_for(lock, patience, f);
  }

 private:
  using Bytes = drivers::mock::Bytes;
  // A transfer that the kernel has requested.
  struct Transfer {
    std::uint32_t sequence = 0;
    bool to_host = false;
    std::uint8_t endpoint = 0;  // with bit 7 for those to the host
    std::uint32_t size = 0;
    Bytes bytes;            // to the device
    std::size_t given = 0;  // how many of them the model has got
    TimeNs due_ns = 0;      // to the host: when it ends without data
  };
  struct Notifier {
    VhciSocket& socket;
    ~Notifier() { socket.wake(); }
  };

  [[nodiscard]] std::string device_folder() const;  // folder of the kernel's device in /sys; empty: none yet
  void serve();                                     // the thread
  bool take_request();                              // false: the kernel has closed the connection
  void take_submit(Transfer transfer, const std::uint8_t* setup);
  void take_unlink(std::uint32_t sequence, std::uint32_t victim);
  TimeNs complete_in_time();  // returns when to call it again
  bool end_some(TimeNs now_ns);
  bool run(Transfer& transfer, TimeNs now_ns);
  void answer_submit(const Transfer& transfer, int status, const Bytes& bytes);
  void send_answer(std::uint32_t command, std::uint32_t sequence, int status, std::uint32_t actual_size,
                   const Bytes& bytes);
  bool receive(void* into, std::size_t size);
  void wake();

  drivers::mock::UsbModel& model_;
  const int controller_;
  const int hub_port_;       // from 1
  const int kernel_socket_;  // numbered as in vhci_hcd
  const int wake_fd_;
  int fd_ = -1;  // our end of the pair; -1: unplugged
  std::mutex mutex_;
  std::condition_variable changed_;
  // Guarded by mutex_, as is the model.
  std::list<Transfer> in_flight_;
  bool is_unplugged_ = false;
  std::thread thread_;
};

}  // namespace footlight::testing
