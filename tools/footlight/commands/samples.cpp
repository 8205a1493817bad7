// footlight samples: writes a folder with one file of each kind, to try the other commands with.
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "drivers/net/sacn_packet.h"
#include "fixtures/builtin/builtin.h"
#include "fixtures/files/export/gdtf.h"
#include "fixtures/files/export/mvr.h"
#include "fixtures/files/export/write_file.h"
#include "fixtures/files/export/zip_writer.h"
#include "fixtures/files/import/import_rig.h"
#include "sim/dmx_log/dmx_log.h"
#include "sim/dmx_log/ola_show.h"
#include "tools/demo_show/demo_assets.h"
#include "tools/footlight/command.h"
#include "tools/footlight/sample_rigs.h"

namespace footlight::tools {
namespace {

namespace fs = std::filesystem;

constexpr DurationNs kPartNs = 5 * kNsPerS;                       // length of foh.show, sent.dmxlog and capture.pcapng
constexpr std::int64_t kWallStartNs = 1'700'000'000LL * kNsPerS;  // a fixed date, so that the files are always the same

struct Sample {
  const char* name;
  const char* what;
  Status (*write)(const std::string& path);
};

Status write_text(const std::string& path, std::span<const std::uint8_t> bytes) {
  return fixtures::write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

// ---- Rigs and fixtures ---------------------------------------------------------------------------------------------

Status write_rig(const std::string& path) {
  return fixtures::write_file(path, fixtures::builtin_text("demo_rig.toml"));
}

Status write_mvr(const std::string& path) {
  FL_ASSIGN(const fixtures::ImportedRig rig,
            fixtures::import_rig((fs::path(path).parent_path() / "rig.toml").string()));
  FL_ASSIGN(const fixtures::ExportReport report, fixtures::export_mvr(rig, path));
  return {};
}

Status write_gdtf(const std::string& path) {
  const fixtures::FixtureType* type = fixtures::find_builtin_type("generic/profile");
  FL_ASSIGN(const fixtures::Bytes bytes, fixtures::gdtf_archive(*type, fixtures::gdtf_of(*type)));
  return fixtures::write_file(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

Status write_qxf(const std::string& path) {
  return fixtures::write_file(path, R"(<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE FixtureDefinition>
<FixtureDefinition xmlns="http://www.qlcplus.org/FixtureDefinition">
 <Creator>
  <Name>Footlight</Name>
  <Version>4.12.6</Version>
  <Author>Footlight</Author>
 </Creator>
 <Manufacturer>Footlight</Manufacturer>
 <Model>Sample head</Model>
 <Type>Moving Head</Type>
 <Channel Name="Pan" Preset="PositionPan"/>
 <Channel Name="Tilt" Preset="PositionTilt"/>
 <Channel Name="Dimmer" Preset="IntensityMasterDimmer"/>
 <Channel Name="Red" Preset="IntensityRed"/>
 <Channel Name="Green" Preset="IntensityGreen"/>
 <Channel Name="Blue" Preset="IntensityBlue"/>
 <Channel Name="Zoom" Preset="BeamZoomSmallBig"/>
 <Mode Name="Standard">
  <Channel Number="0">Pan</Channel>
  <Channel Number="1">Tilt</Channel>
  <Channel Number="2">Dimmer</Channel>
  <Channel Number="3">Red</Channel>
  <Channel Number="4">Green</Channel>
  <Channel Number="5">Blue</Channel>
  <Channel Number="6">Zoom</Channel>
  <Head>
   <Channel>3</Channel>
   <Channel>4</Channel>
   <Channel>5</Channel>
  </Head>
 </Mode>
 <Physical>
  <Bulb Type="LED" Lumens="8000" ColourTemperature="6500"/>
  <Dimensions Weight="12" Width="320" Height="450" Depth="240"/>
  <Lens Name="PC" DegreesMin="8" DegreesMax="40"/>
  <Focus Type="Head" PanMax="540" TiltMax="270"/>
  <Technical PowerConsumption="250" DmxConnector="5-pin"/>
 </Physical>
</FixtureDefinition>
)");
}

Status write_qxw(const std::string& path) {
  return fixtures::write_file(path, R"(<?xml version="1.0" encoding="UTF-8"?>
<!DOCTYPE Workspace>
<Workspace xmlns="http://www.qlcplus.org/Workspace" CurrentWindow="FixtureManager">
 <Creator>
  <Name>Footlight</Name>
  <Version>4.12.6</Version>
  <Author>Footlight</Author>
 </Creator>
 <Engine>
  <Fixture>
   <Manufacturer>Generic</Manufacturer>
   <Model>Generic</Model>
   <Mode>Generic</Mode>
   <ID>0</ID>
   <Name>Dimmers</Name>
   <Universe>0</Universe>
   <Address>0</Address>
   <Channels>6</Channels>
  </Fixture>
 </Engine>
</Workspace>
)");
}

// ---- Shows and logs ------------------------------------------------------------------------------------------------

Status write_show_file(const std::string& path) {
  return fixtures::write_file(path,
                              R"(# For 'footlight run show.toml'. Every key is in docs/formats/show_file.md.
universes = 2

[merge]
ltp_rig = "rig.toml"           # LTP for pan, tilt and gobos of this rig; HTP for dimmers and colours

[[in]]
endpoint = "sacn:1-2"

[[out]]
endpoint = "mock:enttec-pro"   # a model of a dongle; "enttec-pro" is the one that is plugged in

[[out]]
endpoint = "mock:enttec-pro/SECOND=2"
)");
}

Result<LogReader> open_show() {
  const auto bytes = demo::demo_log_bytes();
  return LogReader::open_bytes({bytes.begin(), bytes.end()}, "the built-in show");
}

Status write_log(const std::string& path) { return write_text(path, demo::demo_log_bytes()); }

// Calls `take(const LogFrame&)` for each frame of the first part of the show.
template <class Take>
Status for_part(Take take) {
  FL_ASSIGN(LogReader show, open_show());
  LogFrame frame;
  while (true) {
    FL_ASSIGN(const bool any, show.next(frame));
    if (!any || frame.time_ns >= kPartNs) return {};
    FL_TRY(take(frame));
  }
}

Status write_ola_show(const std::string& path) {
  FL_ASSIGN(OlaShowWriter writer, OlaShowWriter::create(path));
  FL_TRY(for_part([&](const LogFrame& frame) { return writer.append(frame.time_ns, frame.universe, frame.slots()); }));
  return writer.close(kPartNs);
}

Status write_sent(const std::string& path) {
  LogWriterOptions options;
  options.wall_start_unix_ns = kWallStartNs;
  options.universes = {1, 2};
  FL_ASSIGN(LogWriter writer, LogWriter::create(path, options));
  FL_TRY(for_part([&](const LogFrame& frame) {
    FrameView view;
    view.universe = frame.universe;
    view.stamp_ns = frame.time_ns;
    view.sequence = frame.sequence;
    view.slots = frame.slots();
    return writer.append(view);
  }));
  return writer.close(kPartNs);
}

// ---- Captures ------------------------------------------------------------------------------------------------------

using Octets = std::vector<std::uint8_t>;

void put_le(Octets& to, std::uint64_t value, int octets) {
  for (int i = 0; i < octets; ++i) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}
void put_be(Octets& to, std::uint64_t value, int octets) {
  for (int i = octets; i-- > 0;) to.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
}

// A block of a pcapng file (draft-ietf-opsawg-pcapng): its length is written before and after the body.
void put_block(Octets& to, std::uint32_t type, Octets body) {
  while (body.size() % 4 != 0) body.push_back(0);
  put_le(to, type, 4);
  put_le(to, 12 + body.size(), 4);
  to.insert(to.end(), body.begin(), body.end());
  put_le(to, 12 + body.size(), 4);
}

// One sACN packet on Ethernet, with MAC, IPv4 and UDP headers. Receivers do not verify a checksum of 0.
Octets sacn_on_ethernet(const LogFrame& frame) {
  drivers::SacnData data;
  data.cid.fill(0x46);
  data.source_name = "Footlight sample";
  data.universe = frame.universe;
  data.sequence = static_cast<std::uint8_t>(frame.sequence);
  data.slots = frame.slots();
  std::array<std::uint8_t, drivers::kSacnDataBytesMax> payload;
  const std::size_t size = drivers::build_sacn_data(data, payload);
  Octets packet = {0x01, 0x00, 0x5E, 0x7F, 0x00, static_cast<std::uint8_t>(frame.universe), 0x02, 0x00, 0x00,
                   0x00, 0x00, 0x07, 0x08, 0x00};
  put_be(packet, 0x4500, 2);
  put_be(packet, 20 + 8 + size, 2);
  put_be(packet, 0x00004000, 4);
  put_be(packet, 0x40110000, 4);
  put_be(packet, 0x0A000007, 4);
  put_be(packet, drivers::sacn_group_ipv4(frame.universe), 4);
  put_be(packet, 40'000, 2);
  put_be(packet, 5'568, 2);
  put_be(packet, 8 + size, 2);
  put_be(packet, 0, 2);
  packet.insert(packet.end(), payload.begin(), payload.begin() + static_cast<std::ptrdiff_t>(size));
  return packet;
}

Status write_capture(const std::string& path) {
  Octets file;
  Octets section;
  put_le(section, 0x1A2B3C4D, 4);
  put_le(section, 1, 2);
  put_le(section, 0, 2);
  put_le(section, ~std::uint64_t{0}, 8);
  put_block(file, 0x0A0D0D0A, section);
  Octets interface;
  put_le(interface, 1, 2);  // Ethernet
  put_le(interface, 0, 2);
  put_le(interface, 65'535, 4);
  put_le(interface, 9, 2);  // if_tsresol: 10^-9 s
  put_le(interface, 1, 2);
  put_le(interface, 9, 4);
  put_le(interface, 0, 4);
  put_block(file, 1, interface);
  FL_TRY(for_part([&](const LogFrame& frame) -> Status {
    const Octets packet = sacn_on_ethernet(frame);
    const auto time_ns = static_cast<std::uint64_t>(kWallStartNs + frame.time_ns);
    Octets body;
    put_le(body, 0, 4);
    put_le(body, time_ns >> 32, 4);
    put_le(body, time_ns & 0xFFFF'FFFF, 4);
    put_le(body, packet.size(), 4);
    put_le(body, packet.size(), 4);
    body.insert(body.end(), packet.begin(), packet.end());
    put_block(file, 6, body);
    return {};
  }));
  return write_text(path, file);
}

// Four frames of 24 slots, sampled at 1 MHz, in sigrok's format.
Status write_line(const std::string& path) {
  fixtures::Bytes samples;
  const auto level = [&](bool mark, std::size_t us) { samples.insert(samples.end(), us, std::byte{mark}); };
  level(true, 200);
  for (unsigned frame = 0; frame < 4; ++frame) {
    level(false, 176);
    level(true, 12);
    for (unsigned slot = 0; slot <= 24; ++slot) {
      const unsigned value = slot == 0 ? 0 : 10 * slot + frame;
      level(false, 4);
      for (unsigned bit = 0; bit < 8; ++bit) level((value >> bit & 1) != 0, 4);
      level(true, 8);
    }
    level(true, 1'000);
  }
  level(true, 1'000);
  const auto bytes_of = [](std::string_view text) {
    const auto bytes = std::as_bytes(std::span(text));
    return fixtures::Bytes(bytes.begin(), bytes.end());
  };
  return fixtures::write_zip(path, {{"version", bytes_of("2")},
                                    {"metadata", bytes_of("[global]\nsigrok version=0.5.2\n\n[device 1]\n"
                                                          "capturefile=logic-1\ntotal probes=1\nsamplerate=1 MHz\n"
                                                          "total analog=0\nprobe1=DMX+\nunitsize=1\n")},
                                    {"logic-1-1", samples}});
}

// ---- The command ---------------------------------------------------------------------------------------------------

// In this order: the MVR is made from the rig file.
constexpr Sample kSamples[] = {
    {"rig.toml", "the demo rig: 24 fixtures, two universes", write_rig},
    {"show.mvr", "the same rig as MVR", write_mvr},
    {"chapel.toml", "three panes of stained glass in the sun", write_chapel_rig},
    {"glass.png", "the image of these panes", write_glass_image},
    {"wall.toml", "LED walls with an image and with pixels from DMX", write_wall_rig},
    {"wall.png", "the image of the wall", write_wall_image},
    {"show.qxw", "a QLC+ workspace with six dimmers", write_qxw},
    {"head.gdtf", "the generic profile as GDTF", write_gdtf},
    {"head.qxf", "a moving head as a QLC+ definition", write_qxf},
    {"show.toml", "a show file: sACN to a model of a dongle", write_show_file},
    {"show.dmxlog", "the demo show: a minute of two universes", write_log},
    {"foh.show", "its first five seconds as an OLA show file", write_ola_show},
    {"sent.dmxlog", "the same five seconds as a log", write_sent},
    {"capture.pcapng", "the same as sACN packets on a network", write_capture},
    {"desk.sr", "a DMX line from a logic analyser", write_line},
};

Result<int> write_samples(const std::string& folder) {
  if (folder.empty()) {
    return fail(ErrorCode::kBadInput, "samples: expected a folder, for example 'footlight samples samples'");
  }
  std::error_code trouble;
  for (const Sample& sample : kSamples) {
    const fs::path path = fs::path(folder) / sample.name;
    if (fs::symlink_status(path, trouble).type() == fs::file_type::not_found) continue;
    return fail(ErrorCode::kBadInput, "{}: exists, and nothing was written; name another folder", path.string());
  }
  fs::create_directories(folder, trouble);
  if (trouble) {
    return fail(trouble == std::errc::permission_denied ? ErrorCode::kPermission : ErrorCode::kIo,
                "{}: cannot be created: {}; name a folder with write permission", folder, trouble.message());
  }
  for (const Sample& sample : kSamples) {
    const std::string path = (fs::path(folder) / sample.name).string();
    FL_TRY(sample.write(path));
    fmt::print("{:<24} {}\n", path, sample.what);
  }
  return kExitOk;
}

void add(Arguments& arguments) {
  auto folder = std::make_shared<std::string>();
  arguments.word("FOLDER", *folder, "the folder to write to; created if it does not exist");
  arguments.job([folder]() -> Result<int> { return write_samples(*folder); });
}

}  // namespace

extern const CommandInfo samples_command{
    .name = "samples",
    .help = "Write a rig, a show, a log, fixtures and captures, to try the other commands with",
    .examples =
        "  footlight samples samples\n"
        "  cd samples && footlight render rig.toml --log show.dmxlog --at 12.5s -o frame.png\n"
        "All files are made by this program and are the same each time. No existing file is replaced.",
    .add = add,
};

}  // namespace footlight::tools
