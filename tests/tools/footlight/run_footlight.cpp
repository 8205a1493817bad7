#include "tests/tools/footlight/run_footlight.h"

#include <cerrno>
#include <csignal>
#include <cstdlib>

#include <fcntl.h>
#include <poll.h>
#include <sys/wait.h>
#include <unistd.h>

#include <doctest/doctest.h>

#include "tests/support/temp_folder.h"

namespace footlight::testing {
namespace {

// Shaders of the demo take half a minute to compile under AddressSanitizer, and several times that on a busy machine.
constexpr int kPatienceMs = 300'000;

void take(int& fd, std::string& text, bool& open) {
  char buffer[4096];
  const ssize_t count = read(fd, buffer, sizeof buffer);
  if (count > 0) {
    text.append(buffer, static_cast<std::size_t>(count));
  } else if (count == 0) {
    close(fd);
    fd = -1;
    open = false;
  }
}

}  // namespace

Footlight::Footlight(const std::vector<std::string>& arguments, const std::map<std::string, std::string>& environment) {
  // Bridges put their sockets here and not in /run/footlight, where those of tests at the same time would be found.
  static const TempFolder runtime_folder;
  const std::string runtime = runtime_folder.file("");
  int out[2];
  int err[2];
  REQUIRE(pipe2(out, O_CLOEXEC) == 0);
  REQUIRE(pipe2(err, O_CLOEXEC) == 0);
  pid_ = fork();
  REQUIRE(pid_ >= 0);
  if (pid_ == 0) {
    dup2(out[1], STDOUT_FILENO);
    dup2(err[1], STDERR_FILENO);
    const int nothing = open("/dev/null", O_RDONLY | O_CLOEXEC);
    dup2(nothing, STDIN_FILENO);
    setenv("XDG_RUNTIME_DIR", runtime.c_str(), 1);
    for (const auto& [name, value] : environment) setenv(name.c_str(), value.c_str(), 1);
    std::vector<std::string> copies{FOOTLIGHT_BINARY};
    copies.insert(copies.end(), arguments.begin(), arguments.end());
    std::vector<char*> words;
    for (std::string& copy : copies) words.push_back(copy.data());
    words.push_back(nullptr);
    execv(words[0], words.data());
    _exit(127);
  }
  close(out[1]);
  close(err[1]);
  out_fd_ = out[0];
  err_fd_ = err[0];
}

Footlight::~Footlight() {
  if (pid_ > 0) {
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
  }
  if (out_fd_ >= 0) close(out_fd_);
  if (err_fd_ >= 0) close(err_fd_);
}

bool Footlight::read_some(bool& out_open, bool& err_open, int patience_ms) {
  pollfd fds[2] = {{out_fd_, POLLIN, 0}, {err_fd_, POLLIN, 0}};  // a descriptor of -1 is ignored
  const int ready = poll(fds, 2, patience_ms);
  if (ready < 0) return errno == EINTR;
  if (ready == 0) return false;
  if (fds[0].revents != 0) take(out_fd_, outcome_.out, out_open);
  if (fds[1].revents != 0) take(err_fd_, outcome_.err, err_open);
  return true;
}

void Footlight::wait_for(const std::string& text) {
  bool out_open = out_fd_ >= 0;
  bool err_open = err_fd_ >= 0;
  while (outcome_.out.find(text) == std::string::npos) {
    INFO("standard error: ", outcome_.err);
    REQUIRE(out_open);
    REQUIRE(read_some(out_open, err_open, kPatienceMs));
  }
}

void Footlight::read_all() {
  bool out_open = out_fd_ >= 0;
  bool err_open = err_fd_ >= 0;
  while ((out_open || err_open) && read_some(out_open, err_open, 0)) {
  }
}

std::string Footlight::last_line() {
  read_all();
  const std::size_t end = outcome_.out.rfind('\n');
  if (end == std::string::npos || end == 0) return "";
  const std::size_t before = outcome_.out.rfind('\n', end - 1);
  const std::size_t begin = before == std::string::npos ? 0 : before + 1;
  return outcome_.out.substr(begin, end - begin);
}

bool Footlight::has_printed(const std::string& text, int times) {
  read_all();
  std::size_t at = 0;
  while (times > 0 && (at = outcome_.out.find(text, at)) != std::string::npos) {
    at += text.size();
    --times;
  }
  return times == 0;
}

void Footlight::stop_reading() {
  close(out_fd_);
  out_fd_ = -1;
}

void Footlight::signal(int number) { REQUIRE(kill(pid_, number) == 0); }

Outcome Footlight::wait() {
  bool out_open = out_fd_ >= 0;
  bool err_open = err_fd_ >= 0;
  while (out_open || err_open) REQUIRE(read_some(out_open, err_open, kPatienceMs));
  int status = 0;
  REQUIRE(waitpid(pid_, &status, 0) == pid_);
  pid_ = -1;
  outcome_.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return outcome_;
}

Outcome footlight(const std::vector<std::string>& arguments) { return Footlight(arguments).wait(); }

}  // namespace footlight::testing
