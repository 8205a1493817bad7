// A model of a GPIO chip in this process, with the same interface as real ones. It ships as the chip "mock":
// gpio:mock/2=1.25 runs on any machine.
//
// Line N of the chip "mock" is a contact that closes N times a second, half of the time, and bounces for a millisecond
// when it closes; line 0 stays open.
//
// It models the kernel's behaviour that matters: a queue of 16 edges per line, which loses the newest when it is full;
// one user per line; no report of lost edges. Faults happen on command.
//
// Threads: GpioModel is safe to use from any; its lines belong to one thread each.
#pragma once

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/gpio/gpio_chip.h"

namespace footlight::drivers::mock {

class GpioModel {
 public:
  explicit GpioModel(int line_count, std::string name = "mock");
  ~GpioModel();
  GpioModel(const GpioModel&) = delete;
  GpioModel& operator=(const GpioModel&) = delete;

  // --- Signals on the lines
  void drive(int line, bool level, TimeNs stamp_ns);  // logical level; an edge if it differs from the last one
  // `edge_count` edges from `stamp_ns` on, `spacing_ns` apart, the first one to `level`.
  void bounce(int line, bool level, TimeNs stamp_ns, int edge_count, DurationNs spacing_ns);

  // --- Faults
  void unplug();                              // every line fails, requests find nothing
  void plug();                                // levels as before; requests succeed again
  void hold(int line, std::string consumer);  // in use by another program; empty: by none
  void stick(int line, bool stuck);           // drive() has no effect on it
  void lose_edges(int line, bool losing);     // drive() changes the level without an edge
  void fail_reads(int line, bool failing);    // EIO
  void forbid(bool forbidden);                // requests end in kPermission

  [[nodiscard]] bool is_requested(int line) const;
  [[nodiscard]] std::uint64_t lost(int line) const;  // edges for which the queue had no room
  [[nodiscard]] GpioLineRequest last_request() const;

 private:
  friend class ModelLine;
  friend class ModelChips;
  struct Line {
    bool level = false;
    bool requested = false;
    bool stuck = false;
    bool failing = false;
    bool drops_edges = false;
    std::string consumer;
    std::deque<GpioEdge> queue;
    std::uint64_t lost = 0;
    int event_fd = -1;  // readable while the queue has an edge or the chip is gone
  };

  void push(Line& line, GpioEdge edge);
  void set_readable(Line& line) const;

  const std::string name_;
  mutable std::mutex mutex_;
  // All below: guarded by mutex_.
  std::vector<Line> lines_;
  bool plugged_ = true;
  bool forbidden_ = false;
  std::uint64_t plug_count_ = 1;
  GpioLineRequest last_request_;
};

// A set of chips with one member, the model.
[[nodiscard]] std::shared_ptr<GpioChips> make_model_chips(std::shared_ptr<GpioModel> model);

// The chip "mock" as it ships. The clock outlives it.
[[nodiscard]] std::shared_ptr<GpioChips> make_mock_chips(Clock& clock);

}  // namespace footlight::drivers::mock
