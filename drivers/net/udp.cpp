#include "drivers/net/udp.h"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <utility>

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/filter.h>
#include <linux/if_packet.h>
#include <linux/netlink.h>
#include <linux/rtnetlink.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

namespace footlight::drivers {
namespace {

// A larger age comes from a stepped wall clock, not from a full buffer.
constexpr DurationNs kAgeMaxNs = 10 * kNsPerS;

sockaddr_in address_of(std::uint32_t ipv4, std::uint16_t udp_port) {
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(ipv4);
  address.sin_port = htons(udp_port);
  return address;
}

bool set_option(const Fd& socket, int level, int option, int value) {
  return setsockopt(socket.get(), level, option, &value, sizeof value) == 0;
}

TimeNs wall_clock_ns() {
  timespec now = {};
  clock_gettime(CLOCK_REALTIME, &now);
  return now.tv_sec * kNsPerS + now.tv_nsec;
}

}  // namespace

Result<std::uint32_t> parse_ipv4(std::string_view port_name, const std::string& text) {
  in_addr address = {};
  if (inet_pton(AF_INET, text.c_str(), &address) != 1) {
    return fail(ErrorCode::kBadInput, "{}: expected an IPv4 address such as 10.0.0.5, got \"{}\"", port_name, text);
  }
  return ntohl(address.s_addr);
}

Result<std::vector<std::uint32_t>> parse_ipv4_list(std::string_view port_name, const std::vector<std::string>& texts) {
  std::vector<std::uint32_t> addresses;
  for (const auto& text : texts) {
    FL_ASSIGN(const std::uint32_t ipv4, parse_ipv4(port_name, text));
    addresses.push_back(ipv4);
  }
  return addresses;
}

std::string text_of_ipv4(std::uint32_t ipv4) {
  return fmt::format("{}.{}.{}.{}", ipv4 >> 24, ipv4 >> 16 & 0xFF, ipv4 >> 8 & 0xFF, ipv4 & 0xFF);
}

std::vector<Interface> list_interfaces() {
  std::vector<Interface> interfaces;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return interfaces;
  for (const ifaddrs* entry = list; entry != nullptr; entry = entry->ifa_next) {
    if (entry->ifa_addr == nullptr || entry->ifa_addr->sa_family != AF_INET) continue;
    Interface found;
    found.name = entry->ifa_name;
    found.index = static_cast<int>(if_nametoindex(entry->ifa_name));
    sockaddr_in address = {};
    std::memcpy(&address, entry->ifa_addr, sizeof address);
    found.ipv4 = ntohl(address.sin_addr.s_addr);
    found.up = (entry->ifa_flags & IFF_UP) != 0;
    found.multicast = (entry->ifa_flags & IFF_MULTICAST) != 0;
    found.loopback = (entry->ifa_flags & IFF_LOOPBACK) != 0;
    if ((entry->ifa_flags & IFF_BROADCAST) != 0 && entry->ifa_broadaddr != nullptr) {
      std::memcpy(&address, entry->ifa_broadaddr, sizeof address);
      found.broadcast = ntohl(address.sin_addr.s_addr);
    }
    for (const ifaddrs* link = list; link != nullptr; link = link->ifa_next) {
      if (link->ifa_addr == nullptr || link->ifa_addr->sa_family != AF_PACKET || found.name != link->ifa_name) continue;
      sockaddr_ll hardware = {};
      std::memcpy(&hardware, link->ifa_addr, sizeof hardware);
      std::copy_n(hardware.sll_addr, found.mac.size(), found.mac.begin());
    }
    interfaces.push_back(std::move(found));
  }
  freeifaddrs(list);
  return interfaces;
}

Result<Interface> find_interface(std::string_view port_name, const std::string& interface_name) {
  const auto interfaces = list_interfaces();
  for (const auto& candidate : interfaces) {
    if (candidate.name == interface_name) return candidate;
  }
  const int index = static_cast<int>(if_nametoindex(interface_name.c_str()));
  if (index != 0) {
    Interface bare;
    bare.name = interface_name;
    bare.index = index;
    return bare;
  }
  std::string names;
  if (struct if_nameindex* const all = if_nameindex(); all != nullptr) {
    for (const struct if_nameindex* one = all; one->if_index != 0; ++one) {
      names += (names.empty() ? "" : ", ") + std::string(one->if_name);
    }
    if_freenameindex(all);
  }
  return fail(ErrorCode::kNotFound, "{}: no network interface is called \"{}\"; choose one of: {}", port_name,
              interface_name, names.empty() ? "(this machine shows none)" : names);
}

Error net_error(std::string_view port_name, std::string_view action, int error_number) {
  ErrorCode code = ErrorCode::kIo;
  std::string_view next;
  switch (error_number) {
    case EADDRINUSE:
      next =
          "another program holds the port without sharing it; find it with 'ss -ulpn' and stop it or make it share the "
          "port";
      break;
    case EADDRNOTAVAIL:
      code = ErrorCode::kNotFound;
      next = "this machine does not have that address; see its addresses with 'ip -4 address'";
      break;
    case EACCES:
    case EPERM:
      code = ErrorCode::kPermission;
      next = "a firewall or the sandbox of the service blocks it; see 'sudo nft list ruleset' and the service's unit";
      break;
    case ENETUNREACH:
    case EHOSTUNREACH:
      next =
          "there is no route; name the interface to use, or give one: "
          "'sudo ip route add 239.255.0.0/16 dev INTERFACE' for sACN";
      break;
    case ENETDOWN: next = "the interface is down; run 'sudo ip link set INTERFACE up'"; break;
    case ENODEV:
    case ENXIO:
      code = ErrorCode::kDisconnected;
      next = "the interface is gone or has no IPv4 address; see 'ip -4 address'";
      break;
    case EMFILE:
    case ENFILE:
      next = "too many files are open; raise the limit with 'ulimit -n' or LimitNOFILE= in the service's unit";
      break;
    case ENOBUFS:
    case ENOMEM:
      next = "the system is out of network memory; carry fewer universes or raise net.ipv4.igmp_max_memberships";
      break;
    default: next = "see 'ip -4 address' and 'journalctl -k' for the state of the network"; break;
  }
  return {code, fmt::format("{}: cannot {}: {}; {}", port_name, action, std::strerror(error_number), next)};
}

namespace {

// Of the sockets that share a port by SO_REUSEPORT, the kernel selects one by the hash of the sender. This filter makes
// it select the first, so that a later socket takes nothing from it. When the first one closes, the kernel moves the
// last into its place (reuseport_detach_sock() in net/core/sock_reuseport.c).
void prefer_first(const Fd& socket) {
  sock_filter first[] = {BPF_STMT(BPF_RET | BPF_K, 0)};
  const sock_fprog program = {1, first};
  setsockopt(socket.get(), SOL_SOCKET, SO_ATTACH_REUSEPORT_CBPF, &program, sizeof program);
}

// An IPv6 socket that carries IPv4 as well. The kernel prefers an IPv4 socket of the same port for IPv4 datagrams.
// Returns no descriptor if the kernel or the sandbox has no IPv6.
Result<Fd> bind_dual_stack(std::string_view port_name, std::uint16_t udp_port) {
  Fd socket(::socket(AF_INET6, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return Fd();
  set_option(socket, IPPROTO_IPV6, IPV6_V6ONLY, 0);
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  set_option(socket, SOL_SOCKET, SO_REUSEPORT, 1);
  sockaddr_in6 any = {};
  any.sin6_family = AF_INET6;
  any.sin6_port = htons(udp_port);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any) == 0) {
    prefer_first(socket);
    return socket;
  }
  const int error_number = errno;
  if (error_number == EADDRNOTAVAIL || error_number == EPERM || error_number == EACCES) return Fd();
  return tl::unexpected(net_error(port_name, fmt::format("open UDP port {}", udp_port), error_number));
}

// Without IPv6: takes the port only if it is free, then allows others. With SO_REUSEADDR and without SO_REUSEPORT the
// kernel gives a unicast datagram to the socket that was bound last, which is not this one.
Result<Fd> bind_ipv4_last(std::string_view port_name, std::uint16_t udp_port) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error(port_name, "open a UDP socket", errno));
  const sockaddr_in any = address_of(0, udp_port);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) {
    return tl::unexpected(net_error(port_name, fmt::format("open UDP port {} beside others", udp_port), errno));
  }
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  return socket;
}

