// Runs the built `footlight` as a user would, in a separate folder.
#pragma once

#include <map>
#include <string>
#include <vector>

#include <sys/types.h>

#include "tests/support/temp_folder.h"

namespace footlight::testing {

struct Outcome {
  int exit_code = -1;  // -1: ended by a signal
  std::string out;
  std::string err;
};

// A running program.
class Footlight {
 public:
  explicit Footlight(const std::vector<std::string>& arguments,
                     const std::map<std::string, std::string>& environment = {});
  ~Footlight();  // kills it unless wait() was called
  Footlight(const Footlight&) = delete;
  Footlight& operator=(const Footlight&) = delete;

  // Reads standard output up to a line with `text`; fails the test if the program ends before, or after 60 s.
  void wait_for(const std::string& text);
  // True if standard output contains `text` at least this many times by now. Does not wait.
  bool has_printed(const std::string& text, int times);
  // The last whole line of standard output by now; empty: none. Does not wait.
  [[nodiscard]] std::string last_line();
  // Closes the reading end of its standard output.
  void stop_reading();
  void signal(int number);
  [[nodiscard]] pid_t pid() const { return pid_; }
  Outcome wait();

 private:
  void read_all();
  bool read_some(bool& out_open, bool& err_open, int patience_ms);

  pid_t pid_ = -1;
  int out_fd_ = -1;
  int err_fd_ = -1;
  Outcome outcome_;
};

[[nodiscard]] Outcome footlight(const std::vector<std::string>& arguments);

}  // namespace footlight::testing
