// Display names for senders that a port receives: the name in their packets and their address.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <string>
#include <string_view>
#include <unordered_map>

#include "drivers/net/bytes.h"
#include "drivers/net/udp.h"
#include "sim/core/dmx.h"

namespace footlight::drivers {

class SenderNames {
 public:
  // The maximum of senders stored. A further one replaces the one silent for longest, so that a flood of forged senders
  // uses no memory.
  static constexpr std::size_t kSendersMax = 256;
  static constexpr std::size_t kNameBytesMax = 63;

  SenderNames() { senders_.reserve(kSendersMax); }

  // Call with every packet: names and addresses change. Allocates for a new sender only.
  void note(SenderId id, std::string_view name, std::uint32_t ipv4, TimeNs now_ns) {
    auto at = senders_.find(id);
    if (at == senders_.end()) {
      if (senders_.size() == kSendersMax) {
        senders_.erase(std::min_element(senders_.begin(), senders_.end(), [](const auto& a, const auto& b) {
          return a.second.received_ns < b.second.received_ns;
        }));
      }
      at = senders_.emplace(id, Sender{}).first;
    }
    Sender& sender = at->second;
    sender.received_ns = now_ns;
    sender.ipv4 = ipv4;
    const std::string_view kept = cut_utf8(name, kNameBytesMax);
    sender.size = static_cast<std::uint8_t>(kept.size());
    std::memcpy(sender.name.data(), kept.data(), kept.size());
  }

  // "FOH desk (10.0.0.7)"; "10.0.0.7" for a sender without a name; empty: unknown sender. Control characters are
  // replaced by "?", since names come from the network and are printed on terminals.
  [[nodiscard]] std::string text_of(SenderId id) const {
    const auto at = senders_.find(id);
    if (at == senders_.end()) return {};
    const std::string name = printable({at->second.name.data(), at->second.size});
    const std::string address = text_of_ipv4(at->second.ipv4);
    return name.empty() ? address : name + " (" + address + ")";
  }

  [[nodiscard]] static std::string printable(std::string_view name) {
    std::string text(name);
    for (std::size_t i = 0; i < text.size(); ++i) {
      const auto octet = static_cast<unsigned char>(text[i]);
      // U+0080 to U+009F, which some terminals interpret too, are C2 80 to C2 9F in UTF-8.
      const bool is_c1 =
          octet == 0xC2 && i + 1 < text.size() && (static_cast<unsigned char>(text[i + 1]) & 0xE0) == 0x80;
      if (is_c1) text.replace(i, 2, "?");
      if (octet < 0x20 || octet == 0x7F) text[i] = '?';
    }
    return text;
  }

 private:
  struct Sender {
    std::array<char, kNameBytesMax> name = {};
    std::uint8_t size = 0;
    std::uint32_t ipv4 = 0;
    TimeNs received_ns = 0;
  };
  std::unordered_map<SenderId, Sender> senders_;
};

}  // namespace footlight::drivers
