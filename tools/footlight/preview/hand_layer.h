// Levels by hand in the window: what 'footlight set', OSC and MIDI have set over what drives the rig (decision 0151).
//
//   FL_ASSIGN(auto layer, HandLayer::open({.socket = "auto", .rig = path}, clock));
//   layer->join(*live);                                  // live inputs: a sender in their merge
//   layer->rest_on("faders", universes);                 // or over a log or faders
//   layer->follow(universes, levels);                    // once a picture
//   layer->overlay(universes, levels);                   // under what panels have taken over
//   layer->darken(universes, levels);                    // over it: the blackout
//
// The commands reach it as they reach a bridge: by a socket with the same pages, and by ports of controls. A log and
// faders count as one sender with the default priority that has every slot; they feed a pump of the layer's own, so
// that fades start from the levels that are shown, and all pages show them.
//
// Threads: all calls belong to one thread, the window's. The socket and the pump have theirs.
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "sim/core/clock.h"
#include "sim/core/ports.h"
#include "sim/core/result.h"
#include "sim/hand.h"
#include "sim/pump.h"
#include "sim/universes.h"
#include "tools/footlight/hand/hand_desk.h"
#include "tools/footlight/preview/live_levels.h"
#include "tools/footlight/status/http_server.h"
#include "tools/footlight/status/status_pages.h"

namespace footlight::tools {

// The levels of a log or of faders as a sender: they are given once a picture and sent when they have changed.
// give() belongs to the window's thread, the rest to the pump's.
class BaseFeed final : public Source {
 public:
  // universes: ascending, at least one.
  BaseFeed(std::string name, std::span<const Universe> universes) : name_(std::move(name)), given_(universes) {}

  // 512 levels for each of its universes. True if some have changed: hurry() is due, on the pump's thread.
  bool give(TimeNs now_ns, std::span<const std::uint8_t> levels);
  void hurry() { due_ns_ = 0; }

  [[nodiscard]] std::string name() const override { return name_; }
  [[nodiscard]] TimeNs next_deadline_ns() const override { return due_ns_; }
  [[nodiscard]] PortState state() const override { return PortState::kWorking; }
  [[nodiscard]] PortCounters counters() const override { return {.frames = sequence_}; }
  [[nodiscard]] std::span<const Universe> universes() const override { return given_.numbers(); }
  Status poll(TimeNs now_ns, FrameReceiver& receiver) override;

 private:
  const std::string name_;
  Universes given_;  // written by the window's thread
  TimeNs due_ns_ = kTimeNever;
  std::vector<std::uint32_t> sent_;  // the revision of each universe that was sent
  std::uint32_t sequence_ = 0;
};

class HandLayer {
 public:
  struct Options {
    std::string socket = "auto";        // a file; auto: preview.sock or preview-PID.sock of the socket's folder; none
    std::string rig;                    // the path of the rig's file, for names of fixtures; "": unknown
    std::shared_ptr<Tempo> tempo = {};  // of the made-up inputs; null: there are none
  };
  // The clock must be thread-safe and outlive this. Errors: those of HttpServer::listen() for a socket that is named.
  [[nodiscard]] static Result<std::unique_ptr<HandLayer>> open(const Options& options, Clock& clock);
  ~HandLayer();
  HandLayer(const HandLayer&) = delete;
  HandLayer& operator=(const HandLayer&) = delete;

  // What drives the rig from now on. What is set stays, but for universes that are gone. `live` must not end before
  // leave(). Without universes the layer has no pump: commands are refused until the next call. levels: of the log or
  // the faders, from which a fade begins; empty: not known before the next follow(), and 0 until then.
  void join(LiveLevels& live);
  Status rest_on(std::string name, std::span<const Universe> universes, std::span<const std::uint8_t> levels = {});
  void leave();

  // Ports that speak to link(), such as OSC and MIDI. They stay whatever drives the rig.
  [[nodiscard]] const std::shared_ptr<HandLink>& link() const { return link_; }
  [[nodiscard]] bool has_controls() const { return !controls_.empty(); }
  void add_control(std::unique_ptr<Source> port);
  void remove_control(const std::string& name);  // it is closed when this returns

  // The newest of what is held, and for the layer's own pump the levels of the log or the faders.
  void follow(std::span<const Universe> universes, std::span<const std::uint8_t> levels);
  // As of the last follow(). True if levels are not those of the log or the faders.
  [[nodiscard]] bool overlays() const { return own_ != nullptr && shown_.any(); }
  // levels: 512 for each of `universes`, ascending. overlay() does nothing over live inputs, whose merge has it.
  void overlay(std::span<const Universe> universes, std::span<std::uint8_t> levels) const;
  void darken(std::span<const Universe> universes, std::span<std::uint8_t> levels) const;

  // Of the layer's own pump, while something is held or there is a control; else nullptr.
  [[nodiscard]] LiveLevels* shown() {
    return own_ != nullptr && (shown_.any() || !controls_.empty()) ? own_.get() : nullptr;
  }
  // What is held: how many slots, and whether a blackout is on.
  [[nodiscard]] const HandShown& held() const { return shown_; }
  // Events since the last call, also of commands that were refused. At most the last 64.
  [[nodiscard]] std::vector<std::string> notices();
  // A command of the window itself, carried out soon.
  void command(HandAction action);
  [[nodiscard]] const std::string& socket() const { return socket_; }  // the file; empty: none

 private:
  HandLayer(std::string rig, Clock& clock);
  [[nodiscard]] Status listen(const std::string& socket);
  [[nodiscard]] HttpAnswer answer(const HttpRequest& request);
  void enter(Pump& pump);
  static void finish_turn(Pump& pump);
  void show_pages(Pump& pump);
  [[nodiscard]] std::vector<Source*> ports() const;
  void note(std::string text);

  Clock& clock_;
  const std::string rig_;
  HandShown shown_;
  std::mutex mutex_;
  std::vector<std::string> notices_;  // guarded by mutex_
  HandDesk desk_;
  std::shared_ptr<HandLink> link_;
  std::vector<std::unique_ptr<Source>> controls_;
  std::unique_ptr<LiveLevels> own_;  // over a log or faders
  BaseFeed* feed_ = nullptr;         // of own_
  std::vector<Universe> fed_;        // its universes
  Pump* joined_ = nullptr;           // that of own_ or of live inputs
  std::mutex pages_mutex_;
  std::unique_ptr<StatusPages> pages_;  // guarded by pages_mutex_
  std::string socket_;
  std::unique_ptr<HttpServer> server_;  // ends first
};

}  // namespace footlight::tools
