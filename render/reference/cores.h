// Work that threads share.
#pragma once

#include <algorithm>
#include <functional>
#include <thread>
#include <vector>

namespace footlight::render {

// Calls `work` on so many threads, the caller's among them, and waits for all; 0: one per core. `work` takes its parts
// from a counter that the threads share, and does not throw.
inline void on_threads(int threads, const std::function<void()>& work) {
  const auto cores = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::vector<std::jthread> pool;
  for (int i = 1; i < (threads > 0 ? threads : cores); ++i) pool.emplace_back(work);
  work();
}

}  // namespace footlight::render
