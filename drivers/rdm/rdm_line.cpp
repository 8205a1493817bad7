#include "drivers/rdm/rdm_line.h"

#include <algorithm>

namespace footlight::drivers {
namespace {

constexpr int kMuteTries = 3;
// Of discover(). A responder costs some 100 requests at worst: two per bit of the UID, and the mute. Permanent noise
// that looks like several responders must end somewhere.
constexpr std::size_t kRequestsAlways = 1'000;
constexpr std::size_t kRequestsPerResponder = 200;

}  // namespace

Result<std::optional<RdmMessage>> RdmWire::transact(const RdmMessage& request) {
  FL_ASSIGN(const Octets bytes, exchange(build_rdm(request)));
  if (bytes.empty() || request.to.is_broadcast()) return std::nullopt;
  FL_ASSIGN(RdmMessage response, parse_rdm(bytes));
  // Anything else is the end of an earlier response, or from another controller.
  if (response.from != request.to || response.to != request.from || response.transaction != request.transaction ||
      response.command != response_to(request.command)) {
    return std::nullopt;
  }
  return response;
}

Result<Octets> RdmWire::query_branch(const Branch& branch) {
  RdmMessage request;
  request.to = kRdmEverybody;
  request.from = own_;
  request.transaction = ++transaction_;
  request.command = RdmCommand::kDiscovery;
  request.parameter = kRdmUniqueBranch;
  add_uid(request.data, branch.low);
  add_uid(request.data, branch.high);
  ++discovery_requests_;
  return exchange(build_rdm(request));
}

Result<std::optional<RdmFound>> RdmWire::mute(const RdmUid& uid) {
  RdmMessage request;
  request.to = uid;
  request.from = own_;
  request.command = RdmCommand::kDiscovery;
  request.parameter = kRdmMute;
  for (int i = 0; i < kMuteTries; ++i) {
    request.transaction = ++transaction_;
    ++discovery_requests_;
    const auto answer = transact(request);
    if (!answer && answer.error().code != ErrorCode::kProtocol) return tl::unexpected(answer.error());
    if (!answer || !*answer || (*answer)->parameter != kRdmMute) continue;
    const Octets& data = (*answer)->data;
    RdmFound found;
    found.uid = uid;
    const unsigned flags = data.size() >= 2 ? static_cast<unsigned>(data[0] << 8 | data[1]) : 0;
    found.is_proxy = (flags & 1u) != 0;
    found.has_sub_devices = (flags & 2u) != 0;
    found.is_boot_loader = (flags & 4u) != 0;
    found.is_proxied = (flags & 8u) != 0;
    if (data.size() >= 8) {
      std::uint64_t number = 0;
      for (std::size_t at = 2; at < 8; ++at) number = number << 8 | data[at];
      found.bound_to = RdmUid::of_number(number);
    }
    return found;
  }
  return std::nullopt;
}

Result<std::vector<RdmFound>> RdmWire::discover() {
  discovery_requests_ = 0;
  RdmMessage unmute;
  unmute.to = kRdmEverybody;
  unmute.from = own_;
  unmute.command = RdmCommand::kDiscovery;
  unmute.parameter = kRdmUnmute;
  for (int i = 0; i < 2; ++i) {  // no responder confirms it
    unmute.transaction = ++transaction_;
    ++discovery_requests_;
    FL_TRY(exchange(build_rdm(unmute)));
  }

  std::vector<RdmFound> found;
  const auto is_known = [&](const RdmUid& uid) {
    return std::any_of(found.begin(), found.end(), [&](const RdmFound& one) { return one.uid == uid; });
  };
  std::vector<Branch> branches = {{RdmUid{}, kRdmUidMax}};
  while (!branches.empty()) {
    if (discovery_requests_ > kRequestsAlways + kRequestsPerResponder * found.size()) {
      return fail(
          ErrorCode::kProtocol,
          "RDM discovery does not end: {} responders after {} requests; the line is disturbed, or a device on it "
          "violates the protocol: check cables and terminator, then take devices off one by one",
          found.size(), discovery_requests_);
    }
    if (stopped()) return fail(ErrorCode::kDisconnected, "RDM discovery was stopped");
    const Branch branch = branches.back();
    branches.pop_back();
    const std::uint64_t low = branch.low.number(), high = branch.high.number();
    FL_ASSIGN(const Octets answer, query_branch(branch));
    if (answer.empty()) continue;
    const auto uid = parse_discovery_answer(answer);
    bool took_one = false;
    if (uid && uid->number() >= low && uid->number() <= high && !is_known(*uid)) {
      FL_ASSIGN(auto one, mute(*uid));
      if (one) found.push_back(*one);
      took_one = one.has_value();
    } else if (low == high && !is_known(branch.low)) {
      // Only one responder fits here: its answer was damaged.
      FL_ASSIGN(auto one, mute(branch.low));
      if (one) found.push_back(*one);
      continue;
    }
    if (took_one) {
      branches.push_back(branch);  // those that this one has drowned out
    } else if (low != high) {
      // Several at once, or one that answers while muted: search each half alone.
      const std::uint64_t middle = low + (high - low) / 2;
      branches.push_back({RdmUid::of_number(middle + 1), branch.high});
      branches.push_back({branch.low, RdmUid::of_number(middle)});
    }
  }
  std::sort(found.begin(), found.end(), [](const RdmFound& a, const RdmFound& b) { return a.uid < b.uid; });
  return found;
}

}  // namespace footlight::drivers
