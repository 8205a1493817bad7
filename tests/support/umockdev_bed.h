// The base of every emulated device: the folder that replaces /, and helpers for handlers of ioctls.
//
// umockdev redirects the system calls of this process to its own folder and passes ioctls to a handler. A program that
// uses it must run under libumockdev-preload, see run_under_umockdev().
#pragma once

#include <umockdev.h>

#include <string>

namespace footlight::testing {

// Starts the program again with libumockdev-preload if it is not loaded yet. Returns 0 when it is, 77 (skip) if it is
// not available. Call first in main().
int run_under_umockdev(char** argv);

// The folder that replaces / while it exists. One at a time.
class Testbed {
 public:
  Testbed() : testbed_(umockdev_testbed_new()) {}
  ~Testbed() { g_object_unref(testbed_); }
  Testbed(const Testbed&) = delete;
  Testbed& operator=(const Testbed&) = delete;
  [[nodiscard]] UMockdevTestbed* get() const { return testbed_; }
  [[nodiscard]] std::string root() const;

 private:
  UMockdevTestbed* testbed_;
};

// In umockdev's format: lines of P:, N:, E:, A:, then an empty one.
void add_device(UMockdevTestbed* testbed, const std::string& description);

// Answers an ioctl: its result and, if that is -1, errno.
void reply(UMockdevIoctlClient* client, long result, int error = 0);

// An ioctl's argument as a structure in this process.
template <class T>
class Argument {
 public:
  explicit Argument(UMockdevIoctlData* argument)
      : data_(umockdev_ioctl_data_resolve(argument, 0, sizeof(T), nullptr)) {}
  ~Argument() { umockdev_ioctl_data_unref(data_); }
  Argument(const Argument&) = delete;
  Argument& operator=(const Argument&) = delete;
  T* operator->() const { return reinterpret_cast<T*>(data_->data); }
  T& operator*() const { return *reinterpret_cast<T*>(data_->data); }

 private:
  UMockdevIoctlData* data_;
};

}  // namespace footlight::testing
