#include <algorithm>
#include <array>
#include <optional>
#include <utility>

#include <pcap/pcap.h>

#include "drivers/capture/captures.h"
#include "drivers/capture/net_capture.h"

namespace footlight::drivers {
namespace {

constexpr std::int64_t kSecondsMax = std::int64_t{1} << 31;  // 2038; in nanoseconds still far from the limit of int64

std::optional<LinkLayer> link_of(int type) {
  switch (type) {
    case DLT_EN10MB: return LinkLayer::kEthernet;
    case DLT_LINUX_SLL: return LinkLayer::kLinuxCooked;
    case DLT_LINUX_SLL2: return LinkLayer::kLinuxCooked2;
    case DLT_RAW:
    case DLT_IPV4:
    case DLT_IPV6: return LinkLayer::kRawIp;
    case DLT_NULL:
    case DLT_LOOP: return LinkLayer::kLoopback;
    default: return std::nullopt;
  }
}

struct Closer {
  void operator()(pcap_t* pcap) const { pcap_close(pcap); }
};
using Pcap = std::unique_ptr<pcap_t, Closer>;

class PcapInput final : public LogInput {
 public:
  PcapInput(Pcap pcap, std::string path, LinkLayer link, const NetCaptureOptions& options)
      : pcap_(std::move(pcap)), path_(std::move(path)), link_(link), capture_(options) {
    held_ = read();
    if (held_) start_unix_ns_ = *time_of(*header_);
  }

  [[nodiscard]] LogFormat format() const override { return LogFormat::kPacketCapture; }
  [[nodiscard]] const std::string& path() const override { return path_; }
  [[nodiscard]] std::int64_t wall_start_unix_ns() const override { return start_unix_ns_; }
  [[nodiscard]] TimeNs end_ns() const override { return end_ns_; }
  [[nodiscard]] std::uint64_t damage_count() const override { return damage_.empty() ? 0 : 1; }
  [[nodiscard]] std::vector<std::string> notes() const override {
    std::vector<std::string> notes = capture_.notes();
    if (out_of_time_ > 0) notes.push_back(fmt::format("{} packets have no time from 1970 to 2038", out_of_time_));
    if (!damage_.empty()) notes.push_back("the capture ends early: " + damage_);
    return notes;
  }

  Result<bool> next(FrameView& frame) override {
    while (held_ || read()) {
      held_ = false;
      const TimeNs stamp_ns = *time_of(*header_) - start_unix_ns_;
      end_ns_ = std::max(end_ns_, stamp_ns);
      const std::span packet(bytes_, header_->caplen);
      if (capture_.take(stamp_ns, link_, packet, header_->caplen < header_->len, frame)) return true;
    }
    return false;
  }

 private:
  // The file is opened with nanosecond resolution, which libpcap stores in tv_usec.
  static std::optional<std::int64_t> time_of(const pcap_pkthdr& header) {
    const std::int64_t seconds = header.ts.tv_sec;
    if (seconds < 0 || seconds >= kSecondsMax || header.ts.tv_usec < 0 || header.ts.tv_usec >= kNsPerS) return {};
    return seconds * kNsPerS + header.ts.tv_usec;
  }

  // The next packet with a time; false at the end or if the file is damaged.
  bool read() {
    while (damage_.empty()) {
      const int got = pcap_next_ex(pcap_.get(), &header_, &bytes_);
      if (got == PCAP_ERROR_BREAK) return false;
      if (got != 1) {
        damage_ = pcap_geterr(pcap_.get());
        return false;
      }
      if (time_of(*header_)) return true;
      ++out_of_time_;
    }
    return false;
  }

  Pcap pcap_;
  std::string path_;
  LinkLayer link_;
  NetCapture capture_;
  pcap_pkthdr* header_ = nullptr;  // owned by libpcap; of the packet read last
  const u_char* bytes_ = nullptr;
  bool held_ = false;  // the packet was read but not used yet
  std::int64_t start_unix_ns_ = 0;
  TimeNs end_ns_ = 0;
  std::uint64_t out_of_time_ = 0;
  std::string damage_;
};

}  // namespace

Result<std::unique_ptr<LogInput>> open_pcap(const std::string& path, const CaptureOptions& options) {
  std::array<char, PCAP_ERRBUF_SIZE> error = {};
  Pcap pcap(pcap_open_offline_with_tstamp_precision(path.c_str(), PCAP_TSTAMP_PRECISION_NANO, error.data()));
  if (!pcap) return fail(ErrorCode::kBadInput, "{}: not a valid packet capture: {}", path, error.data());
  const int type = pcap_datalink(pcap.get());
  const auto link = link_of(type);
  if (!link) {
    const char* name = pcap_datalink_val_to_description_or_dlt(type);
    return fail(ErrorCode::kUnsupported,
                "{}: packets of '{}' are not read; expected a capture of Ethernet, of Linux's 'any', of a loopback or "
                "of raw IP",
                path, name);
  }
  return std::make_unique<PcapInput>(std::move(pcap), path, *link, options.net);
}

}  // namespace footlight::drivers
