// Arbitrary bytes as a sigrok capture. The first byte selects the use of the rest: as the zip (0), or as its metadata
// (1), so that mutations reach the text past the zip's checksums.
#include <vector>

#include "drivers/capture/sigrok_file.h"
#include "tests/drivers/capture/zip_writer.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

namespace {

void check(const SigrokMetadata& metadata) {
  require(!metadata.capture_file.empty());
  require(metadata.sample_rate_hz >= 500'000 && metadata.sample_rate_hz <= 1'000'000'000);
  require(metadata.probe_count >= 1 && metadata.probe_count <= 64);
  require(metadata.unit_size * 8 >= static_cast<std::size_t>(metadata.probe_count) && metadata.unit_size <= 8);
  int before = 0;
  for (const SigrokProbe& probe : metadata.probes) {
    require(probe.number > before && probe.number <= metadata.probe_count);
    before = probe.number;
  }
}

}  // namespace

void footlight::testing::add_seeds(Seeds& seeds) {
  const std::string metadata =
      "[global]\nsigrok version=0.5.2\n\n[device 1]\ncapturefile=logic-1\ntotal probes=8\nsamplerate=1 MHz\n"
      "total analog=0\nprobe1=DMX+\nprobe2=DMX-\nunitsize=1\n";
  seeds.add("metadata", "\x01" + metadata);
  const std::vector<std::uint8_t> samples(300, 1);
  for (const bool many : {false, true}) {
    ZipWriter zip;
    zip.add("version", "2");
    zip.add("metadata", metadata);
    if (many) zip.add("logic-1-1", samples);
    zip.add(many ? "logic-1-2" : "logic-1", samples);
    std::vector<std::uint8_t> bytes = zip.finish();
    bytes.insert(bytes.begin(), 0);
    seeds.add(many ? "many" : "one", bytes);
  }
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  if (data[0] % 2 == 1) {
    const auto metadata =
        parse_sigrok_metadata(std::string_view(reinterpret_cast<const char*>(data + 1), size - 1), "fuzz.sr");
    if (metadata) check(*metadata);
    return 0;
  }
  auto file = SigrokFile::open_bytes({data + 1, size - 1}, "fuzz.sr");
  if (!file) {
    require(!file.error().message.empty());
    return 0;
  }
  check(file->metadata());
  std::uint64_t sums[2] = {};
  for (std::uint64_t& sum : sums) {
    for (int pieces = 0; pieces < 64; ++pieces) {
      const auto samples = file->read();
      if (samples.empty()) break;
      require(samples.size() % file->metadata().unit_size == 0);
      for (const std::uint8_t byte : samples) sum = sum * 31 + byte;
    }
    file->rewind();
  }
  require(sums[0] == sums[1]);
  return 0;
}
