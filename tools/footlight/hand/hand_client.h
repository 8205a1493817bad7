// The commands that speak to the hand of a running bridge: its socket, and targets on the command line.
//
// A target is slots ("1.17", "1.1-12") or fixtures of a rig ("Mover 3", "Mover *:Tilt"). The rig is read only if a
// target needs it: that of --rig, else the one with which the bridge was started.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fixtures/model/rig.h"
#include "sim/core/clock.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "tools/footlight/command.h"

namespace footlight::tools {

struct HandClientOptions {
  std::string socket;
  std::string rig;
};
void add_hand_options(Arguments& arguments, HandClientOptions& options);

class HandClient {
 public:
  // `command`: as typed, for messages: "set". Errors: those of find_bridge().
  [[nodiscard]] static Result<HandClient> connect(const HandClientOptions& options, const std::string& command);

  // Errors: kPermission; kBadInput: the bridge refused it; kUnsupported: the bridge has no hand; those of
  // http_request().
  [[nodiscard]] Status send(const HandCommand& command) const;
  // Prints on standard error, if that is a terminal, what a command did, and that a blackout hides it if one is on.
  void report(const std::string& done) const;
  // The page of GET /hand.
  [[nodiscard]] Result<std::string> page() const;
  // The merged levels of every universe of the bridge, each slot a level.
  [[nodiscard]] Result<std::vector<HandLevel>> merged_levels() const;

  // "1.17=255", "Mover 3:Tilt=30".
  [[nodiscard]] Result<std::vector<HandLevel>> assignments(const std::vector<std::string>& texts);
  // "1.17", "Mover 3", "Mover 3:Tilt"; values are 0.
  [[nodiscard]] Result<std::vector<HandLevel>> targets(const std::vector<std::string>& texts);
  // The rig; `target` is what needs it, for messages.
  [[nodiscard]] Result<const fixtures::Rig*> rig(const std::string& target);
  // Of --rig alone: nullptr without it.
  [[nodiscard]] Result<const fixtures::Rig*> named_rig();

  // Prints on standard error what a command did, if that is a terminal: jobs of cron and scripts stay silent.
  static void print_done(const std::string& done);

 private:
  HandClient(std::string socket, std::string rig) : socket_(std::move(socket)), rig_path_(std::move(rig)) {}
  std::string socket_;
  std::string rig_path_;
  std::optional<fixtures::Rig> rig_;
};

}  // namespace footlight::tools
