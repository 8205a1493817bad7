// Prints one line per test when it ends: "passed 12.3 s  NAME" or "failed ...". The host counts the lines and uses them
// as a sign of life.
#include <cstdio>

#include <doctest/doctest.h>

namespace footlight::testing {
namespace {

class ResultLines final : public doctest::IReporter {
 public:
  explicit ResultLines(const doctest::ContextOptions&) {}
  void test_case_start(const doctest::TestCaseData& data) override {
    name_ = data.m_name;
    std::printf("begins          %s\n", name_);
    std::fflush(stdout);
  }
  void test_case_end(const doctest::CurrentTestCaseStats& stats) override {
    std::printf("%s %6.1f s  %s\n", stats.testCaseSuccess ? "passed" : "failed", stats.seconds, name_);
    std::fflush(stdout);
  }
  void report_query(const doctest::QueryData&) override {}
  void test_run_start() override {}
  void test_run_end(const doctest::TestRunStats&) override {}
  void test_case_reenter(const doctest::TestCaseData&) override {}
  void test_case_exception(const doctest::TestCaseException&) override {}
  void subcase_start(const doctest::SubcaseSignature&) override {}
  void subcase_end() override {}
  void log_assert(const doctest::AssertData&) override {}
  void log_message(const doctest::MessageData&) override {}
  void test_case_skipped(const doctest::TestCaseData&) override {}

 private:
  const char* name_ = "";
};

REGISTER_LISTENER("result_lines", 1, ResultLines);

}  // namespace
}  // namespace footlight::testing
