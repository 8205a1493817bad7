#include "sim/core/endpoint.h"

#include <doctest/doctest.h>

namespace footlight {
namespace {

constexpr std::string_view kDevices[] = {"enttec-pro", "mock"};

Endpoint parsed(std::string_view text) {
  auto endpoint = parse_endpoint(text, kDevices);
  REQUIRE_MESSAGE(endpoint.has_value(), (endpoint ? "" : endpoint.error().message));
  return *endpoint;
}

std::string refusal(std::string_view text) {
  const auto endpoint = parse_endpoint(text, kDevices);
  REQUIRE_FALSE(endpoint.has_value());
  CHECK(endpoint.error().code == ErrorCode::kBadInput);
  return endpoint.error().message;
}

bool contains(const std::string& text, std::string_view part) { return text.find(part) != std::string::npos; }

TEST_CASE("a network endpoint has universes, address, port and interface in one text") {
  const auto plain = parsed("sacn:1-9");
  CHECK(plain.kind == EndpointKind::kNetwork);
  CHECK(plain.scheme == "sacn");
  CHECK(plain.text == "sacn:1-9");
  CHECK(plain.show_universes() == std::vector<Universe>{1, 2, 3, 4, 5, 6, 7, 8, 9});
  CHECK(plain.addresses.empty());
  CHECK(plain.interface_names.empty());
  CHECK(plain.udp_port == 0);

  const auto full = parsed("artnet:101-103,9=1-3,7@10.9.0.255:6455%eth0");
  CHECK(full.universes == std::vector<WireUniverse>{{101, 1}, {102, 2}, {103, 3}, {9, 7}});
  CHECK(full.addresses == std::vector<std::string>{"10.9.0.255"});
  CHECK(full.udp_port == 6455);
  CHECK(full.interface_names == std::vector<std::string>{"eth0"});
}

TEST_CASE("addresses and interfaces are lists without repeats, with one UDP port after the last address") {
  const auto wide = parsed("sacn:1,3=7,8@10.0.0.7,10.0.0.8:5569%eth0,eth1.20");
  CHECK(wide.universes == std::vector<WireUniverse>{{1, 7}, {3, 8}});
  CHECK(wide.addresses == std::vector<std::string>{"10.0.0.7", "10.0.0.8"});
  CHECK(wide.udp_port == 5569);
  CHECK(wide.interface_names == std::vector<std::string>{"eth0", "eth1.20"});
  CHECK(contains(refusal("sacn:1@10.0.0.7,"), "expected an IPv4 address after \"@\""));
  CHECK(contains(refusal("sacn:1@10.0.0.7:1,10.0.0.8:2"), "got \"10.0.0.7:1\""));
  CHECK(contains(refusal("sacn:1@10.0.0.7,10.0.0.7"), "address 10.0.0.7 is named twice"));
  CHECK(contains(refusal("sacn:1%eth0,"), "sacn:1-9%eth0,eth1"));
  CHECK(contains(refusal("sacn:1%eth0,eth0"), "interface eth0 is named twice"));
}

TEST_CASE("single universes keep the order in which they are written") {
  CHECK(parsed("sacn:7,1,3-4").show_universes() == std::vector<Universe>{7, 1, 3, 4});
}

TEST_CASE("a device endpoint has one universe, by default the first of the show") {
  CHECK(parsed("enttec-pro").universes == std::vector<WireUniverse>{{1, 1}});
  CHECK(parsed("enttec-pro").target.empty());
  CHECK(parsed("enttec-pro=4").universes == std::vector<WireUniverse>{{1, 4}});
  const auto serial = parsed("enttec-pro:EN123=3");
  CHECK(serial.kind == EndpointKind::kDevice);
  CHECK(serial.target == "EN123");
  CHECK(serial.universes == std::vector<WireUniverse>{{1, 3}});
  CHECK(parsed("enttec-pro:port-1-2.3").target == "port-1-2.3");
  CHECK(parsed("mock:enttec-pro").target == "enttec-pro");
}

TEST_CASE("several universes of a device use the first connectors unless the endpoint lists connectors") {
  const auto two = parsed("enttec-pro:EN123=3,4");
  CHECK(two.universes == std::vector<WireUniverse>{{1, 3}, {2, 4}});
  CHECK_FALSE(two.names_connectors);
  const auto second = parsed("enttec-pro:EN123/2=4");
  CHECK(second.target == "EN123");
  CHECK(second.universes == std::vector<WireUniverse>{{2, 4}});
  CHECK(second.names_connectors);
  CHECK(parsed("enttec-pro:EN123/2").universes == std::vector<WireUniverse>{{2, 1}});
  CHECK(parsed("enttec-pro/2,1=7-8").universes == std::vector<WireUniverse>{{2, 7}, {1, 8}});
  CHECK(parsed("mock:enttec-pro/stage/2=5").target == "enttec-pro/stage");
  CHECK(parsed("mock:enttec-pro/stage2=5").target == "enttec-pro/stage2");
}

TEST_CASE("a gpio endpoint that taps the tempo has lines and no universe") {
  const auto taps = parsed("gpio:gpiochip0/17=tempo");
  CHECK(taps.kind == EndpointKind::kGpio);
  CHECK(taps.target == "gpiochip0");
  CHECK(taps.lines == std::vector<std::string>{"17"});
  CHECK(taps.universes.empty());
  CHECK(contains(refusal("gpio:gpiochip0/17=Tempo"), "expected a universe"));
}

TEST_CASE("a gpio endpoint names a chip, lines and the first of their addresses") {
  const auto one = parsed("gpio:gpiochip0/17=1.25");
  CHECK(one.kind == EndpointKind::kGpio);
  CHECK(one.target == "gpiochip0");
  CHECK(one.lines == std::vector<std::string>{"17"});
  CHECK(one.first_address == 25);
  CHECK(one.show_universes() == std::vector<Universe>{1});
  const auto many = parsed("gpio:/dev/gpiochip3/4,16-18,BLACK-OUT=63999.508");
  CHECK(many.target == "/dev/gpiochip3");
  CHECK(many.lines == std::vector<std::string>{"4", "16", "17", "18", "BLACK-OUT"});
  CHECK(many.first_address == 508);
  for (const char* const bad :
       {"gpio", "gpio:", "gpio:gpiochip0", "gpio:gpiochip0/17", "gpio:17=1.25", "gpio:/17=1.1", "gpio:gpiochip0/=1.25",
        "gpio:gpiochip0/17=1", "gpio:gpiochip0/17=0.1", "gpio:gpiochip0/17=1.0", "gpio:gpiochip0/17=1.513",
        "gpio:gpiochip0/17=1.2.3", "gpio:gpiochip0/17,=1.1", "gpio:gpiochip0/9-7=1.1", "gpio:gpiochip0/7,7=1.1",
        "gpio:gpiochip0/0-1=1.512", "gpio:gpiochip0/0-99999999=1.1"}) {
    CAPTURE(bad);
    CHECK(refusal(bad).find(bad) == 0);
  }
  CHECK(contains(refusal("gpio:gpiochip0/6,5-7=1.1"), "line 6 is named twice"));
}

TEST_CASE("the name of a log may hold every character that endpoints use elsewhere") {
  for (const std::string file : {"show.dmxlog", "/tmp/a b=1-9@10.0.0.7%eth0:x.dmxlog", "=", "C:\\x"}) {
    const auto log = parsed("log:" + file);
    CHECK(log.kind == EndpointKind::kFile);
    CHECK(log.target == file);
    CHECK(log.universes.empty());
  }
}

TEST_CASE("a vrsl endpoint names universes, a target and options") {
  const auto plain = parsed("vrsl:1-3=11-13@frame_%05d.png");
  CHECK(plain.kind == EndpointKind::kPicture);
  CHECK(plain.target == "frame_%05d.png");
  CHECK(plain.universes == std::vector<WireUniverse>{{1, 11}, {2, 12}, {3, 13}});
  CHECK(plain.options.empty());
  const auto full = parsed("vrsl:9,1@/dev/video3?layout=vertical-left&fps=60");
  CHECK(full.target == "/dev/video3");
  CHECK(full.show_universes() == std::vector<Universe>{9, 1});
  CHECK(full.options == std::vector<EndpointOption>{{"layout", "vertical-left"}, {"fps", "60"}});
  // The last "?" begins the options, and an empty one ends a URL.
  const auto url = parsed("vrsl:1@rtmp://user@host/live?key=1&x=2?");
  CHECK(url.target == "rtmp://user@host/live?key=1&x=2");
  CHECK(url.options.empty());
  for (const char* const bad :
       {"vrsl", "vrsl:", "vrsl:1-9", "vrsl:@a.png", "vrsl:1-9@", "vrsl:1-9@?fps=1", "vrsl:0@a.png", "vrsl:1-10@a.png",
        "vrsl:1-2=5@a.png", "vrsl:1@a.png?fps", "vrsl:1@a.png?=1", "vrsl:1@a.png?fps=", "vrsl:1@a.png?fps=1&&x=2",
        "vrsl:1@a.png?fps=1&fps=2"}) {
    CAPTURE(bad);
    CHECK(refusal(bad).find(bad) == 0);
  }
  CHECK(contains(refusal("vrsl:10@a.png"), "expected 1 to 9"));
}

TEST_CASE("sound is a map, or a file or device with the place of its five slots") {
  const auto map = parsed("audio:/a b/map.toml");
  CHECK(map.kind == EndpointKind::kFile);
  CHECK(map.target == "/a b/map.toml");
  CHECK(map.universes.empty());
  const auto file = parsed("audio:/tmp/a=b:c.flac=63999.508");
  CHECK(file.target == "/tmp/a=b:c.flac");
  CHECK(file.show_universes() == std::vector<Universe>{63'999});
  CHECK(file.first_address == 508);
  CHECK_FALSE(is_sound_device(file.target));
  CHECK(is_sound_device(parsed("audio:alsa:hw:1,0=1.1").target));
  CHECK(is_sound_device(parsed("audio:mock=1.1").target));
  CHECK_FALSE(is_sound_device("mocks"));
  CHECK(parsed("audio:alsa=2.7").target == "alsa");
  for (const char* const bad : {"audio", "audio:", "audio:track.flac", "audio:=1.1", "audio:track.flac=1",
                                "audio:track.flac=0.1", "audio:track.flac=1.0", "audio:track.flac=1.509"}) {
    CAPTURE(bad);
    CHECK(refusal(bad).find(bad) == 0);
  }
}

TEST_CASE("controls are a map, a UDP port for OSC, or a MIDI device with the place of its controllers") {
  const auto osc = parsed("osc:8000@10.0.0.7");
  CHECK(osc.kind == EndpointKind::kControl);
  CHECK(osc.udp_port == 8000);
  CHECK(osc.addresses == std::vector<std::string>{"10.0.0.7"});
  CHECK(osc.universes.empty());
  CHECK(parsed("osc:a@b/map.toml").target == "a@b/map.toml");
  const auto midi = parsed("midi:nano KONTROL=2=3.101");
  CHECK(midi.kind == EndpointKind::kControl);
  CHECK(midi.target == "nano KONTROL=2");
  CHECK(midi.show_universes() == std::vector<Universe>{3});
  CHECK(midi.first_address == 101);
  CHECK(parsed("midi:map.toml").target == "map.toml");
  for (const char* const bad : {"osc", "osc:", "osc:0", "osc:65536", "osc:8000@", "osc:8000@x", "osc:8000=1", "osc:x",
                                "midi", "midi:", "midi:nano", "midi:=1.1", "midi:nano=1", "midi:nano=0.1"}) {
    CAPTURE(bad);
    CHECK(refusal(bad).find(bad) == 0);
  }
}

TEST_CASE("universe 0, universe 64000 and Art-Net universe 32769 are refused, and the highest ones are not") {
  CHECK(contains(refusal("sacn:0-9"), "universe 0 does not exist; expected 1 to 63999"));
  CHECK(contains(refusal("sacn:64000"), "universe 64000 does not exist"));
  CHECK(contains(refusal("sacn:1=64000"), "universe 64000 does not exist"));
  CHECK(contains(refusal("artnet:32769"), "expected 1 to 32768"));
  CHECK(contains(refusal("enttec-pro=0"), "1 to 63999"));
  CHECK(contains(refusal("enttec-pro=64000"), "1 to 63999"));
  CHECK(parsed("sacn:63999").show_universes() == std::vector<Universe>{63'999});
  CHECK(parsed("artnet:32768=63999").universes == std::vector<WireUniverse>{{32'768, 63'999}});
}

TEST_CASE("priorities of addresses are read as ranges, and addresses that are not listed have 0") {
  const auto read = parse_address_priorities("1-100:150, 512:200 ,101:0");
  REQUIRE(read.has_value());
  REQUIRE(read->size() == 512);
  CHECK((*read)[0] == 150);
  CHECK((*read)[99] == 150);
  CHECK((*read)[100] == 0);
  CHECK((*read)[511] == 200);
  for (const char* const wrong : {"", "1-100", "1-100:201", "0:5", "513:5", "9-3:5", "1:2:3", "a:1", "1-:4", ","}) {
    CAPTURE(wrong);
    const auto refused = parse_address_priorities(wrong);
    REQUIRE_FALSE(refused.has_value());
    CHECK(contains(refused.error().message, "as in 1-100:150"));
  }
  CHECK(contains(parse_address_priorities("1-3:1,3-4:2").error().message, "address 3 is named twice"));
}

TEST_CASE("the error for an unknown scheme lists the known schemes") {
  for (const char* text : {"scan:1-9", "", "1-9", "SACN:1", ":1-9", "=3"}) {
    const auto message = refusal(text);
    CHECK(contains(message, "unknown scheme"));
    CHECK(contains(message, "sacn, artnet, vrsl-osc, enttec-pro, mock, gpio, vrsl, log"));
  }
}

TEST_CASE("every error starts with the endpoint and shows a correct example") {
  for (const char* text : {"sacn",
                           "sacn:",
                           "sacn:@10.0.0.7",
                           "sacn:x",
                           "sacn:1-",
                           "sacn:-1",
                           "sacn:1,,2",
                           "sacn: 1",
                           "sacn:1-9@",
                           "sacn:+1",
                           "sacn:1-9@10.0.0",
                           "sacn:1-9@10.0.0.256",
                           "sacn:1-9@host",
                           "sacn:1-9@::1",
                           "sacn:1-9@10.0.0.7:",
                           "sacn:1-9@10.0.0.7:0",
                           "sacn:1-9@10.0.0.7:65536",
                           "sacn:1-9@10.0.0.7.1",
                           "sacn:1-9%",
                           "sacn:1-9%eth0@10.0.0.7",
                           "artnet:1-9=",
                           "log:",
                           "log",
                           "log=x",
                           "enttec-pro=",
                           "enttec-pro:EN1=1-",
                           "enttec-pro:EN1=3,3",
                           "enttec-pro:EN1/0=3",
                           "enttec-pro:EN1/65",
                           "enttec-pro:EN1/1,2=3",
                           "enttec-pro:EN1/=3",
                           "enttec-pro:EN1=x",
                           "sacn:99999999999",
                           "sacn:1-9=1-8"}) {
    CAPTURE(text);
    const auto message = refusal(text);
    CHECK(message.rfind(text, 0) == 0);
    CHECK(contains(message, "as in"));
  }
}

TEST_CASE("a reversed range, a repeated universe and unequal sides have different errors") {
  CHECK(contains(refusal("sacn:9-1"), "write 1-9"));
  CHECK(contains(refusal("sacn:1-9,5"), "universe 5 is named twice"));
  CHECK(contains(refusal("sacn:1-2=5,5"), "universe 5 is named twice"));
  CHECK(contains(refusal("sacn:1-9=1-8"), "names 9 universes on the wire and 8 in the show"));
}

}  // namespace
}  // namespace footlight