Result<Fd> bind_yielding(std::string_view port_name, std::uint16_t udp_port) {
  FL_ASSIGN(Fd socket, bind_dual_stack(port_name, udp_port));
  if (socket) return socket;
  return bind_ipv4_last(port_name, udp_port);
}

void set_receiver_options(const Fd& socket, const ReceiverSocket& wanted) {
  // The default of 208 KiB overflows in a stall of 130 ms at 9,000 packets a second. FORCE needs privilege and may
  // exceed net.core.rmem_max.
  if (!set_option(socket, SOL_SOCKET, SO_RCVBUFFORCE, wanted.buffer_bytes)) {
    set_option(socket, SOL_SOCKET, SO_RCVBUF, wanted.buffer_bytes);
  }
  set_option(socket, SOL_SOCKET, SO_RXQ_OVFL, 1);
  set_option(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  if (wanted.kernel_stamps) set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  if (wanted.packet_info) set_option(socket, IPPROTO_IP, IP_PKTINFO, 1);
  set_option(socket, SOL_SOCKET, SO_BROADCAST, 1);  // answers may go to a broadcast address
}

}  // namespace

Result<Fd> open_receiver(const ReceiverSocket& wanted) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error(wanted.port_name, "open a UDP socket", errno));
  // SO_REUSEADDR admits programs that set it, SO_REUSEPORT those that set only that.
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  set_option(socket, SOL_SOCKET, SO_REUSEPORT, 1);
  set_receiver_options(socket, wanted);
  const sockaddr_in address = address_of(wanted.bind_ipv4, wanted.udp_port);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    const int error_number = errno;
    return tl::unexpected(net_error(wanted.port_name,
                                    fmt::format("listen on UDP {}:{}", text_of_ipv4(wanted.bind_ipv4), wanted.udp_port),
                                    error_number));
  }
  prefer_first(socket);
  return socket;
}

