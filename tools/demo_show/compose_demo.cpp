// Writes the demo show as a DMX log: compose_demo OUTPUT.dmxlog. Run by the build; equal input gives equal bytes.
#include <cstdio>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/dmx_log/dmx_log.h"
#include "tools/demo_show/demo_show.h"

namespace footlight {
namespace {

Status compose(const std::string& path) {
  const demo::DemoShow show(fixtures::demo_rig());
  LogWriterOptions options;
  options.universes = show.universes();
  options.overwrite = true;
  options.compression_level = 19;  // written once, read often
  FL_ASSIGN(LogWriter writer, LogWriter::create(path, options));
  std::vector<Slots> levels(show.universes().size());
  const auto frames = static_cast<int>(demo::kShowLengthS * demo::kShowRateHz);
  for (int frame = 0; frame < frames; ++frame) {
    show.levels_at(static_cast<double>(frame) / demo::kShowRateHz, levels);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      FrameView view;
      view.universe = show.universes()[i];
      view.stamp_ns = frame * kNsPerS / demo::kShowRateHz;
      view.sender = 1;
      view.sequence = static_cast<std::uint32_t>(frame & 0xff);
      view.slots = levels[i];
      FL_TRY(writer.append(view));
    }
  }
  return writer.close(static_cast<TimeNs>(demo::kShowLengthS * 1e9));
}

}  // namespace
}  // namespace footlight

int main(int argument_count, char** arguments) {
  if (argument_count != 2) {
    std::fputs("usage: compose_demo OUTPUT.dmxlog\n", stderr);
    return 2;
  }
  if (const footlight::Status status = footlight::compose(arguments[1]); !status) {
    std::fprintf(stderr, "compose_demo: %s\n", status.error().message.c_str());
    return 1;
  }
  return 0;
}
