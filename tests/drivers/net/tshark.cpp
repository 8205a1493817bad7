#include "tests/drivers/net/tshark.h"
#include "tests/support/temp_folder.h"

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <unistd.h>

namespace footlight::testing {
namespace {

// Little-endian capture of raw IPv4 packets (link type 101).
void write_capture(const std::filesystem::path& path, std::span<const std::uint8_t> datagram, std::uint16_t port) {
  std::vector<std::uint8_t> bytes;
  const auto little = [&](std::uint32_t value, int count) {
    for (int i = 0; i < count; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto big = [&](std::uint32_t value, int count) {
    for (int i = count - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  const auto udp_bytes = static_cast<std::uint32_t>(8 + datagram.size());
  little(0xA1B2C3D4u, 4);
  little(2, 2);
  little(4, 2);
  little(0, 4);
  little(0, 4);
  little(65'535, 4);
  little(101, 4);
  little(0, 4);  // seconds
  little(0, 4);  // microseconds
  little(20 + udp_bytes, 4);
  little(20 + udp_bytes, 4);
  big(0x4500, 2);
  big(20 + udp_bytes, 2);
  big(0, 4);
  big(0x4011, 2);  // time to live 64, UDP
  big(0, 2);       // checksum: tshark does not check it
  big(0x7F000001u, 4);
  big(0x7F000001u, 4);
  big(port, 2);
  big(port, 2);
  big(udp_bytes, 2);
  big(0, 2);
  bytes.insert(bytes.end(), datagram.begin(), datagram.end());
  std::ofstream file(path, std::ios::binary);
  file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

}  // namespace

std::optional<std::map<std::string, std::string>> dissect(std::span<const std::uint8_t> datagram, std::uint16_t port,
                                                          const std::vector<std::string>& fields) {
  if (std::system("command -v tshark > /dev/null 2>&1") != 0) {
    std::fprintf(stderr, "SKIPPED: tshark is not installed\n");
    return std::nullopt;
  }
  const TempFolder temp;
  const std::filesystem::path& folder = temp.path();
  write_capture(folder / "one.pcap", datagram, port);
  std::string command = "tshark -r " + (folder / "one.pcap").string() +
                        " --enable-heuristic acn -o acn.dmx_enable:TRUE -T fields -E separator='|'";
  for (const auto& field : fields) command += " -e " + field;
  command += " 2> " + (folder / "errors").string();
  std::string output;
  if (FILE* const pipe = popen(command.c_str(), "r"); pipe != nullptr) {
    std::array<char, 4096> buffer;
    for (std::size_t size; (size = fread(buffer.data(), 1, buffer.size(), pipe)) > 0;)
      output.append(buffer.data(), size);
    pclose(pipe);
  }

  std::map<std::string, std::string> values;
  std::istringstream line(output.substr(0, output.find('\n')));
  for (const auto& field : fields) std::getline(line, values[field], '|');
  return values;
}

}  // namespace footlight::testing