Result<Fd> open_yielding_receiver(const ReceiverSocket& wanted) {
  FL_ASSIGN(Fd socket, bind_yielding(wanted.port_name, wanted.udp_port));
  set_receiver_options(socket, wanted);
  return socket;
}

int receive_all_groups(const Fd& receiver) { return set_option(receiver, IPPROTO_IP, IP_MULTICAST_ALL, 1) ? 0 : errno; }

Result<Fd> open_member(std::string_view port_name) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error(port_name, "open a UDP socket", errno));
  return socket;
}

Result<Fd> open_sender(const SenderSocket& wanted) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error(wanted.port_name, "open a UDP socket", errno));
  set_option(socket, SOL_SOCKET, SO_BROADCAST, 1);
  set_option(socket, IPPROTO_IP, IP_MULTICAST_LOOP, 1);
  set_option(socket, IPPROTO_IP, IP_MULTICAST_TTL, wanted.multicast_ttl);
  if (wanted.interface_index != 0) {
    const int error_number = leave_through(socket, wanted.interface_index);
    if (error_number != 0) return tl::unexpected(net_error(wanted.port_name, "choose the interface", error_number));
  }
  const sockaddr_in any = address_of(0, 0);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&any), sizeof any) != 0) {
    return tl::unexpected(net_error(wanted.port_name, "open a UDP port to send from", errno));
  }
  return socket;
}

Result<Fd> open_yielding_sender(const SenderSocket& wanted, std::uint16_t udp_port,
                                std::span<const std::uint16_t> op_code_filter) {
  FL_ASSIGN(Fd socket, bind_yielding(wanted.port_name, udp_port));
  set_option(socket, SOL_SOCKET, SO_BROADCAST, 1);
  set_option(socket, IPPROTO_IP, IP_PKTINFO, 1);
  set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  if (!op_code_filter.empty()) {
    // A filter of a UDP socket starts at the UDP header, which has 8 octets.
    std::vector<sock_filter> program = {BPF_STMT(BPF_LD | BPF_H | BPF_ABS, 8 + 8)};
    for (const std::uint16_t op_code : op_code_filter) {
      const auto as_read = static_cast<std::uint16_t>(op_code << 8 | op_code >> 8);  // BPF reads high octet first
      program.push_back(BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, as_read, 0, 1));
      program.push_back(BPF_STMT(BPF_RET | BPF_K, UINT32_MAX));
    }
    program.push_back(BPF_STMT(BPF_RET | BPF_K, 0));
    const sock_fprog filter = {static_cast<unsigned short>(program.size()), program.data()};
    // Without the filter more datagrams are read and dropped.
    setsockopt(socket.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
  }
  return socket;
}

