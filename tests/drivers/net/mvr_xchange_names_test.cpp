#include "drivers/net/mvr_xchange_names.h"

#include <doctest/doctest.h>

#include <string>

namespace footlight::drivers {
namespace {

using Octets = std::vector<std::uint8_t>;

TEST_CASE("a name is read as it was written, and no prefix of it is read") {
  const DnsLabels labels = mvr_instance_name({"Desk 1", "Default"});
  CHECK(labels == DnsLabels{"Desk 1", "Default", "_mvrxchange", "_tcp", "local"});
  const Octets bytes = build_dns_name(labels);
  CHECK(parse_dns_name(bytes) == labels);
  for (std::size_t size = 0; size < bytes.size(); ++size) {
    CAPTURE(size);
    CHECK(!parse_dns_name(std::span(bytes).first(size)));
  }
  CHECK(!parse_dns_name(Octets{1, 'a', 0, 0}));  // bytes after the end
  CHECK(!parse_dns_name(Octets{0xC0, 12}));      // a pointer
  Octets longest(255, 1);                        // labels of one octet
  longest.back() = 0;
  CHECK(parse_dns_name(longest).has_value());
  longest.insert(longest.begin(), {1, 1});
  CHECK(!parse_dns_name(longest));                  // longer than a name may be
  CHECK(parse_dns_name(Octets{0}) == DnsLabels());  // the root
}

TEST_CASE("an SRV record holds port and host") {
  const Octets bytes = build_dns_srv({42424, {"desk", "local"}});
  const auto service = parse_dns_srv(bytes);
  REQUIRE(service.has_value());
  CHECK(service->port == 42424);
  CHECK(service->host == DnsLabels{"desk", "local"});
  for (std::size_t size = 0; size < bytes.size(); ++size) CHECK(!parse_dns_srv(std::span(bytes).first(size)));
}

TEST_CASE("a TXT record holds the name and the UUID, with keys in any case") {
  const MvrText written{"FOH \xC3\xA4", "4aa291a1-1a62-45fe-aabc-e90e5e2399a8"};
  const MvrText read = parse_mvr_text(build_mvr_text(written));
  CHECK(read.station_name == written.station_name);
  CHECK(read.station_uuid == written.station_uuid);
  const std::string text = std::string(
      "\x04"
      "a=bc"
      "\x00"
      "\x0D"
      "stationname=X"
      "\x0D"
      "StationName=Y",
      34);
  CHECK(parse_mvr_text(Octets(text.begin(), text.end())).station_name == "X");
  CHECK(parse_mvr_text(Octets{200, 'S'}).station_name.empty());
  CHECK(parse_mvr_text(build_mvr_text({std::string(400, 'x'), "u"})).station_uuid == "u");
}

TEST_CASE("the group is the label before the service, with or without a station before it") {
  const auto both = mvr_instance_of({"A", "B", "Rehearsal", "_MVRxchange", "_tcp", "local"});
  REQUIRE(both.has_value());
  CHECK(both->station == "A.B");
  CHECK(both->group == "Rehearsal");
  const auto only = mvr_instance_of({"Rehearsal", "_mvrxchange", "_tcp", "local"});
  REQUIRE(only.has_value());
  CHECK(only->station.empty());
  CHECK(only->group == "Rehearsal");
  CHECK(!mvr_instance_of({"_mvrxchange", "_tcp", "local"}));
  CHECK(!mvr_instance_of({"A", "_http", "_tcp", "local"}));
}

TEST_CASE("a name of people becomes one label") {
  CHECK(dns_label("Act 1. Revised") == "Act 1- Revised");
  CHECK(dns_label("") == "-");
  CHECK(dns_label(std::string(62, 'x') + "\xC3\xA4") == std::string(62, 'x'));  // no half character
}

}  // namespace
}  // namespace footlight::drivers
