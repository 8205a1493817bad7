#include "tools/footlight/paths.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>

#include <doctest/doctest.h>

#include "tests/tools/footlight/run_footlight.h"

namespace footlight::tools {
namespace {

// Sets environment variables for a test and restores them after it. nullptr: not set.
class Environment {
 public:
  explicit Environment(const std::map<std::string, const char*>& variables) {
    for (const auto& [name, value] : variables) {
      const char* const before = std::getenv(name.c_str());
      before_[name] = before == nullptr ? std::nullopt : std::optional<std::string>(before);
      set(name, value);
    }
  }
  ~Environment() {
    for (const auto& [name, value] : before_) set(name, value ? value->c_str() : nullptr);
  }
  Environment(const Environment&) = delete;
  Environment& operator=(const Environment&) = delete;

 private:
  static void set(const std::string& name, const char* value) {
    if (value == nullptr) {
      unsetenv(name.c_str());
    } else {
      setenv(name.c_str(), value, 1);
    }
  }
  std::map<std::string, std::optional<std::string>> before_;
};

using Paths = std::vector<std::string>;

TEST_CASE("a show file is searched where the XDG specification requires, then in /etc") {
  const std::string etc = "/etc/footlight/show.toml";
  {
    const Environment environment({{"XDG_CONFIG_HOME", "/x/config"}, {"HOME", "/x/home"}});
    CHECK(show_file_places() == Paths{"/x/config/footlight/show.toml", etc});
  }
  {
    const Environment environment({{"XDG_CONFIG_HOME", "relative"}, {"HOME", "/x/home"}});
    CHECK(show_file_places() == Paths{"/x/home/.config/footlight/show.toml", etc});
  }
  const Environment environment({{"XDG_CONFIG_HOME", nullptr}, {"HOME", nullptr}});
  CHECK(show_file_places() == Paths{etc});
}

TEST_CASE("what survives a crash is where the XDG specification has a user's state") {
  {
    const Environment environment({{"XDG_STATE_HOME", "/x/state"}, {"HOME", "/x/home"}});
    CHECK(state_folder() == "/x/state/footlight");
  }
  {
    const Environment environment({{"XDG_STATE_HOME", "relative"}, {"HOME", "/x/home"}});
    CHECK(state_folder() == "/x/home/.local/state/footlight");
  }
  const Environment environment({{"XDG_STATE_HOME", nullptr}, {"HOME", nullptr}});
  CHECK(state_folder().empty());
}

TEST_CASE("the socket is in the folder of the service, else of the user, else of the system") {
  {
    const Environment environment(
        {{"RUNTIME_DIRECTORY", "/run/footlight:/run/more"}, {"XDG_RUNTIME_DIR", "/run/user/7"}});
    CHECK(socket_folders() == Paths{"/run/footlight", "/run/user/7/footlight"});
  }
  const Environment environment({{"RUNTIME_DIRECTORY", nullptr}, {"XDG_RUNTIME_DIR", "/run/user/7"}});
  CHECK(socket_folders() == Paths{"/run/user/7/footlight", "/run/footlight"});
}

TEST_CASE("run without a show file and without ports uses the show file of the user") {
  if (std::filesystem::exists("/etc/footlight/show.toml")) {
    MESSAGE("skipped: this machine has a show file of its own");
    return;
  }
  const testing::TempFolder folder;
  const std::map<std::string, std::string> environment = {{"XDG_CONFIG_HOME", folder.file("")}};
  const auto run = [&] { return testing::Footlight({"run", "--for", "0s"}, environment).wait(); };
  const auto missing = run();
  CHECK(missing.exit_code == 3);
  CHECK(missing.err.find("/footlight/show.toml or /etc/footlight/show.toml") != std::string::npos);
  CHECK(missing.err.find("footlight run --in sacn:1-9") != std::string::npos);
  std::filesystem::create_directory(folder.file("footlight"));
  std::ofstream(folder.file("footlight/show.toml"))
      << "[[in]]\nendpoint = \"mock:enttec-pro=7\"\n[[out]]\nendpoint = \"mock:enttec-pro=8\"\n";
  const auto found = run();
  CAPTURE(found.err);
  CHECK(found.exit_code == 0);
  CHECK(found.err.find("no input receives universe 8") != std::string::npos);
}

}  // namespace
}  // namespace footlight::tools
