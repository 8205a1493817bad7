// What the files of `footlight log` share: reading logs of every format.
#pragma once

#include <string>

#include "drivers/capture/captures.h"
#include "sim/dmx_log/dmx_log.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

inline constexpr const char* kLogFileHelp =
    "a DMX log, OLA show file, packet capture (pcap, pcapng), sigrok capture (.sr), sound map (.toml) or video";

// Options for reading files that are not DMX logs.
struct ReadArguments {
  drivers::CaptureOptions options;
  std::string protocol;
  std::string grid;

  void add(Arguments& arguments) {
    arguments.option("--universe-offset", options.universe_offset, 0, 1,
                     "OLA show file: 1 if it counts universes from 0");
    arguments.option("--protocol", protocol, "NAME", "packet capture: only 'sacn' or only 'artnet'");
    arguments.flag("--preview", options.net.hear_preview, "packet capture: include sACN frames for visualisers");
    arguments.option("--grid", grid, "OPTIONS",
                     "video: options of the grid, as of a vrsl endpoint ('layout=vertical-left&planes=rgb'); default: "
                     "what is found in its pictures");
    add_line(arguments);
    arguments.option("--universe", options.universe, kUniverseMin, kUniverseMax,
                     "sigrok capture: the universe of the line");
  }

  void add_line(Arguments& arguments) {
    arguments.option(
        "--channel", options.channel, "NAME",
        "sigrok capture: the channel, by its name or number from 1; default: the one with the most levels");
    arguments.flag("--inverted", options.inverted, "sigrok capture: --channel is DMX-");
  }

  [[nodiscard]] Result<drivers::CaptureOptions> read() const {
    drivers::CaptureOptions read = options;
    if (!protocol.empty() && protocol != "sacn" && protocol != "artnet") {
      return fail(ErrorCode::kBadInput, "--protocol: expected 'sacn' or 'artnet', got '{}'", protocol);
    }
    if (options.inverted && options.channel.empty()) {
      return fail(ErrorCode::kBadInput,
                  "--inverted: expected --channel as well, for example '--channel DMX- --inverted'");
    }
    read.net.sacn = protocol != "artnet";
    read.net.artnet = protocol != "sacn";
    return read;
  }
};

// A log, or another file as a log in memory.
[[nodiscard]] Result<LogReader> read_input(const std::string& path, const drivers::CaptureOptions& read,
                                           const ReadArguments& arguments);

// Adds `log compare`.
void add_log_compare(Arguments& arguments);

}  // namespace footlight::tools
