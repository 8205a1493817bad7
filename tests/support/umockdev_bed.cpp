#include "tests/support/umockdev_bed.h"

#include <dlfcn.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>

#include <fmt/format.h>

#include "sim/core/check.h"

namespace footlight::testing {

int run_under_umockdev(char** argv) {
  constexpr const char* kLibrary = "libumockdev-preload.so.0";
  constexpr const char* kMarker = "ioctl_node_list_new";  // a symbol of that library only
  constexpr const char* kTried = "FOOTLIGHT_UMOCKDEV_TRIED";
  const char* preload = std::getenv("LD_PRELOAD");
  if (preload != nullptr && std::strstr(preload, kLibrary) != nullptr && ::dlsym(RTLD_DEFAULT, kMarker) != nullptr)
    return 0;
  if (std::getenv(kTried) != nullptr) {
    std::fprintf(stderr, "SKIPPED: %s cannot be loaded; install the package umockdev\n", kLibrary);
    return 77;
  }
  ::setenv(kTried, "1", 1);
  ::setenv("LD_PRELOAD",
           preload != nullptr && *preload != 0 ? fmt::format("{}:{}", preload, kLibrary).c_str() : kLibrary, 1);
  // AddressSanitizer must be the first library; here another one is.
  const char* asan = std::getenv("ASAN_OPTIONS");
  ::setenv(
      "ASAN_OPTIONS",
      fmt::format("{}{}verify_asan_link_order=0", asan != nullptr ? asan : "", asan != nullptr && *asan != 0 ? ":" : "")
          .c_str(),
      1);
  ::execv("/proc/self/exe", argv);
  return 77;
}

std::string Testbed::root() const {
  gchar* root = umockdev_testbed_get_root_dir(testbed_);
  std::string text(root);
  g_free(root);
  return text;
}

void add_device(UMockdevTestbed* testbed, const std::string& description) {
  GError* error = nullptr;
  FL_CHECK(umockdev_testbed_add_from_string(testbed, description.c_str(), &error));
}

void reply(UMockdevIoctlClient* client, long result, int error) {
  umockdev_ioctl_client_complete(client, result, error);
}

}  // namespace footlight::testing
