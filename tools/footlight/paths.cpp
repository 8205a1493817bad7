#include "tools/footlight/paths.h"

#include <algorithm>
#include <cstdlib>
#include <filesystem>

#include <unistd.h>

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

// A variable with a path; relative paths are ignored, as the specification requires.
std::string folder_of(const char* variable) {
  const char* const value = std::getenv(variable);
  return value != nullptr && value[0] == '/' ? value : "";
}

// Empty: neither variable is set.
std::string config_folder() {
  const std::string config = folder_of("XDG_CONFIG_HOME");
  const std::string home = folder_of("HOME");
  return config.empty() && !home.empty() ? home + "/.config" : config;
}

}  // namespace

std::vector<std::string> show_file_places() {
  std::vector<std::string> places;
  const std::string config = config_folder();
  if (!config.empty()) places.push_back(config + "/footlight/show.toml");
  places.emplace_back("/etc/footlight/show.toml");
  return places;
}

Result<std::string> find_show_file() {
  std::string list;
  for (const std::string& place : show_file_places()) {
    std::error_code error;
    if (fs::exists(place, error)) return place;
    list += (list.empty() ? "" : " or ") + place;
  }
  return fail(ErrorCode::kNotFound,
              "no show file: there is no {}; create one, name one, or give ports as in 'footlight run --in sacn:1-9 "
              "--out enttec-pro'",
              list);
}

std::string scene_file_place() {
  const std::string config = config_folder();
  return config.empty() ? "" : config + "/footlight/scenes.toml";
}

std::vector<std::string> socket_folders() {
  std::vector<std::string> folders;
  const std::string services = folder_of("RUNTIME_DIRECTORY");  // several are separated by colons
  const std::string service = services.substr(0, services.find(':'));
  const std::string user = folder_of("XDG_RUNTIME_DIR");
  if (!service.empty()) folders.push_back(service);
  if (!user.empty()) folders.push_back(user + "/footlight");
  if (service != "/run/footlight") folders.emplace_back("/run/footlight");
  return folders;
}

std::string make_socket_folder() {
  for (const std::string& folder : socket_folders()) {
    std::error_code error;
    fs::create_directory(folder, error);
    if (fs::is_directory(folder, error) && access(folder.c_str(), W_OK | X_OK) == 0) return folder;
  }
  return "";
}

std::string cache_folder() {
  const char* const wanted = std::getenv("FOOTLIGHT_PIPELINE_CACHE");
  if (wanted != nullptr && std::string_view(wanted) == "off") return "";
  const std::string cache = folder_of("XDG_CACHE_HOME");
  const std::string home = folder_of("HOME");
  if (!cache.empty()) return cache + "/footlight";
  return home.empty() ? "" : home + "/.cache/footlight";
}

std::string state_folder() {
  const std::string state = folder_of("XDG_STATE_HOME");
  const std::string home = folder_of("HOME");
  if (!state.empty()) return state + "/footlight";
  return home.empty() ? "" : home + "/.local/state/footlight";
}

std::vector<std::string> sockets(std::string_view kind) {
  std::vector<std::string> found;
  for (const std::string& folder : socket_folders()) {
    std::vector<std::string> here;
    std::error_code error;
    for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
      std::error_code gone;
      const std::string name = at->path().filename().string();
      if (name.starts_with(kind) && at->is_socket(gone)) here.push_back(at->path().string());
    }
    std::sort(here.begin(), here.end());
    found.insert(found.end(), here.begin(), here.end());
  }
  return found;
}

}  // namespace footlight::tools
