#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/lcm/door.hpp"
#include "gecos/media/lcm/link.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t longest_name = 32;

std::string channel_of_name(std::string_view name) {
  std::string channel = "GW";
  for (const char c : name.substr(0, longest_name)) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    channel += plain ? c : '_';
  }
  return channel;
}

/// Says to this host that a place is served. Multicast lets anybody listen beside us, so a name in
/// the kernel's table of abstract sockets stands for the place: it goes with the process that holds
/// it.
class Claim {
 public:
  static tl::expected<std::unique_ptr<Claim>, MediumError> stake(const LcmAddress& place) {
    const std::string name = "gecos/" + place.place();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy_n(name.begin(), std::min(name.size(), sizeof address.sun_path - 1),
                address.sun_path + 1);  // behind a NUL: no file
    const auto size = static_cast<socklen_t>(
        std::min(offsetof(sockaddr_un, sun_path) + 1 + name.size(), sizeof address));
    Descriptor held(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!held || ::bind(held.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      return tl::unexpected(MediumError{
          errno == EADDRINUSE
              ? place.place() + " is served already by another program of this host; `ss -xap | "
                                "grep gecos/lcm` tells by which"
              : place.place() + " cannot be claimed: " + system_text(errno)});
    }
    return std::make_unique<Claim>(std::move(held));
  }
  explicit Claim(Descriptor held) : held_(std::move(held)) {}

 private:
  Descriptor held_;
  const ForkWatch fork_watch_{
      this, [](void* owner) noexcept { static_cast<Claim*>(owner)->held_.reset(); }};
};

class LcmAcceptor final : public Acceptor {
 public:
  /// `claim` is null for a place of its own.
  LcmAcceptor(std::shared_ptr<LcmDoor> door, std::unique_ptr<Claim> claim)
      : claim_(std::move(claim)),
        door_(std::move(door)),
        address_(door_->address().to_string()),
        descriptors_{door_->descriptor(), door_->bell().descriptor()} {}
  ~LcmAcceptor() override { door_->close(); }

  const Offer& offer() const override { return lcm_offer(); }
  const std::string& address() const override { return address_; }

  std::unique_ptr<Link> accept() override {
    door_->bell().quiet();
    if (door_->pump()) ring_bell(door_->bell().descriptor());  // for who watches edges
    while (auto guest = door_->next_guest()) {
      const std::uint64_t client = guest->client;
      auto link = LcmServerLink::welcome(door_, std::move(*guest));
      if (link) return std::move(*link);
      log_warning("lcm", "cannot answer a client: " + link.error().text);
      door_->forget(client);
    }
    return nullptr;
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return door_->make_stream(largest, depth);
  }

 private:
  const std::unique_ptr<Claim> claim_;
  const std::shared_ptr<LcmDoor> door_;
  const std::string address_;
  const std::array<int, 2> descriptors_;
};

class Lcm final : public Medium {
 public:
  explicit Lcm(LcmOptions options) : options_(std::move(options)) {}

  const Offer& offer() const override { return lcm_offer(); }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    const auto keys = this->keys();
    if (!keys) return tl::unexpected(keys.error());
    LcmAddress address = well_known_place(name);
    std::unique_ptr<Claim> claim;
    if (well_known) {
      auto staked = Claim::stake(address);
      if (!staked) return tl::unexpected(std::move(staked.error()));
      claim = std::move(*staked);
    } else {
      address.port = draw_port();
      address.channel = lcm_channel("GO", draw_number());
      address.key = (*keys)->own.public_key();
    }
    auto in = LcmPort::open(options_, address.port);
    if (!in) return tl::unexpected(std::move(in.error()));
    auto door = std::make_shared<LcmDoor>(options_, *keys, std::move(*in), address);
    if (auto opened = door->open(); !opened) return tl::unexpected(std::move(opened.error()));
    return std::make_unique<LcmAcceptor>(std::move(door), std::move(claim));
  }

  tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) override {
    const auto parsed = LcmAddress::parse(address);
    if (!parsed) {
      return tl::unexpected(MediumError{
          std::string(address) + ": an address of lcm reads lcm:<group>:<port>/<channel>#<key>"});
    }
    const auto keys = this->keys();
    if (!keys) return tl::unexpected(keys.error());
    return LcmClientLink::connect(options_, *keys, *parsed);
  }

  std::string well_known_address(std::string_view name) const override {
    return well_known_place(name).to_string();
  }

 private:
  LcmAddress well_known_place(std::string_view name) const {
    return {options_.group, options_.well_known_port, channel_of_name(name), std::nullopt};
  }

  /// Opened with the first use, since most programs never need them.
  tl::expected<std::shared_ptr<const LcmKeys>, MediumError> keys() {
    const std::lock_guard lock(mutex_);
    if (keys_ == nullptr) {
      auto opened = LcmKeys::open(options_.key_directory);
      if (!opened) return tl::unexpected(std::move(opened.error()));
      keys_ = std::move(*opened);
    }
    return keys_;
  }

  const LcmOptions options_;
  std::mutex mutex_;
  std::shared_ptr<const LcmKeys> keys_;
};

}  // namespace

std::unique_ptr<Medium> make_lcm(LcmOptions options) {
  return std::make_unique<Lcm>(std::move(options));
}

}  // namespace gecos::media
