#define DOCTEST_CONFIG_IMPLEMENT_WITH_MAIN
#include <doctest/doctest.h>

// Leaks of libraries. fontconfig loses some patterns for every font that cairo requests. The Vulkan validation layer
// (1.3.239) loses what its check of synchronisation keeps for each command buffer.
extern "C" const char* __lsan_default_suppressions();
extern "C" const char* __lsan_default_suppressions() {
  return "leak:libfontconfig\nleak:libVkLayer_khronos_validation\n";
}
