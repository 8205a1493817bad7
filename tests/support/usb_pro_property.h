// Properties of the parser for any bytes from a widget; shared by the fuzz target and the mutation test.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "drivers/widgets/enttec_pro_frame.h"

namespace footlight::testing {

using ProMessages = std::vector<std::pair<std::uint8_t, std::vector<std::uint8_t>>>;  // label, payload

struct ProParse {
  ProMessages messages;
  std::uint64_t garbage_byte_count = 0;
};

// The definition, with the whole stream available: a message starts at a start byte with a valid length and an end byte
// at its place. Every other byte is skipped.
inline ProParse parse_whole(std::span<const std::uint8_t> stream) {
  ProParse parse;
  for (std::size_t i = 0; i < stream.size();) {
    if (stream[i] == drivers::kProStart && i + 4 < stream.size()) {
      const std::size_t size = stream[i + 2] | static_cast<std::size_t>(stream[i + 3]) << 8;
      if (size <= drivers::kProPayloadSizeMax && i + 4 + size < stream.size() &&
          stream[i + 4 + size] == drivers::kProEnd) {
        const auto payload = stream.subspan(i + 4, size);
        parse.messages.emplace_back(stream[i + 1], std::vector<std::uint8_t>(payload.begin(), payload.end()));
        i += size + drivers::kProEnvelopeSize;
        continue;
      }
    }
    ++parse.garbage_byte_count;
    ++i;
  }
  return parse;
}

// The parser under test, fed with pieces of the sizes from next_size() (at least 1 each).
template <class NextSize>
ProParse parse_pieces(std::span<const std::uint8_t> stream, NextSize&& next_size) {
  drivers::ProParser parser;
  ProParse parse;
  while (!stream.empty()) {
    const std::size_t size = std::min<std::size_t>(next_size(), stream.size());
    std::span<const std::uint8_t> piece = stream.first(size);
    stream = stream.subspan(size);
    drivers::ProMessageView message;
    while (parser.next(piece, message))
      parse.messages.emplace_back(message.label,
                                  std::vector<std::uint8_t>(message.payload.begin(), message.payload.end()));
  }
  parse.garbage_byte_count = parser.garbage_byte_count();
  return parse;
}

// Empty if all hold for `bytes`, else the one that does not. cut_seed selects where the stream is divided.
inline std::string check_pro_stream(std::span<const std::uint8_t> bytes, std::uint64_t cut_seed) {
  // After a flush no message is unfinished, and a last valid one must be found.
  std::vector<std::uint8_t> stream(bytes.begin(), bytes.end());
  const auto flush = drivers::pro_flush_bytes();
  stream.insert(stream.end(), flush.begin(), flush.end());
  const auto last = drivers::encode_get_serial();
  stream.insert(stream.end(), last.bytes().begin(), last.bytes().end());

  const ProParse expected = parse_whole(stream);
  auto cut_anywhere = [state = cut_seed | 1u]() mutable {
    state = state * 6364136223846793005u + 1442695040888963407u;
    return 1 + static_cast<std::size_t>(state >> 33) % 97;
  };
  for (const ProParse& got :
       {parse_pieces(stream, [&] { return stream.size(); }), parse_pieces(stream, cut_anywhere)}) {
    if (got.messages != expected.messages) return "the messages depend on how the stream is cut";
    if (got.garbage_byte_count != expected.garbage_byte_count)
      return "a byte is in no message and not counted as garbage";
  }
  if (expected.messages.empty() || expected.messages.back().first != 10) return "the last good message was not found";

  drivers::LineFrame frame{};
  for (const auto& [label, payload] : expected.messages) {
    (void)drivers::decode_params(payload);
    (void)drivers::decode_serial(payload);
    (void)drivers::decode_receive_mode(payload);
    (void)drivers::decode_send_dmx(payload);
    if (const auto received = drivers::decode_received(payload); received && received->frame.size() > frame.size())
      return "a received frame is longer than a line frame";
    const drivers::LineFrame before = frame;
    if (!drivers::apply_change_of_state(payload, frame) && frame != before)
      return "a refused change of state was applied";
  }
  return {};
}

}  // namespace footlight::testing