Result<Fd> open_send_only(const SenderSocket& wanted, std::uint16_t udp_port) {
  Fd socket(::socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0));
  if (!socket) return tl::unexpected(net_error(wanted.port_name, "open a UDP socket", errno));
  set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1);
  set_option(socket, SOL_SOCKET, SO_REUSEPORT, 1);
  set_option(socket, SOL_SOCKET, SO_BROADCAST, 1);
  set_option(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  // A socket that is bound to a group receives only datagrams to that group, and this group has no senders. Its packets
  // have the source address of their route (inet_bind() in net/ipv4/af_inet.c).
  const sockaddr_in nobody = address_of(0xE000'0000, udp_port);
  if (::bind(socket.get(), reinterpret_cast<const sockaddr*>(&nobody), sizeof nobody) != 0) {
    return tl::unexpected(net_error(wanted.port_name, fmt::format("open UDP port {} beside others", udp_port), errno));
  }
  return socket;
}

int leave_through(const Fd& socket, int interface_index) {
  ip_mreqn request = {};
  request.imr_ifindex = interface_index;
  return setsockopt(socket.get(), IPPROTO_IP, IP_MULTICAST_IF, &request, sizeof request) == 0 ? 0 : errno;
}

std::uint16_t local_udp_port(const Fd& socket) {
  sockaddr_in address = {};
  socklen_t size = sizeof address;
  if (getsockname(socket.get(), reinterpret_cast<sockaddr*>(&address), &size) != 0) return 0;
  return ntohs(address.sin_port);
}

int route_error(std::uint32_t ipv4, int interface_index) {
  Fd probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!probe) return errno;
  set_option(probe, SOL_SOCKET, SO_BROADCAST, 1);
  if (interface_index != 0) {
    if (const int error_number = leave_through(probe, interface_index); error_number != 0) return error_number;
  }
  // Connecting a UDP socket sends nothing. Any port but 0 works.
  const sockaddr_in address = address_of(ipv4, 9);
  return ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ? 0 : errno;
}

int join_group(const Fd& socket, std::uint32_t group, int interface_index) {
  ip_mreqn request = {};
  request.imr_multiaddr.s_addr = htonl(group);
  request.imr_ifindex = interface_index;
  return setsockopt(socket.get(), IPPROTO_IP, IP_ADD_MEMBERSHIP, &request, sizeof request) == 0 ? 0 : errno;
}

void leave_group(const Fd& socket, std::uint32_t group, int interface_index) {
  ip_mreqn request = {};
  request.imr_multiaddr.s_addr = htonl(group);
  request.imr_ifindex = interface_index;
  setsockopt(socket.get(), IPPROTO_IP, IP_DROP_MEMBERSHIP, &request, sizeof request);
}

struct DatagramReader::Buffers {
  static constexpr std::size_t kControlBytes =
      CMSG_SPACE(sizeof(timespec)) + CMSG_SPACE(sizeof(std::uint32_t)) + CMSG_SPACE(sizeof(in_pktinfo));
  std::array<mmsghdr, kBatch> messages = {};
  std::array<iovec, kBatch> parts = {};
  std::array<sockaddr_in6, kBatch> senders = {};  // or sockaddr_in, which is smaller
  struct alignas(cmsghdr) Control {
    std::array<char, kControlBytes> bytes;
  };
  std::array<Control, kBatch> controls = {};
  std::array<std::array<std::uint8_t, kDatagramBytesMax>, kBatch> data = {};
};

