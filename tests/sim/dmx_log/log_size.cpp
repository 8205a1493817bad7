// Prints the size of a minute of 9 universes at 44 Hz as OLA Show text and as a DMX log, and the processor time of
// writing, reading and seeking. Not a test: run it manually, in an optimised build.
//   log_size [block span in s] [compression level]
#include <cstdio>
#include <cstdlib>

#include <time.h>

#include "sim/dmx_log/log_ports.h"
#include "sim/dmx_log/ola_show.h"
#include "tests/sim/dmx_log/patterns.h"

using namespace footlight;
using namespace footlight::testing;

namespace {

// Processor time, not wall time: other work on the machine does not count.
double now_s() {
  timespec now{};
  ::clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

template <class T>
T must(Result<T> result) {
  if (!result) {
    std::fprintf(stderr, "%s\n", result.error().message.c_str());
    std::exit(1);
  }
  return std::move(*result);
}

void must(const Status& status) {
  if (!status) {
    std::fprintf(stderr, "%s\n", status.error().message.c_str());
    std::exit(1);
  }
}

}  // namespace

int main(int argc, char** argv) {
  LogWriterOptions options;
  options.overwrite = true;
  if (argc > 1) options.block_span_ns = static_cast<DurationNs>(std::atof(argv[1]) * 1e9);
  if (argc > 2) options.compression_level = std::atoi(argv[2]);
  const TempFolder folder;
  const std::string path = folder.file("a.dmxlog");
  const std::string text_path = folder.file("a.show");
  std::printf("%-20s %12s %12s %8s | %10s %10s %10s %9s %9s\n", "pattern", "OLA bytes", "log bytes", "ratio",
              "us/frame", "max us", "send us", "read us", "seek us");
  for (const auto& [pattern, name] : kPatterns) {
    std::vector<OwnedFrame> frames;
    play_pattern(pattern, 60.0, [&](const FrameView& view) {
      OwnedFrame frame{view.stamp_ns, view.universe, view.sender, view.sequence, view.priority, false, {}};
      frame.slots.assign(view.slots.begin(), view.slots.end());
      frames.push_back(std::move(frame));
    });
    LogWriter writer = must(LogWriter::create(path, options));
    OlaShowWriter text = must(OlaShowWriter::create(text_path, true));
    double total_s = 0.0;
    double worst_s = 0.0;
    for (const OwnedFrame& frame : frames) {
      const double begin_s = now_s();
      must(writer.append(frame.view()));
      const double took_s = now_s() - begin_s;
      total_s += took_s;
      worst_s = std::max(worst_s, took_s);
    }
    must(writer.close(60 * kNsPerS));
    for (const OwnedFrame& frame : frames) must(text.append(frame.time_ns, frame.universe, frame.slots));
    must(text.close(60 * kNsPerS));

    // The cost for the pump: the copy in send(), while the sink's own thread compresses.
    LogSinkOptions sink_options;
    sink_options.universes = {1, 2, 3, 4, 5, 6, 7, 8, 9};
    sink_options.waiting_bytes_max = 256u << 20;
    auto sink = must(LogSink::create(folder.file(std::string("sink") + name), sink_options));
    double begin_s = now_s();
    for (const OwnedFrame& frame : frames) {
      const FrameView view = frame.view();
      must(sink->send(frame.time_ns, {&view, 1}));
    }
    const double send_s = now_s() - begin_s;
    sink->close(60 * kNsPerS);

    LogReader reader = must(LogReader::open(path));
    LogFrame frame;
    begin_s = now_s();
    while (must(reader.next(frame))) {
    }
    const double read_s = now_s() - begin_s;
    begin_s = now_s();
    Random random(3);
    for (int i = 0; i < 100; ++i) must(reader.seek(static_cast<DurationNs>(random.below(60'000'000'000))));
    const double seek_s = (now_s() - begin_s) / 100.0;

    const double text_bytes = static_cast<double>(std::filesystem::file_size(text_path));
    const double log_size = static_cast<double>(std::filesystem::file_size(path));
    const double count = static_cast<double>(frames.size());
    std::printf("%-20s %12.0f %12.0f %8.1f | %10.2f %10.0f %10.2f %9.2f %9.0f\n", name, text_bytes, log_size,
                text_bytes / log_size, total_s / count * 1e6, worst_s * 1e6, send_s / count * 1e6, read_s / count * 1e6,
                seek_s * 1e6);
  }
  return 0;
}
