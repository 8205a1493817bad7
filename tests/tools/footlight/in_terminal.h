// A command of `footlight` in a terminal whose other end the test holds.
#pragma once

#include <chrono>
#include <csignal>
#include <cstddef>
#include <string>
#include <vector>

#include <poll.h>
#include <pty.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>
#include <utmp.h>

#include <doctest/doctest.h>

namespace footlight::testing {

// The command in a terminal of 80 x 24.
class InTerminal {
 public:
  explicit InTerminal(std::vector<std::string> arguments) {
    winsize size = {};
    size.ws_col = 80;
    size.ws_row = 24;
    REQUIRE(openpty(&fd_, &other_, nullptr, nullptr, &size) == 0);
    REQUIRE(tcgetattr(other_, &before_) == 0);
    pid_ = fork();
    REQUIRE(pid_ >= 0);
    if (pid_ == 0) {
      login_tty(other_);
      std::vector<char*> words;
      static std::string program = FOOTLIGHT_BINARY;
      words.push_back(program.data());
      for (std::string& argument : arguments) words.push_back(argument.data());
      words.push_back(nullptr);
      execv(words[0], words.data());
      _exit(127);
    }
  }
  ~InTerminal() {
    if (pid_ > 0) {
      kill(pid_, SIGKILL);
      waitpid(pid_, nullptr, 0);
    }
    close(fd_);
    close(other_);
  }
  InTerminal(const InTerminal&) = delete;
  InTerminal& operator=(const InTerminal&) = delete;

  void type(const std::string& keys) { REQUIRE(write(fd_, keys.data(), keys.size()) > 0); }
  void signal(int number) { REQUIRE(kill(pid_, number) == 0); }
  // Everything that arrived up to `part`.
  void wait_for(const std::string& part) {
    while (output_.find(part) == std::string::npos) {
      CAPTURE(output_);
      REQUIRE(read_some(60'000));
    }
  }
  int end() {
    int status = 0;
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (waitpid(pid_, &status, WNOHANG) != pid_) {
      REQUIRE(std::chrono::steady_clock::now() < deadline);  // the destructor kills it then
      (void)read_some(20);
    }
    while (read_some(0)) {
    }
    pid_ = -1;
    return status;
  }
  [[nodiscard]] const std::string& output() const { return output_; }
  [[nodiscard]] bool is_as_before() const {
    termios now = {};
    REQUIRE(tcgetattr(other_, &now) == 0);
    return now.c_lflag == before_.c_lflag && now.c_iflag == before_.c_iflag;
  }

 private:
  bool read_some(int patience_ms) {
    pollfd ready = {fd_, POLLIN, 0};
    if (poll(&ready, 1, patience_ms) != 1) return false;
    char buffer[4096];
    const ssize_t count = read(fd_, buffer, sizeof buffer);
    if (count > 0) output_.append(buffer, static_cast<std::size_t>(count));
    return count > 0;
  }

  int fd_ = -1;
  int other_ = -1;  // kept open, so that its modes can be read at the end
  pid_t pid_ = -1;
  termios before_ = {};
  std::string output_;
};

}  // namespace footlight::testing
