// MVR-xchange beside a window: a thread of its own finds stations, receives rigs and shares one. The window's thread
// asks and looks, and waits for nothing but the end of the object.
//
// Threads: one calls; the work is on another one.
#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <variant>
#include <vector>

#include "drivers/net/mvr_xchange_group.h"
#include "fixtures/files/import/import_rig.h"
#include "tools/footlight/mvr/exchange_view.h"
#include "tools/footlight/mvr/received_file.h"

namespace footlight::tools {

// This program as a station. `part`: empty where a file is shared. The UUID is the same after every start. The parts of
// one machine have different ones: a list that ends must not end the membership of a file that is shared. `name`: empty
// for "Footlight PART on HOST".
[[nodiscard]] drivers::MvrStation own_mvr_station(const std::string& name, const char* part);

// Where a file that a station calls `proposed` is written: its last part in `folder`, without what names of files may
// not have, and with ".mvr". Names that exist get " 2" and so on. `station`: the name if nothing is left.
[[nodiscard]] std::string received_path(const std::string& folder, const std::string& proposed,
                                        const std::string& station);

class MvrExchange {
 public:
  struct Options {
    bool finds = true;              // by Avahi; else stations are named
    // In place of Avahi, for tests. On the thread.
    std::function<Result<std::unique_ptr<drivers::MvrDiscovery>>()> open_discovery = nullptr;
    std::uint32_t listen_ipv4 = 0;  // where a rig is shared; 0: on all interfaces
    std::string station_name;       // empty: as of own_mvr_station()
  };
  struct Event {
    enum class Kind {
      kNews,
      kError,
      kReceived,  // the file at `path` is a rig
    };
    Kind kind = Kind::kNews;
    std::string text;
    std::string path;
  };

  explicit MvrExchange(const Options& options);
  // Leaves the stations, and waits for their answers for half a second. Waits as well for what the thread is at: a name
  // that is resolved, the file that is made to be shared, or a received file that is written and read as a rig.
  ~MvrExchange();
  MvrExchange(const MvrExchange&) = delete;
  MvrExchange& operator=(const MvrExchange&) = delete;

  // A station by its address. A name in it is resolved by the thread.
  void add(std::string address);
  // A file of a station, into `folder`. Only one at a time: else an error comes.
  void receive(ExchangeView::Wanted wanted, std::string folder);
  void stop_receiving();
  // Offers the rig as an MVR file of this name, which the thread makes; instead of the one before.
  void share(std::shared_ptr<const fixtures::ImportedRig> rig, std::string file_name);
  void stop_sharing();
  // Ends soon; ended() is true then, and the end of the object does not wait.
  void stop();
  [[nodiscard]] bool ended() const;

  // Takes over what is. False: it is the same as at the last call.
  [[nodiscard]] bool look(ExchangeView& view);
  [[nodiscard]] std::vector<Event> take_events();
  // Until something is new, at most that long; for tests.
  void wait_for_news(DurationNs most_ns);

 private:
  class Work;  // on the thread
  struct Add {
    std::string address;
  };
  struct Receive {
    ExchangeView::Wanted wanted;
    std::string folder;
  };
  struct StopReceiving {};
  struct Share {
    std::shared_ptr<const fixtures::ImportedRig> rig;  // null: no longer
    std::string file_name;
  };
  using Request = std::variant<Add, Receive, StopReceiving, Share>;
  void ask(Request request);

  mutable std::mutex mutex_;
  std::condition_variable news_;
  std::deque<Request> requests_;
  ExchangeView view_;  // its first part
  std::uint64_t revision_ = 0;
  std::uint64_t looked_ = 0;
  std::uint64_t waited_ = 0;
  std::vector<Event> events_;
  bool ended_ = false;
  std::jthread thread_;  // last: ends before what it uses
};

}  // namespace footlight::tools
