// An emulated /dev/gpiochip0: the real libgpiod on one side, the test on the other. Uses uAPI v1, like libgpiod 1.6.
//
// A request for a line returns a new descriptor. The handler of ioctls runs in this process, so it opens a second
// emulated node, a FIFO, and answers with that number. poll() and read() use the FIFO; a read of the level calls the
// handler.
//
// Threads: umockdev calls the handler on its own thread; all members are safe to call from the test's.
#pragma once

#include <linux/gpio.h>

#include <map>
#include <mutex>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "tests/support/umockdev_bed.h"

namespace footlight::testing {

class GpioFs {
 public:
  // Line i is called names[i]. The testbed outlives it. Starts plugged in.
  GpioFs(Testbed& testbed, std::vector<std::string> names);
  ~GpioFs();
  GpioFs(const GpioFs&) = delete;
  GpioFs& operator=(const GpioFs&) = delete;

  // The physical level; an edge if it differs from the last one. `stamp_ns` 0: CLOCK_MONOTONIC now.
  void drive(unsigned line, bool level, std::int64_t stamp_ns = 0);
  void unplug();
  void plug();

  // --- Faults
  void hold(unsigned line, const std::string& consumer);  // in use by another program; empty: by none
  void refuse(int number);                                // an errno value for every request; 0: none
  void fail_levels(int number);                           // an errno value for every reading of a level; 0: none

  [[nodiscard]] bool is_requested(unsigned line);
  [[nodiscard]] unsigned handle_flags(unsigned line);  // GPIOHANDLE_REQUEST_... of the last request
  [[nodiscard]] std::string consumer(unsigned line);
  [[nodiscard]] int lost(unsigned line);

 private:
  struct Line {
    std::string name;
    std::string consumer;
    bool level = false;
    bool held = false;
    unsigned handle_flags = 0;
    int write_fd = -1;
    int lost = 0;
  };

  static gboolean on_ioctl(UMockdevIoctlBase*, UMockdevIoctlClient* client, GpioFs* self);
  void answer(UMockdevIoctlClient* client);
  void answer_line_event(UMockdevIoctlClient* client, UMockdevIoctlData* argument);
  void make_fifo(const std::string& node) const;
  bool in_use(Line& line) const;

  Testbed& testbed_;
  UMockdevIoctlBase* handler_;
  std::mutex mutex_;
  // All below: guarded by mutex_.
  std::vector<Line> lines_;
  std::map<std::string, std::size_t> line_of_node_;
  int node_count_ = 0;
  int refusal_ = 0;
  int level_error_ = 0;
  bool plugged_ = false;
};

}  // namespace footlight::testing
