#include <lcm/lcm.h>

#include <arpa/inet.h>
#include <dirent.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <optional>
#include <utility>

#include "gecos/media/descriptor.hpp"
#include "gecos/media/lcm/port.hpp"

namespace gecos::media {
namespace {

/// Messages of a subscription that LCM may hold while nobody pumps. Its default of 30 loses answers;
/// without any bound a program that is busy elsewhere would fill its memory.
constexpr int queue_capacity = 4096;
constexpr int most_at_once = 1024;

/// What lcm_create and lcm_subscribe open at most. LCM crashes when descriptors run out within them.
constexpr std::size_t descriptors_needed = 16;

/// Takes as many descriptors as LCM will need and gives them back. Nothing when there are so many;
/// else what is wrong.
std::optional<MediumError> short_of_descriptors() {
  std::array<Descriptor, descriptors_needed> spare;
  for (Descriptor& one : spare) {
    one = Descriptor(::open("/dev/null", O_RDONLY | O_CLOEXEC));
    if (!one) {
      return MediumError{std::string("lcm: no descriptors are left (") + std::strerror(errno) +
                         "); `ulimit -n` shows the limit, and `ls /proc/" +
                         std::to_string(::getpid()) + "/fd` what is open"};
    }
  }
  return std::nullopt;
}

/// Nothing for a group that multicast knows.
std::optional<MediumError> no_group(const std::string& group) {
  in_addr address{};
  if (::inet_pton(AF_INET, group.c_str(), &address) == 1 && IN_MULTICAST(ntohl(address.s_addr))) {
    return std::nullopt;
  }
  return MediumError{"lcm: " + group +
                     " is no multicast group; those are 224.0.0.0 to 239.255.255.255, and ours is "
                     "usually " +
                     LcmOptions{}.group};
}

std::string multicast_advice(const LcmOptions& options) {
  return " (no multicast route? run as root:  ip link set lo multicast on && ip route add " +
         options.group + "/32 dev " + (options.ttl == 0 ? "lo" : "<the network's interface>") + ")";
}

/// The UDP socket of this process that is bound to `port`, or -1.
int find_udp_socket(std::uint16_t port) {
  DIR* const all = ::opendir("/proc/self/fd");
  if (all == nullptr) return -1;
  int found = -1;
  while (const dirent* entry = ::readdir(all)) {
    const int fd = std::atoi(entry->d_name);
    int type = 0;
    socklen_t size = sizeof type;
    if (::getsockopt(fd, SOL_SOCKET, SO_TYPE, &type, &size) != 0 || type != SOCK_DGRAM) continue;
    sockaddr_in bound{};
    size = sizeof bound;
    if (::getsockname(fd, reinterpret_cast<sockaddr*>(&bound), &size) == 0 &&
        bound.sin_family == AF_INET && bound.sin_port == htons(port) &&
        (::fcntl(fd, F_GETFD) & FD_CLOEXEC) == 0) {
      found = fd;
    }
  }
  ::closedir(all);
  return found;
}

}  // namespace

struct LcmPort::Subscription {
  Take take;

  static void arrived(const lcm_recv_buf_t* received, const char* /*channel*/, void* self) {
    static_cast<Subscription*>(self)->take(
        {static_cast<const std::byte*>(received->data), received->data_size});
  }
};

tl::expected<std::unique_ptr<LcmPort>, MediumError> LcmPort::open(const LcmOptions& options,
                                                                  std::uint16_t port) {
  if (auto wrong = no_group(options.group)) return tl::unexpected(std::move(*wrong));
  const std::string provider = "udpm://" + options.group + ":" + std::to_string(port) +
                               "?ttl=" + std::to_string(options.ttl) +
                               "&recv_buf_size=" + std::to_string(options.receive_buffer_bytes);
  if (auto wrong = short_of_descriptors()) return tl::unexpected(std::move(*wrong));
  lcm_t* const lcm = ::lcm_create(provider.c_str());
  if (lcm == nullptr) {
    return tl::unexpected(
        MediumError{"lcm: cannot open " + provider + multicast_advice(options)});
  }
  return std::unique_ptr<LcmPort>(new LcmPort(lcm, port, multicast_advice(options)));
}

LcmPort::LcmPort(_lcm_t* lcm, std::uint16_t port, std::string advice)
    : lcm_(lcm), port_(port), advice_(std::move(advice)), fork_watch_(this, [](void* owner) noexcept {
        auto& self = *static_cast<LcmPort*>(owner);
        self.inherited_.store(true);
        if (self.receiving_socket_ >= 0) ::close(self.receiving_socket_);
      }) {}

LcmPort::~LcmPort() {
  if (!inherited_.load()) ::lcm_destroy(lcm_);
}

tl::expected<void, MediumError> LcmPort::subscribe(const std::string& channel, Take take) {
  if (auto wrong = short_of_descriptors()) return tl::unexpected(std::move(*wrong));
  auto subscription = std::make_unique<Subscription>(Subscription{std::move(take)});
  // LCM reads a channel as a regular expression; ours are letters, digits, - and _.
  lcm_subscription_t* const made =
      ::lcm_subscribe(lcm_, channel.c_str(), &Subscription::arrived, subscription.get());
  const int descriptor = made == nullptr ? -1 : ::lcm_get_fileno(lcm_);
  if (descriptor < 0) {
    return tl::unexpected(MediumError{"lcm: cannot receive on port " + std::to_string(port_) + advice_});
  }
  ::lcm_subscription_set_queue_capacity(made, queue_capacity);
  subscriptions_.push_back(std::move(subscription));
  if (descriptor_ < 0) close_on_exec();
  descriptor_ = descriptor;
  return {};
}

void LcmPort::close_on_exec() {
  // LCM leaves its socket open in programs that we start, which would receive for nobody.
  receiving_socket_ = find_udp_socket(port_);
  if (receiving_socket_ >= 0) ::fcntl(receiving_socket_, F_SETFD, FD_CLOEXEC);
}

bool LcmPort::pump() {
  if (inherited_.load(std::memory_order_relaxed)) return false;
  const std::lock_guard lock(mutex_);
  for (int i = 0; i < most_at_once; ++i) {
    if (::lcm_handle_timeout(lcm_, 0) <= 0) return false;
  }
  return true;
}

bool LcmPort::publish(const std::string& channel, ByteView datagram) {
  if (inherited_.load(std::memory_order_relaxed)) return false;
  return ::lcm_publish(lcm_, channel.c_str(), datagram.data(),
                       static_cast<unsigned>(datagram.size())) == 0;
}

}  // namespace gecos::media
