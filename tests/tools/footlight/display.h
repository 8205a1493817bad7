// A display of a test's own: Xvfb, if that is installed.
#pragma once

#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <fmt/format.h>

extern char** environ;

namespace footlight::testing {

// Its number comes from Xvfb.
class Display {
 public:
  // folder: for a file with the pixels; empty: there is none.
  Display(int width, int height, const std::string& folder = "") {
    std::array<int, 2> ends{};
    REQUIRE(::pipe(ends.data()) == 0);
    const std::string number_fd = std::to_string(ends[1]);
    const std::string screen = fmt::format("{}x{}x24", width, height);
    // -noreset: else it begins anew when the last window closes, and one that opens meanwhile may wait for ever.
    std::vector<std::string> words = {"Xvfb", "-displayfd", number_fd, "-screen", "0", screen, "-noreset"};
    if (!folder.empty()) words.insert(words.end(), {"-fbdir", folder});
    std::vector<char*> arguments;
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    if (::posix_spawnp(&pid_, "Xvfb", nullptr, nullptr, arguments.data(), environ) != 0) pid_ = -1;
    ::close(ends[1]);
    std::string number;
    char letter = 0;
    while (pid_ > 0 && ::read(ends[0], &letter, 1) == 1 && letter != '\n') number += letter;
    if (!number.empty()) name_ = ":" + number;
    ::close(ends[0]);
  }
  ~Display() { end(SIGTERM); }
  // It goes away.
  void end(int signal) {
    if (pid_ <= 0) return;
    ::kill(pid_, signal);
    ::waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }
  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;
  [[nodiscard]] const std::string& name() const { return name_; }

 private:
  pid_t pid_ = -1;
  std::string name_;  // empty: there is none
};

}  // namespace footlight::testing
