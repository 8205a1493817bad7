// MVR-xchange as the window shows it, and what the user asks for. Plain data: the loop of the preview fills it in and
// carries it out (preview_exchange.cpp).
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace footlight::tools {

struct ExchangeView {
  struct File {
    std::string uuid;
    std::string name;     // printable, as what follows
    std::string comment;  // may be empty
    std::uint64_t bytes = 0;
    bool operator==(const File&) const = default;
  };
  struct Station {
    std::string address;  // "10.0.0.7:42424"
    std::string name;
    std::string program;      // may be empty
    std::string group;        // may be empty
    bool joined = false;      // it has answered
    std::string trouble;      // why not; empty: it has, or the answer is under way
    std::vector<File> files;  // the newest is the last one
    bool operator==(const Station&) const = default;
  };
  // What is.
  bool on = false;      // stations are looked for
  std::string trouble;  // why they are not found, or do not find this one; empty: they are
  std::vector<Station> stations;
  std::string receiving;  // "tour.mvr, 34 %"; empty: nothing
  std::string sharing;    // "tour.mvr, 1.2 MB, to 2 stations"; empty: nothing
  bool makes = false;     // the file that is to be shared

  // What the user asks for; the loop carries it out and resets it.
  struct Wanted {
    std::string address;  // of a station
    std::string uuid;     // of its file; empty: the newest
    std::string name;     // of it
    bool operator==(const Wanted&) const = default;
  };
  bool looks = false;  // the menu is open: stations are looked for
  std::optional<Wanted> receive;
  bool stop_receiving = false;
  bool share = false;  // the rig as it is now
  bool stop_sharing = false;
  std::optional<std::string> add;  // a station that need not be found, by its address
  std::string address_text;        // in the field for that
  bool operator==(const ExchangeView&) const = default;
};

}  // namespace footlight::tools
