// Paths of files, by the XDG base directory specification 0.8 and, as a service, by systemd.exec(5).
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "sim/core/result.h"

namespace footlight::tools {

// Default paths of the show file, best first: $XDG_CONFIG_HOME/footlight/show.toml (or ~/.config/...),
// /etc/footlight/show.toml.
[[nodiscard]] std::vector<std::string> show_file_places();
// The first of them that exists. kNotFound lists them.
[[nodiscard]] Result<std::string> find_show_file();

// The scenes of 'footlight scene': $XDG_CONFIG_HOME/footlight/scenes.toml (or ~/.config/...). Empty: neither is set.
[[nodiscard]] std::string scene_file_place();

// Folders for the socket of a bridge, best first: $RUNTIME_DIRECTORY (of a service), $XDG_RUNTIME_DIR/footlight,
// /run/footlight.
[[nodiscard]] std::vector<std::string> socket_folders();
// The folder for this program's socket: the first of them that exists or can be created; empty: none.
[[nodiscard]] std::string make_socket_folder();

inline constexpr std::string_view kSocketName = "run.sock";
inline constexpr std::string_view kPreviewSocketName = "preview.sock";
// Sockets of programs that run, or that were killed: of bridges ("run"), or of windows ("preview"). In the order of
// socket_folders(), then by name.
[[nodiscard]] std::vector<std::string> sockets(std::string_view kind = "run");

// Where compiled pipelines are kept: $XDG_CACHE_HOME/footlight (or ~/.cache/footlight). Empty: nowhere, as
// FOOTLIGHT_PIPELINE_CACHE=off asks for.
[[nodiscard]] std::string cache_folder();

// Where what must survive a crash is kept: $XDG_STATE_HOME/footlight (or ~/.local/state/footlight). Empty: neither is
// set.
[[nodiscard]] std::string state_folder();

}  // namespace footlight::tools
