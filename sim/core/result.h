// Errors are values.
//
// Expected trouble (no permission, unplugged, timeout, malformed line, missing GPU feature) is returned as a Result.
// The message names the thing and the next step: "/dev/bus/usb/001/004: permission denied; run 'sudo cp
// udev/70-footlight.rules /etc/udev/rules.d/'". A programming error (index out of range, unsorted table) is FL_CHECK in
// check.h.
#pragma once

#include <string>
#include <utility>

#include <fmt/format.h>
#include <tl/expected.hpp>

namespace footlight {

enum class ErrorCode {
  kNotFound,      // the named thing does not exist
  kPermission,    // it exists, but this user may not use it
  kDisconnected,  // it was present and is gone
  kTimeout,       // it is present and does not answer
  kProtocol,      // the other side violated its protocol
  kBadInput,      // a file or argument is wrong; the message names the place and what was expected
  kUnsupported,   // this build or machine does not support it
  kIo,            // the operating system refused a read or write
};

struct Error {
  ErrorCode code;
  std::string message;
};

template <class T>
using Result = tl::expected<T, Error>;
using Status = Result<void>;

// return fail(ErrorCode::kBadInput, "{}:{}: expected an address from 1 to 512, got {}", file, line, address);
template <class... Args>
[[nodiscard]] tl::unexpected<Error> fail(ErrorCode code, fmt::format_string<Args...> format, Args&&... args) {
  return tl::unexpected<Error>(Error{code, fmt::format(format, std::forward<Args>(args)...)});
}

[[nodiscard]] const char* name_of(ErrorCode code);

}  // namespace footlight

// FL_TRY(expression): returns the error of a Status or Result from the calling function.
#define FL_TRY(expression)                                                           \
  do {                                                                               \
    if (auto fl_try_result = (expression); !fl_try_result)                           \
      return ::tl::unexpected<::footlight::Error>(std::move(fl_try_result).error()); \
  } while (false)

// FL_ASSIGN(auto rig, load_rig(path)): binds the value or returns the error.
#define FL_CONCAT_INNER(a, b) a##b
#define FL_CONCAT(a, b) FL_CONCAT_INNER(a, b)
#define FL_ASSIGN(declaration, expression) FL_ASSIGN_INNER(FL_CONCAT(fl_result_, __LINE__), declaration, expression)
#define FL_ASSIGN_INNER(temporary, declaration, expression)                                  \
  auto temporary = (expression);                                                             \
  if (!temporary) return ::tl::unexpected<::footlight::Error>(std::move(temporary).error()); \
  declaration = std::move(*temporary)
