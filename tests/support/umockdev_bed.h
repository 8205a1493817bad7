// The ground of every emulated device: the folder that stands for /, and what handlers of ioctls need.
//
// umockdev redirects the system calls of this process into a folder of its own and hands ioctls to a handler. A program
// that uses it has to run under libumockdev-preload, see run_under_umockdev().
#pragma once

#include <umockdev.h>

#include <string>

namespace footlight::testing {

// Starts the program again with libumockdev-preload in front where it is not there yet; returns 0 when it is, 77 (skip)
// when it cannot be had. Call first in main().
int run_under_umockdev(char** argv);

// The folder that stands for / while it lives. One at a time.
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

// As umockdev describes devices: lines of P:, N:, E:, A:, then an empty one.
void add_device(UMockdevTestbed* testbed, const std::string& description);

// Answers an ioctl: its result and, where that is -1, errno.
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
