#include "tools/footlight/pictures/exr_file.h"

#include <algorithm>
#include <cstdint>
#include <exception>
#include <limits>
#include <numeric>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>

#include "sim/core/check.h"
#include "tools/footlight/pictures/picture_file.h"

namespace footlight::tools {
namespace {

// The library ignores errors when it closes a file of its own, so it writes to memory.
class MemoryStream final : public Imf::OStream {
 public:
  MemoryStream() : OStream("memory") {}
  void write(const char bytes[], int count) override {
    const std::size_t end = at_ + static_cast<std::size_t>(count);
    if (end > bytes_.size()) bytes_.resize(end);
    std::copy_n(reinterpret_cast<const std::byte*>(bytes), count, bytes_.begin() + static_cast<std::ptrdiff_t>(at_));
    at_ = end;
  }
  std::uint64_t tellp() override { return at_; }
  void seekp(std::uint64_t at) override { at_ = at; }

  [[nodiscard]] fixtures::Bytes take() { return std::move(bytes_); }

 private:
  fixtures::Bytes bytes_;
  std::size_t at_ = 0;
};

Imf::Header header_of(const render::RadianceImage& image, const ExrHeader& given) {
  Imf::Header header(image.width, image.height);
  header.compression() = Imf::ZIP_COMPRESSION;
  for (const char* channel : {"R", "G", "B"}) header.channels().insert(channel, Imf::Channel(Imf::FLOAT));
  Imf::addChromaticities(header, Imf::Chromaticities());  // the library's default is Rec. 709
  Imf::addWhiteLuminance(header, 1.0f);
  Imf::addExpTime(header, static_cast<float>(static_cast<double>(given.shutter_ns) * 1e-9));
  if (given.frame_ns > 0) {
    const DurationNs common = std::gcd(given.frame_ns, kNsPerS);
    const DurationNs frames = kNsPerS / common;
    const DurationNs seconds = given.frame_ns / common;
    if (seconds <= std::numeric_limits<int>::max()) {
      Imf::addFramesPerSecond(header, Imf::Rational(static_cast<int>(frames), static_cast<int>(seconds)));
    }
  }
  Imf::addComments(header,
                   "Scene-linear light before exposure and tone map, in cd/m^2: (1, 1, 1) is white of 1 cd/m^2.");
  header.insert("footlight/units", Imf::StringAttribute("cd/m^2"));
  header.insert("footlight/exposureEv", Imf::DoubleAttribute(given.exposure_ev));
  header.insert("footlight/timeS", Imf::DoubleAttribute(static_cast<double>(given.time_ns) * 1e-9));
  if (!given.settings.empty()) header.insert(kSettingsKeyword, Imf::StringAttribute(given.settings));
  return header;
}

}  // namespace

Result<fixtures::Bytes> exr_of(const render::RadianceImage& image, const ExrHeader& given) {
  const auto pixels = static_cast<std::size_t>(image.width) * static_cast<std::size_t>(image.height);
  FL_CHECK_EQ(image.rgb.size(), 3 * pixels);
  MemoryStream stream;
  try {
    Imf::OutputFile file(stream, header_of(image, given));
    Imf::FrameBuffer buffer;
    constexpr std::size_t kPixelBytes = 3 * sizeof(float);
    const std::size_t row_bytes = kPixelBytes * static_cast<std::size_t>(image.width);
    // The library takes a pointer that is not const and only reads.
    char* first = const_cast<char*>(reinterpret_cast<const char*>(image.rgb.data()));
    for (const auto& [name, offset] : {std::pair("R", 0), std::pair("G", 1), std::pair("B", 2)}) {
      buffer.insert(name, Imf::Slice(Imf::FLOAT, first + static_cast<std::size_t>(offset) * sizeof(float), kPixelBytes,
                                     row_bytes));
    }
    file.setFrameBuffer(buffer);
    file.writePixels(image.height);
  } catch (const std::exception& error) {
    return fail(ErrorCode::kIo, "OpenEXR: {}", error.what());
  }
  return stream.take();
}

Status check_exr(const std::string&) { return {}; }

Status write_exr(const std::string& path, const render::RadianceImage& image, const ExrHeader& header) {
  auto bytes = exr_of(image, header);
  if (!bytes) return fail(bytes.error().code, "{}: {}", path, bytes.error().message);
  return write_picture(path, *bytes);
}

}  // namespace footlight::tools
