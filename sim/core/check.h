// Checks for programming errors: prints both operands and aborts. They are cheap and stay on in release builds. Never
// use them for bad input; that is a Result.
#pragma once

#include <cstdio>
#include <cstdlib>

#include <fmt/format.h>

namespace footlight::internal {

template <class A, class B>
[[noreturn]] void check_failed(const char* file, int line, const char* text, const A& a, const B& b) {
  fmt::print(stderr, "{}:{}: check failed: {} ({} against {})\n", file, line, text, a, b);
  std::abort();
}
[[noreturn]] inline void check_failed(const char* file, int line, const char* text) {
  fmt::print(stderr, "{}:{}: check failed: {}\n", file, line, text);
  std::abort();
}

}  // namespace footlight::internal

#define FL_CHECK(condition) \
  ((condition) ? (void)0 : ::footlight::internal::check_failed(__FILE__, __LINE__, #condition))
#define FL_CHECK_OP(a, op, b) \
  (((a)op(b)) ? (void)0 : ::footlight::internal::check_failed(__FILE__, __LINE__, #a " " #op " " #b, (a), (b)))
#define FL_CHECK_EQ(a, b) FL_CHECK_OP(a, ==, b)
#define FL_CHECK_LT(a, b) FL_CHECK_OP(a, <, b)
#define FL_CHECK_LE(a, b) FL_CHECK_OP(a, <=, b)
#define FL_CHECK_GT(a, b) FL_CHECK_OP(a, >, b)
#define FL_CHECK_GE(a, b) FL_CHECK_OP(a, >=, b)
