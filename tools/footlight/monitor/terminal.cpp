#include "tools/footlight/monitor/terminal.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <string_view>

#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <fmt/format.h>

namespace footlight::tools {
namespace {

// Alternate screen, no cursor, no line wrap; and back.
constexpr std::string_view kEnter = "\033[?1049h\033[?25l\033[?7l\033[2J";
constexpr std::string_view kLeave = "\033[0m\033[?7h\033[?25h\033[?1049l";

constexpr std::array kEndSignals = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
constexpr std::array kDeadlySignals = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT};

termios terminal_before = {};
std::atomic<bool> terminal_taken{false};
std::atomic<bool> end_came{false};
std::atomic<bool> redraw_wanted{false};

void write_all(std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(STDOUT_FILENO, text.data(), text.size());
    if (count < 0 && errno != EINTR) return;
    if (count > 0) text.remove_prefix(static_cast<std::size_t>(count));
  }
}

// Also called from signal handlers.
void give_back() {
  if (!terminal_taken.exchange(false)) return;
  write_all(kLeave);
  tcsetattr(STDIN_FILENO, TCSANOW, &terminal_before);
}

void on_end(int) { end_came.store(true); }
void on_resize(int) { redraw_wanted.store(true); }

void set_action(int number, void (*handler)(int), int flags) {
  struct sigaction action = {};
  action.sa_handler = handler;
  action.sa_flags = flags;
  sigemptyset(&action.sa_mask);
  sigaction(number, &action, nullptr);
}

void on_death(int number) {
  give_back();
  set_action(number, SIG_DFL, 0);
  raise(number);
}

void on_stop(int) {
  give_back();
  raise(SIGSTOP);  // continues here after SIGCONT, whose handler has set up the terminal again
}

void take_terminal() {
  termios raw = terminal_before;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO);  // ISIG stays: Ctrl-C and Ctrl-Z are signals
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  tcsetattr(STDIN_FILENO, TCSANOW, &raw);
  terminal_taken.store(true);
  write_all(kEnter);
  redraw_wanted.store(true);
}

void on_continue(int) {
  const int saved_errno = errno;
  if (!terminal_taken.load()) take_terminal();
  errno = saved_errno;
}

}  // namespace

Key take_key(std::string& bytes, std::string& typed, bool more_may_come) {
  if (bytes.empty()) return Key::kNone;
  const auto take = [&](std::size_t count) { return std::exchange(bytes, bytes.substr(count)).substr(0, count); };
  const auto lead = static_cast<unsigned char>(bytes[0]);
  if (lead != 0x1B) {
    if (lead == '\n' || lead == '\r') return take(1), Key::kEnter;
    if (lead == 0x7F || lead == 0x08) return take(1), Key::kBackspace;
    if (lead < 0x20) return take(1), Key::kNone;
    const std::size_t length = lead < 0xC0 ? 1 : lead >= 0xF0 ? 4 : lead >= 0xE0 ? 3 : 2;
    if (bytes.size() < length && more_may_come) return Key::kNone;
    typed = take(std::min(length, bytes.size()));
    return Key::kText;
  }
  if (bytes.size() == 1) {
    if (more_may_come) return Key::kNone;
    return take(1), Key::kEscape;
  }
  if (bytes[1] != '[' && bytes[1] != 'O') return take(1), Key::kEscape;
  // Parameters, then one letter or "~".
  std::size_t end = 2;
  while (end < bytes.size() && static_cast<unsigned char>(bytes[end]) < 0x40) ++end;
  if (end == bytes.size()) {
    if (!more_may_come) bytes.clear();
    return Key::kNone;
  }
  const std::string sequence = take(end + 1);
  if (sequence.back() == 'A') return Key::kUp;
  if (sequence.back() == 'B') return Key::kDown;
  if (sequence.back() == 'C') return Key::kRight;
  if (sequence.back() == 'D') return Key::kLeft;
  if (sequence == "\033[5~") return Key::kPageUp;
  if (sequence == "\033[6~") return Key::kPageDown;
  return Key::kNone;
}

Result<std::unique_ptr<Terminal>> Terminal::take() {
  if (isatty(STDIN_FILENO) == 0 || isatty(STDOUT_FILENO) == 0 || tcgetattr(STDIN_FILENO, &terminal_before) != 0) {
    return fail(ErrorCode::kUnsupported,
                "there is no terminal to draw on; use --once for one picture, or --json for a stream");
  }
  std::unique_ptr<Terminal> terminal(new Terminal);
  end_came.store(false);
  for (const int number : kEndSignals) set_action(number, on_end, 0);
  for (const int number : kDeadlySignals) set_action(number, on_death, static_cast<int>(SA_RESETHAND | SA_NODEFER));
  set_action(SIGTSTP, on_stop, SA_RESTART);
  set_action(SIGCONT, on_continue, SA_RESTART);
  set_action(SIGWINCH, on_resize, 0);
  std::signal(SIGPIPE, SIG_IGN);
  take_terminal();
  return terminal;
}

Terminal::~Terminal() {
  give_back();
  for (const int number : kEndSignals) set_action(number, SIG_DFL, 0);
  for (const int number : kDeadlySignals) set_action(number, SIG_DFL, 0);
  for (const int number : {SIGTSTP, SIGCONT, SIGWINCH}) set_action(number, SIG_DFL, 0);
}

TerminalSize Terminal::size() const {
  winsize size = {};
  if (ioctl(STDOUT_FILENO, TIOCGWINSZ, &size) != 0 || size.ws_col == 0 || size.ws_row == 0) return {};
  return {size.ws_col, size.ws_row};
}

void Terminal::show(const std::vector<std::string>& lines) {
  if (redraw_wanted.exchange(false) || lines.size() != shown_.size()) {
    shown_.clear();
    write_all("\033[2J");
  }
  std::string text;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (i < shown_.size() && shown_[i] == lines[i]) continue;
    text += fmt::format("\033[{};1H{}\033[0m\033[K", i + 1, lines[i]);
  }
  write_all(text);
  shown_ = lines;
}

Key Terminal::wait_for_key(DurationNs patience_ns) {
  if (const Key key = take_key(bytes_, typed_, true); key != Key::kNone) return key;
  pollfd input = {STDIN_FILENO, POLLIN, 0};
  // A terminal sends a sequence at once: if it is still incomplete a moment later, it was the escape key.
  const DurationNs wait_ns = bytes_.empty() ? patience_ns : std::min<DurationNs>(patience_ns, 50 * kNsPerMs);
  const timespec patience = {.tv_sec = wait_ns / kNsPerS, .tv_nsec = wait_ns % kNsPerS};
  const int ready = ppoll(&input, 1, &patience, nullptr);
  if (ready <= 0) return ready == 0 ? take_key(bytes_, typed_, false) : Key::kNone;
  char buffer[256];
  const ssize_t count = ::read(STDIN_FILENO, buffer, sizeof buffer);
  if (count <= 0) {
    end_came.store(true);  // the terminal was closed
    return Key::kNone;
  }
  bytes_.append(buffer, static_cast<std::size_t>(count));
  return take_key(bytes_, typed_, true);
}

bool Terminal::ended() const { return end_came.load(); }

void catch_end_signals() {
  end_came.store(false);
  std::signal(SIGPIPE, SIG_IGN);
  for (const int number : kEndSignals) set_action(number, on_end, 0);
}

bool end_signal_came() { return end_came.load(); }

}  // namespace footlight::tools
