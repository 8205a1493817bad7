// Arbitrary bytes from another station: to one that answers, to one that asks, and as records of DNS.
//
// The first octet selects the side and how the rest is cut. What is read can be written, and read again as the same.
#include <string>

#include "drivers/net/mvr_xchange_message.h"
#include "drivers/net/mvr_xchange_names.h"
#include "drivers/net/mvr_xchange_station.h"
#include "tests/fuzz/fuzz.h"

using namespace footlight;
using namespace footlight::drivers;
using footlight::testing::require;

namespace {

MvrMessage request() {
  MvrMessage message;
  message.type = MvrMessageType::kRequest;
  return message;
}

MvrStation station() {
  MvrStation station("Fuzz", "00000000-0000-4000-8000-000000000000");
  MvrCommit commit;
  commit.file_uuid = "1";
  station.offer(commit, std::make_shared<std::vector<std::uint8_t>>(100));
  return station;
}

class Counter final : public MvrFileSink {
 public:
  Status write(std::span<const std::uint8_t> part, std::uint64_t total_bytes) override {
    bytes += part.size();
    require(bytes <= total_bytes);
    return {};
  }
  std::uint64_t bytes = 0;
};

template <class Side>
void feed(Side& side, std::span<const std::uint8_t> bytes, std::size_t cut) {
  for (; !bytes.empty(); bytes = bytes.subspan(std::min(cut, bytes.size()))) {
    const Status received = side.receive(bytes.first(std::min(cut, bytes.size())));
    if (!received) {
      require(!received.error().message.empty());
      return;
    }
  }
}

void read_records(std::span<const std::uint8_t> bytes) {
  if (const auto name = parse_dns_name(bytes)) {
    require(parse_dns_name(build_dns_name(*name)) == name);
    (void)mvr_instance_of(*name);
  }
  if (const auto service = parse_dns_srv(bytes)) {
    require(parse_dns_srv(build_dns_srv(*service))->host == service->host);
  }
  const MvrText text = parse_mvr_text(bytes);
  require(text.station_name.size() < 256);
}

void read_message(std::span<const std::uint8_t> bytes) {
  const auto message = parse_mvr_message({reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  if (!message) return;
  const auto again = parse_mvr_message(build_mvr_message(*message));
  require(again && again->type == message->type && again->commits == message->commits);
}

}  // namespace

void footlight::testing::add_seeds(Seeds& seeds) {
  MvrStation desk = station();
  const auto add = [&](const char* name, const MvrMessage& message) {
    seeds.add(name, std::string(1, '\x10') + build_mvr_json(build_mvr_message(message)));
    seeds.add(std::string("text-") + name, std::string(1, '\x03') + build_mvr_message(message));
  };
  add("join", desk.join());
  add("leave", desk.leave());
  add("commit", desk.commit());
  add("request", request());
  MvrMessage answer = desk.join();
  answer.type = MvrMessageType::kJoinAnswer;
  add("join-answer", answer);
  const auto head = build_mvr_header({0, 1, MvrPayload::kFile, 4});
  seeds.add("file", std::string(1, '\x11') + std::string(head.begin(), head.end()) + "PK\3\4");
  const auto service = build_dns_srv({42424, {"desk", "local"}});
  seeds.add("srv", std::string(1, '\x02') + std::string(service.begin(), service.end()));
  const auto text = build_mvr_text({"Desk", "1"});
  seeds.add("txt", std::string(1, '\x02') + std::string(text.begin(), text.end()));
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  const std::span<const std::uint8_t> bytes(data + 1, size - 1);
  const std::size_t cut = 1 + (data[0] >> 2);
  switch (data[0] & 3u) {
    case 0: {
      MvrStation desk = station();
      MvrAnswering answering(desk);
      feed(answering, bytes, cut);
      while (!answering.to_send().empty()) {
        if (!answering.sent(answering.to_send().size())) break;
      }
      break;
    }
    case 1: {
      Counter sink;
      MvrAsking asking(request(), &sink);
      feed(asking, bytes, cut);
      require(asking.file_bytes() == sink.bytes);
      break;
    }
    case 2: read_records(bytes); break;
    default: read_message(bytes); break;
  }
  return 0;
}
