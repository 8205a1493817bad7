// The demo show as the bytes of a DMX log, made by the build (tools/demo_show/compose_demo.cpp) and embedded.
#pragma once

#include <cstdint>
#include <span>

namespace footlight::demo {

// A whole .dmxlog for demo_rig(). Static; any thread.
[[nodiscard]] std::span<const std::uint8_t> demo_log_bytes();

}  // namespace footlight::demo