DatagramReader::DatagramReader() : buffers_(std::make_unique<Buffers>()) {
  for (std::size_t i = 0; i < kBatch; ++i) {
    buffers_->parts[i] = {buffers_->data[i].data(), kDatagramBytesMax};
    msghdr& header = buffers_->messages[i].msg_hdr;
    header.msg_iov = &buffers_->parts[i];
    header.msg_iovlen = 1;
    header.msg_name = &buffers_->senders[i];
    header.msg_control = buffers_->controls[i].bytes.data();
  }
}

DatagramReader::~DatagramReader() = default;

int DatagramReader::read(int fd) {
  for (auto& message : buffers_->messages) {  // the kernel has overwritten them with the sizes of the last batch
    message.msg_hdr.msg_namelen = sizeof(sockaddr_in6);
    message.msg_hdr.msg_controllen = Buffers::kControlBytes;
  }
  const int count = recvmmsg(fd, buffers_->messages.data(), kBatch, MSG_DONTWAIT, nullptr);
  if (count < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR ? 0 : -errno;
  TimeNs wall_ns = 0;
  for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
    msghdr& header = buffers_->messages[i].msg_hdr;
    Datagram& datagram = datagrams_[i];
    datagram = {};
    datagram.bytes =
        std::span(buffers_->data[i]).first(std::min<std::size_t>(buffers_->messages[i].msg_len, kDatagramBytesMax));
    datagram.truncated = (header.msg_flags & MSG_TRUNC) != 0;
    const sockaddr_in6& sender = buffers_->senders[i];
    sockaddr_in sender4 = {};
    std::memcpy(&sender4, &sender, sizeof sender4);
    if (sender.sin6_family == AF_INET6) {
      // ::ffff:a.b.c.d from an IPv6 socket used for IPv4. True IPv6 leaves 0.0.0.0, which gets no answer.
      sender4.sin_addr.s_addr = 0;
      if (IN6_IS_ADDR_V4MAPPED(&sender.sin6_addr)) {
        std::memcpy(&sender4.sin_addr, &sender.sin6_addr.s6_addr[12], sizeof sender4.sin_addr);
      }
    }
    datagram.from_ipv4 = ntohl(sender4.sin_addr.s_addr);
    datagram.from_udp_port = ntohs(sender4.sin_port);
    for (cmsghdr* control = CMSG_FIRSTHDR(&header); control != nullptr; control = CMSG_NXTHDR(&header, control)) {
      if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SCM_TIMESTAMPNS) {
        timespec stamp = {};
        std::memcpy(&stamp, CMSG_DATA(control), sizeof stamp);
        if (wall_ns == 0) wall_ns = wall_clock_ns();
        const DurationNs age_ns = wall_ns - (stamp.tv_sec * kNsPerS + stamp.tv_nsec);
        datagram.age_ns = age_ns >= 0 && age_ns <= kAgeMaxNs ? age_ns : 0;
      } else if (control->cmsg_level == SOL_SOCKET && control->cmsg_type == SO_RXQ_OVFL) {
        std::memcpy(&kernel_drops_, CMSG_DATA(control), sizeof kernel_drops_);
      } else if (control->cmsg_level == IPPROTO_IP && control->cmsg_type == IP_PKTINFO) {
        in_pktinfo info = {};
        std::memcpy(&info, CMSG_DATA(control), sizeof info);
        datagram.to_ipv4 = ntohl(info.ipi_addr.s_addr);
        datagram.local_ipv4 = ntohl(info.ipi_spec_dst.s_addr);
        datagram.interface_index = info.ipi_ifindex;
      }
    }
  }
  return count;
}

struct DatagramWriter::Batch {
  std::vector<mmsghdr> messages;
  std::vector<iovec> parts;
  std::vector<sockaddr_in> receivers;
};

DatagramWriter::DatagramWriter() : batch_(std::make_unique<Batch>()) {}
DatagramWriter::~DatagramWriter() = default;

void DatagramWriter::add(std::span<const std::uint8_t> bytes, std::uint32_t ipv4, std::uint16_t udp_port) {
  // iovec is shared with reading and so has no const; sendmmsg only reads.
  batch_->parts.push_back({const_cast<std::uint8_t*>(bytes.data()), bytes.size()});
  batch_->receivers.push_back(address_of(ipv4, udp_port));
}

