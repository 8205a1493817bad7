#include "drivers/net/osc_packet.h"

#include <algorithm>
#include <bit>

#include "drivers/net/bytes.h"

namespace footlight::drivers {
namespace {

using Bytes = std::span<const std::uint8_t>;
using Parsed = tl::expected<void, OscFault>;

constexpr std::string_view kBundle("#bundle\0", 8);
constexpr std::size_t kBundleHeaderBytes = 16;  // "#bundle" and a time tag

// Removes a string, its terminating zero and its padding from `rest`; nullopt: one of them is missing.
std::optional<std::string_view> take_string(Bytes& rest) {
  const auto end = std::find(rest.begin(), rest.end(), 0);
  if (end == rest.end()) return std::nullopt;
  const auto size = static_cast<std::size_t>(end - rest.begin());
  const std::size_t padded = (size / 4 + 1) * 4;
  if (padded > rest.size()) return std::nullopt;
  if (std::any_of(end, rest.begin() + static_cast<std::ptrdiff_t>(padded),
                  [](std::uint8_t octet) { return octet != 0; })) {
    return std::nullopt;
  }
  const std::string_view text(reinterpret_cast<const char*>(rest.data()), size);
  rest = rest.subspan(padded);
  return text;
}

std::uint64_t read_u64_be(Bytes bytes) { return std::uint64_t{read_u32_be(bytes, 0)} << 32 | read_u32_be(bytes, 4); }

double number_of(char type, Bytes bytes) {
  switch (type) {
    case 'i': return static_cast<std::int32_t>(read_u32_be(bytes, 0));
    case 'f': return static_cast<double>(std::bit_cast<float>(read_u32_be(bytes, 0)));
    case 'h': return static_cast<double>(static_cast<std::int64_t>(read_u64_be(bytes)));
    case 'd': return std::bit_cast<double>(read_u64_be(bytes));
    default: return type == 'T' ? 1.0 : 0.0;
  }
}

// Octets of an argument without a length of its own; nullopt for the other types.
std::optional<std::size_t> fixed_size_of(char type) {
  constexpr std::string_view kNone = "TFNI[]";
  constexpr std::string_view kFour = "ifcrm";
  constexpr std::string_view kEight = "hdt";
  if (kNone.find(type) != std::string_view::npos) return 0;
  if (kFour.find(type) != std::string_view::npos) return 4;
  if (kEight.find(type) != std::string_view::npos) return 8;
  return std::nullopt;
}

Parsed take_argument(char type, Bytes& rest, OscMessage& message) {
  if (const auto size = fixed_size_of(type)) {
    if (*size > rest.size()) return tl::unexpected(OscFault::kSize);
    const bool is_number = std::string_view("ifhdTF").find(type) != std::string_view::npos;
    if (!is_number || message.number_count == kOscNumbersMax) {
      message.all_numbers = false;
    } else {
      message.is_float[message.number_count] = type == 'f' || type == 'd';
      message.numbers[message.number_count++] = number_of(type, rest);
    }
    rest = rest.subspan(*size);
    return {};
  }
  message.all_numbers = false;
  if (type == 's' || type == 'S') return take_string(rest) ? Parsed() : tl::unexpected(OscFault::kSize);
  if (type != 'b') return tl::unexpected(OscFault::kTypes);
  if (rest.size() < 4) return tl::unexpected(OscFault::kSize);
  const std::size_t size = read_u32_be(rest, 0);
  rest = rest.subspan(4);
  if (size > rest.size() || (size + 3) / 4 * 4 > rest.size()) return tl::unexpected(OscFault::kSize);
  rest = rest.subspan((size + 3) / 4 * 4);
  return {};
}

Parsed parse_message(Bytes rest, std::vector<OscMessage>& into) {
  if (rest.size() % 4 != 0) return tl::unexpected(OscFault::kSize);
  const auto address = take_string(rest);
  if (!address || address->empty() || address->front() != '/') return tl::unexpected(OscFault::kAddress);
  const auto types = take_string(rest);
  if (!types || types->empty() || types->front() != ',') return tl::unexpected(OscFault::kTypes);
  OscMessage message;
  message.address = *address;
  message.all_numbers = true;
  for (const char type : types->substr(1)) {
    if (const Parsed taken = take_argument(type, rest, message); !taken) return taken;
  }
  if (!rest.empty()) return tl::unexpected(OscFault::kSize);
  into.push_back(message);
  return {};
}

Parsed parse_packet(Bytes packet, int depth, std::vector<OscMessage>& into) {
  if (packet.empty()) return tl::unexpected(OscFault::kEmpty);
  if (packet.front() != '#') return parse_message(packet, into);
  const std::string_view start(reinterpret_cast<const char*>(packet.data()), std::min<std::size_t>(packet.size(), 8));
  if (start != kBundle) return tl::unexpected(OscFault::kAddress);
  if (packet.size() < kBundleHeaderBytes) return tl::unexpected(OscFault::kSize);
  if (depth == kOscNestingMax) return tl::unexpected(OscFault::kNesting);
  Bytes rest = packet.subspan(kBundleHeaderBytes);
  while (!rest.empty()) {
    if (rest.size() < 4) return tl::unexpected(OscFault::kSize);
    const std::size_t size = read_u32_be(rest, 0);
    rest = rest.subspan(4);
    if (size % 4 != 0 || size > rest.size()) return tl::unexpected(OscFault::kSize);
    if (const Parsed parsed = parse_packet(rest.first(size), depth + 1, into); !parsed) return parsed;
    rest = rest.subspan(size);
  }
  return {};
}

// Appends a string with its zero and padding. False: it does not fit.
bool add_string(std::string_view text, std::span<std::uint8_t> out, std::size_t& size) {
  const std::size_t padded = (text.size() / 4 + 1) * 4;
  if (padded > out.size() - size) return false;
  const auto at = out.begin() + static_cast<std::ptrdiff_t>(size);
  std::fill(std::copy(text.begin(), text.end(), at), at + static_cast<std::ptrdiff_t>(padded), std::uint8_t{0});
  size += padded;
  return true;
}

}  // namespace

const char* text_of(OscFault fault) {
  switch (fault) {
    case OscFault::kEmpty: return "the packet is empty";
    case OscFault::kSize: return "a length exceeds the packet or is not a multiple of four";
    case OscFault::kAddress: return "an address does not begin with \"/\" or is not terminated";
    case OscFault::kTypes: return "the type tags are missing or unknown";
    case OscFault::kNesting: return "bundles are nested too deep";
  }
  return "?";
}

tl::expected<void, OscFault> parse_osc(std::span<const std::uint8_t> packet, std::vector<OscMessage>& into) {
  const std::size_t before = into.size();
  const Parsed parsed = parse_packet(packet, 0, into);
  if (!parsed) into.resize(before);
  return parsed;
}

std::size_t build_osc_float(std::string_view address, float number, std::span<std::uint8_t> out) {
  std::size_t size = 0;
  if (!add_string(address, out, size) || !add_string(",f", out, size) || out.size() - size < 4) return 0;
  write_u32_be(out, size, std::bit_cast<std::uint32_t>(number));
  return size + 4;
}

std::size_t build_osc(std::string_view address, std::span<const std::int32_t> numbers, std::span<std::uint8_t> out) {
  constexpr std::string_view kTypes = ",iiiiiiii";
  static_assert(kTypes.size() == 1 + kOscNumbersMax);
  std::size_t size = 0;
  if (numbers.size() > kOscNumbersMax || !add_string(address, out, size)) return 0;
  if (!add_string(kTypes.substr(0, 1 + numbers.size()), out, size)) return 0;
  if (numbers.size() * 4 > out.size() - size) return 0;
  for (const std::int32_t number : numbers) {
    write_u32_be(out, size, static_cast<std::uint32_t>(number));
    size += 4;
  }
  return size;
}

}  // namespace footlight::drivers
