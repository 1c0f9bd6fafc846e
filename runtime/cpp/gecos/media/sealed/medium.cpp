#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <stdexcept>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/system_error.hpp"
#include "gecos/media/sealed/clear_channel.hpp"
#include "gecos/media/sealed/connection.hpp"
#include "gecos/media/sealed/responder.hpp"

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

/// Reserves a well-known address on this host for one process. Several processes can listen to one
/// multicast address, so that listening alone does not reserve the address. Therefore the
/// reservation is the name of an abstract Unix socket. The kernel removes this name when the
/// process ends.
class Claim {
 public:
  static tl::expected<std::unique_ptr<Claim>, MediumError> stake(const SealedAddress& place) {
    const std::string name = "gecos/" + place.place();
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::copy_n(name.begin(), std::min(name.size(), sizeof address.sun_path - 1),
                address.sun_path + 1);  // a leading NUL: an abstract socket, no file
    const auto size = static_cast<socklen_t>(
        std::min(offsetof(sockaddr_un, sun_path) + 1 + name.size(), sizeof address));
    Descriptor held(::socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC, 0));
    if (!held || ::bind(held.get(), reinterpret_cast<const sockaddr*>(&address), size) != 0) {
      return tl::unexpected(
          MediumError{errno == EADDRINUSE
                          ? place.place() +
                                " is served already by another program of this host; `ss -xap | "
                                "grep gecos/" +
                                place.medium + "` shows which program"
                          : place.place() + " cannot be reserved: " + system_text(errno)});
    }
    return std::make_unique<Claim>(std::move(held));
  }
  explicit Claim(Descriptor held) : held_(std::move(held)) {}

 private:
  Descriptor held_;
  const ForkWatch fork_watch_{
      this, [](void* owner) noexcept { static_cast<Claim*>(owner)->held_.reset(); }};
};

class SealedAcceptor final : public Acceptor {
 public:
  /// `claim` holds the reservation of a well-known address; null for any other address.
  SealedAcceptor(std::shared_ptr<HandshakeResponder> responder, std::unique_ptr<Claim> claim)
      : claim_(std::move(claim)),
        responder_(std::move(responder)),
        address_(responder_->address().to_string()),
        descriptors_{responder_->descriptor(), responder_->event().descriptor()} {}
  ~SealedAcceptor() override { responder_->close(); }

  const Capabilities& capabilities() const override {
    return responder_->options().network->capabilities();
  }
  const std::string& address() const override { return address_; }

  std::unique_ptr<Connection> accept() override {
    responder_->event().drain();
    if (responder_->pump()) responder_->event().notify();  // announces the unread datagrams
    while (auto pending = responder_->next_pending()) {
      if (const std::string why = why_not(*pending); !why.empty()) {
        log_info(responder_->address().medium, responder_->address().place() + " refused key " +
                                                   pending->key.short_name() + ": " + why);
        responder_->refuse(std::move(*pending), why);
        continue;
      }
      const std::uint64_t client = pending->client;
      auto connection = SealedServer::welcome(responder_, std::move(*pending));
      if (connection) return std::move(*connection);
      log_warning(responder_->address().medium,
                  "cannot answer a client: " + connection.error().text);
      responder_->forget(client);
    }
    return nullptr;
  }
  void admit_by(AdmitPeer admit) override { admit_ = std::move(admit); }
  std::span<const int> descriptors() const override { return descriptors_; }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return responder_->make_stream(largest, depth);
  }
  tl::expected<std::unique_ptr<OpenChannel>, MediumError> open_channel(
      const std::string& name) override {
    return open_clear_channel(responder_->options(), name);
  }

 private:
  /// Returns why the client `pending` is not admitted; an empty text if `pending` is admitted. The
  /// decision depends on the key that the client has proved, and on its owner. The key of this
  /// program's user is always admitted.
  std::string why_not(const HandshakeResponder::PendingPeer& pending) const {
    if (!admit_ || pending.key == responder_->keys()->own.public_key()) return "";
    return admit_(peer_of(pending, *responder_));
  }

  const std::unique_ptr<Claim> claim_;
  const std::shared_ptr<HandshakeResponder> responder_;
  AdmitPeer admit_;
  const std::string address_;
  const std::array<int, 2> descriptors_;
};

class Sealed final : public Medium {
 public:
  explicit Sealed(SealedOptions options) : options_(std::move(options)) {}

  const Capabilities& capabilities() const override { return options_.network->capabilities(); }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    const auto keys = this->keys();
    if (!keys) return tl::unexpected(keys.error());
    SealedAddress address = well_known_place(name);
    std::unique_ptr<Claim> claim;
    if (well_known) {
      auto staked = Claim::stake(address);
      if (!staked) return tl::unexpected(std::move(staked.error()));
      claim = std::move(*staked);
    } else {
      address.port = draw_port();
      address.channel = channel_name("GO", draw_number());
      address.key = (*keys)->own.public_key();
    }
    auto in = options_.network->open(address.port);
    if (!in) return tl::unexpected(std::move(in.error()));
    auto responder = std::make_shared<HandshakeResponder>(options_, *keys, std::move(*in), address);
    if (auto opened = responder->open(); !opened) return tl::unexpected(std::move(opened.error()));
    return std::make_unique<SealedAcceptor>(std::move(responder), std::move(claim));
  }

  tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) override {
    const auto parsed = SealedAddress::parse(address);
    if (const std::string name(capabilities().name); !parsed || parsed->medium != name) {
      return tl::unexpected(MediumError{std::string(address) + ": not an address of " + name +
                                        ", which has the form " + name +
                                        ":<group>:<port>/<channel>#<key>"});
    }
    const auto keys = this->keys();
    if (!keys) return tl::unexpected(keys.error());
    return SealedClient::connect(options_, *keys, *parsed);
  }

  std::string well_known_address(std::string_view name) const override {
    return well_known_place(name).to_string();
  }

 private:
  SealedAddress well_known_place(std::string_view name) const {
    return {std::string(capabilities().name), options_.network->name(), options_.well_known_port,
            channel_of_name(name), std::nullopt};
  }

  /// Returns the keys of this program's user. Opens the key directory at the first call, because
  /// most programs never need the keys.
  tl::expected<std::shared_ptr<const SealedKeys>, MediumError> keys() {
    const MutexLock lock(mutex_);
    if (keys_ == nullptr) {
      auto opened = SealedKeys::open(options_.key_directory);
      if (!opened) {
        return tl::unexpected(
            MediumError{std::string(capabilities().name) + " needs a key: " + opened.error().text});
      }
      keys_ = std::move(*opened);
    }
    return keys_;
  }

  const SealedOptions options_;
  Mutex mutex_;
  std::shared_ptr<const SealedKeys> keys_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace

std::unique_ptr<Medium> make_sealed(SealedOptions options) {
  return std::make_unique<Sealed>(std::move(options));
}

}  // namespace gecos::media
