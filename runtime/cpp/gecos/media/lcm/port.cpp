#include "gecos/media/lcm/port.hpp"

#include <arpa/inet.h>
#include <lcm/lcm.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <optional>
#include <utility>

#include "gecos/base/descriptors.hpp"
#include "gecos/base/system_error.hpp"

namespace gecos::media {
namespace {

/// The maximum number of descriptors that lcm_create opens. LCM crashes when the process runs out
/// of descriptors in that call.
constexpr std::size_t descriptors_needed = 16;

/// Returns an error when `group` is not a multicast group; otherwise nullopt.
std::optional<MediumError> no_group(const std::string& group) {
  in_addr address{};
  if (::inet_pton(AF_INET, group.c_str(), &address) == 1 && IN_MULTICAST(ntohl(address.s_addr))) {
    return std::nullopt;
  }
  return MediumError{"lcm: " + group +
                     " is not a multicast group; use one from 224.0.0.0 to 239.255.255.255, "
                     "usually " +
                     LcmOptions{}.group};
}

/// Returns an error when no packet can be sent to `port` of the group; otherwise nullopt. This
/// check comes before the check of the LCM library, because a failure of that check writes fifteen
/// lines to stderr.
std::optional<MediumError> no_route(const LcmOptions& options, std::uint16_t port) {
  sockaddr_in place{};
  place.sin_family = AF_INET;
  place.sin_port = htons(port);
  ::inet_pton(AF_INET, options.group.c_str(), &place.sin_addr);
  const Descriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (probe &&
      ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0) {
    return std::nullopt;
  }
  return MediumError{"lcm: cannot send to " + options.group + ": " + system_text(errno) +
                     multicast_advice(options)};
}

}  // namespace

tl::expected<std::unique_ptr<LcmPort>, MediumError> LcmPort::open(const LcmOptions& options,
                                                                  std::uint16_t port) {
  if (auto wrong = no_group(options.group)) return tl::unexpected(std::move(*wrong));
  const std::string provider = "udpm://" + options.group + ":" + std::to_string(port) +
                               "?ttl=" + std::to_string(options.ttl);
  if (!descriptors_left(descriptors_needed)) {
    return tl::unexpected(MediumError{"lcm: " + system_text(errno)});
  }
  if (auto wrong = no_route(options, port)) return tl::unexpected(std::move(*wrong));
  lcm_t* const lcm = ::lcm_create(provider.c_str());
  if (lcm == nullptr) {
    return tl::unexpected(MediumError{"lcm: cannot open " + provider + multicast_advice(options)});
  }
  return std::unique_ptr<LcmPort>(new LcmPort(lcm, options, port));
}

LcmPort::LcmPort(_lcm_t* lcm, LcmOptions options, std::uint16_t port)
    : lcm_(lcm),
      options_(std::move(options)),
      port_(port),
      fork_watch_(this, [](void* owner) noexcept { static_cast<LcmPort*>(owner)->abandon(); }) {}

LcmPort::~LcmPort() {
  if (!inherited_.load()) ::lcm_destroy(lcm_);
}

void LcmPort::abandon() noexcept {
  inherited_.store(true);
  if (receiver_) receiver_->close();
}

tl::expected<std::uint64_t, MediumError> LcmPort::subscribe(const std::string& channel, Take take) {
  const MutexLock lock(mutex_);
  if (!receiver_) {
    auto opened = LcmReceiver::open(options_, port_);
    if (!opened) return tl::unexpected(std::move(opened.error()));
    receiver_.emplace(std::move(*opened));
    descriptor_ = receiver_->descriptor();
  }
  subscriptions_.emplace(channel, Subscription{++last_number_, std::move(take)});
  return last_number_;
}

void LcmPort::unsubscribe(std::uint64_t subscription) {
  if (inherited()) return;
  decltype(subscriptions_)::node_type ended;  // destroyed after the mutex is unlocked
  const MutexLock lock(mutex_);
  const auto found = std::ranges::find_if(
      subscriptions_, [&](const auto& one) { return one.second.number == subscription; });
  if (found != subscriptions_.end()) ended = subscriptions_.extract(found);
}

bool LcmPort::pump(int most) {
  if (inherited()) return false;
  const MutexLock lock(mutex_);
  if (!receiver_) return false;
  for (int taken = 0; taken < most; ++taken) {
    const auto message = receiver_->next();
    if (!message) return false;
    const auto [first, last] = subscriptions_.equal_range(message->channel);
    for (auto one = first; one != last; ++one) one->second.take(message->content);
  }
  return true;
}

bool LcmPort::publish(const std::string& channel, ByteView datagram) {
  if (inherited()) return false;
  return ::lcm_publish(lcm_, channel.c_str(), datagram.data(),
                       static_cast<unsigned>(datagram.size())) == 0;
}

}  // namespace gecos::media