void DatagramWriter::prepare() {
  const std::size_t total = batch_->parts.size();
  batch_->messages.assign(total, mmsghdr{});
  for (std::size_t i = 0; i < total; ++i) {
    msghdr& header = batch_->messages[i].msg_hdr;
    header.msg_iov = &batch_->parts[i];
    header.msg_iovlen = 1;
    header.msg_name = &batch_->receivers[i];
    header.msg_namelen = sizeof(sockaddr_in);
  }
}

DatagramWriter::Sent DatagramWriter::flush(int fd) {
  prepare();
  const std::size_t total = batch_->parts.size();
  Sent sent;
  while (sent.count < total) {
    const auto left = static_cast<unsigned>(std::min<std::size_t>(total - sent.count, 1024));  // UIO_MAXIOV
    const int count = sendmmsg(fd, batch_->messages.data() + sent.count, left, MSG_DONTWAIT);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) {
      sent.error_number = errno;
      break;
    }
    sent.count += static_cast<std::size_t>(count);
  }
  batch_->parts.clear();
  batch_->receivers.clear();
  return sent;
}

void DatagramWriter::flush_each(int fd, std::vector<int>& error_numbers) {
  constexpr int kRefusalsMax = 64;
  prepare();
  const std::size_t total = batch_->parts.size();
  error_numbers.assign(total, 0);
  int refusals = 0;
  for (std::size_t at = 0; at < total;) {
    const auto left = static_cast<unsigned>(std::min<std::size_t>(total - at, 1024));  // UIO_MAXIOV
    const int count = sendmmsg(fd, batch_->messages.data() + at, left, MSG_DONTWAIT);
    if (count >= 0) {
      at += static_cast<std::size_t>(count);
      refusals = 0;
      continue;
    }
    const int error_number = errno;
    if (error_number == EINTR) continue;
    error_numbers[at++] = error_number;
    const bool full = error_number == EAGAIN || error_number == EWOULDBLOCK || error_number == ENOBUFS;
    if (!full && ++refusals < kRefusalsMax) continue;
    std::fill(error_numbers.begin() + static_cast<std::ptrdiff_t>(at), error_numbers.end(), error_number);
    break;
  }
  batch_->parts.clear();
  batch_->receivers.clear();
}

InterfaceWatch::InterfaceWatch()
    : socket_(::socket(AF_NETLINK, SOCK_RAW | SOCK_NONBLOCK | SOCK_CLOEXEC, NETLINK_ROUTE)) {
  if (!socket_) return;
  sockaddr_nl address = {};
  address.nl_family = AF_NETLINK;
  address.nl_groups = RTMGRP_LINK | RTMGRP_IPV4_IFADDR;
  if (::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) socket_.reset();
}

bool InterfaceWatch::read(std::vector<int>& lost) {
  if (!socket_) return false;
  bool changed = false;
  alignas(nlmsghdr) std::array<char, 16u << 10> buffer;
  while (true) {
    const ssize_t size = recv(socket_.get(), buffer.data(), buffer.size(), MSG_DONTWAIT);
    if (size < 0 && errno == ENOBUFS) {  // messages were lost: check everything again
      changed = true;
      continue;
    }
    if (size <= 0) return changed;
    changed = true;
    auto left = static_cast<unsigned>(size);
    for (auto* header = reinterpret_cast<nlmsghdr*>(buffer.data()); NLMSG_OK(header, left);
         header = NLMSG_NEXT(header, left)) {
      if (header->nlmsg_type == RTM_DELADDR && header->nlmsg_len >= NLMSG_LENGTH(sizeof(ifaddrmsg))) {
        ifaddrmsg message = {};
        std::memcpy(&message, NLMSG_DATA(header), sizeof message);
        lost.push_back(static_cast<int>(message.ifa_index));
      } else if (header->nlmsg_type == RTM_DELLINK && header->nlmsg_len >= NLMSG_LENGTH(sizeof(ifinfomsg))) {
        ifinfomsg message = {};
        std::memcpy(&message, NLMSG_DATA(header), sizeof message);
        lost.push_back(message.ifi_index);
      }
    }
  }
}

}  // namespace footlight::drivers
