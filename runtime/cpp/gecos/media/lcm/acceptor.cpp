#include <sys/socket.h>
#include <sys/un.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstring>
#include <system_error>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/media/lcm.hpp"
#include "gecos/media/lcm/link.hpp"

namespace gecos::media {
namespace {

constexpr std::size_t most_guests = 256;   // met and not yet accepted
constexpr std::size_t most_links = 4096;
constexpr std::size_t most_gone = 256;
constexpr std::size_t longest_name = 32;

std::string channel_of_name(std::string_view name) {
  std::string channel = "GW";
  for (const char c : name.substr(0, longest_name)) {
    const bool plain = (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    channel += plain ? c : '_';
  }
  return channel;
}

/// Says to this host that a place is served. Multicast lets anybody listen beside us, so a name in the
/// kernel's table of abstract sockets stands for the place: it goes with the process that holds it.
class Claim {
 public:
  static tl::expected<std::unique_ptr<Claim>, MediumError> stake(const LcmAddress& place) {
    const std::string name = "gecos/" + place.to_string();
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
              ? place.to_string() + " is served already by another program of this host; `ss -xap | "
                                    "grep gecos/lcm` tells by which"
              : place.to_string() + " cannot be claimed: " + std::strerror(errno)});
    }
    return std::make_unique<Claim>(std::move(held));
  }
  explicit Claim(Descriptor held) : held_(std::move(held)) {}

 private:
  Descriptor held_;
  const ForkWatch fork_watch_{this, [](void* owner) noexcept {
                                static_cast<Claim*>(owner)->held_.reset();
                              }};
};

class LcmAcceptor final : public Acceptor {
 public:
  /// `claim` is null for a place of its own.
  LcmAcceptor(std::shared_ptr<LcmDoor> door, std::unique_ptr<Claim> claim)
      : claim_(std::move(claim)),
        door_(std::move(door)),
        address_(door_->address().to_string()),
        descriptors_{door_->descriptor(), bell_.descriptor()} {}
  ~LcmAcceptor() override { door_->close(); }

  const Offer& offer() const override { return lcm_offer(); }
  const std::string& address() const override { return address_; }

  std::unique_ptr<Link> accept() override {
    bell_.quiet();
    if (door_->pump()) ring_bell(bell_.descriptor());  // for who watches edges
    LcmDoor::Guest guest;
    while (door_->next_guest(guest)) {
      auto link = LcmServerLink::welcome(door_, guest);
      if (link) return std::move(*link);
      log_warning("lcm", "cannot answer a client: " + link.error().text);
      door_->forget(guest.client);
    }
    return nullptr;
  }
  std::span<const int> descriptors() const override { return descriptors_; }

  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    if (streams_ == nullptr) {
      auto opened = LcmPort::open(door_->options(), stream_port_);
      if (!opened) throw std::runtime_error(opened.error().text);
      streams_ = std::move(*opened);
    }
    SharedStream where;
    where.largest = static_cast<std::uint32_t>(std::min(largest, largest_lcm_packet));
    where.depth = static_cast<std::uint16_t>(std::clamp<std::size_t>(depth, 1, 1024));
    where.port = stream_port_;
    where.channel = draw_number();
    return std::make_unique<LcmStreamWriter>(
        std::make_shared<LcmStream>(streams_, where, door_->server()));
  }

 private:
  const std::unique_ptr<Claim> claim_;
  Bell bell_;
  const std::shared_ptr<LcmDoor> door_;
  const std::string address_;
  const std::array<int, 2> descriptors_;
  const std::uint16_t stream_port_ = draw_port();
  std::shared_ptr<LcmPort> streams_;
};

class Lcm final : public Medium {
 public:
  explicit Lcm(LcmOptions options) : options_(std::move(options)) {}

  const Offer& offer() const override { return lcm_offer(); }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    LcmAddress address = well_known_place(name);
    std::unique_ptr<Claim> claim;
    if (well_known) {
      auto staked = Claim::stake(address);
      if (!staked) return tl::unexpected(std::move(staked.error()));
      claim = std::move(*staked);
    } else {
      address.port = draw_port();
      address.channel = lcm_channel("GO", draw_number());
    }
    auto in = LcmPort::open(options_, address.port);
    if (!in) return tl::unexpected(std::move(in.error()));
    auto door = std::make_shared<LcmDoor>(options_, std::move(*in), address);
    if (auto opened = door->open(); !opened) return tl::unexpected(std::move(opened.error()));
    return std::make_unique<LcmAcceptor>(std::move(door), std::move(claim));
  }

  tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) override {
    const auto parsed = LcmAddress::parse(address);
    if (!parsed) {
      return tl::unexpected(MediumError{std::string(address) +
                                        ": an address of lcm reads lcm:<group>:<port>/<channel>"});
    }
    return LcmClientLink::connect(options_, *parsed);
  }

  std::string well_known_address(std::string_view name) const override {
    return well_known_place(name).to_string();
  }

 private:
  LcmAddress well_known_place(std::string_view name) const {
    return {options_.group, options_.well_known_port, channel_of_name(name)};
  }

  const LcmOptions options_;
};

}  // namespace

LcmDoor::LcmDoor(LcmOptions options, std::unique_ptr<LcmPort> in, LcmAddress address)
    : options_(std::move(options)), in_(std::move(in)), address_(std::move(address)) {}

tl::expected<void, MediumError> LcmDoor::open() {
  return in_->subscribe(address_.channel, [this](ByteView datagram) { take(datagram); });
}

void LcmDoor::take(ByteView datagram) {
  const auto header = DatagramHeader::read(datagram);
  if (!header) return;
  // A client of another server at this place, or of an earlier life of this one.
  if (header->server != 0 && header->server != server_) return;
  std::shared_ptr<LcmInbox> inbox;
  {
    const std::lock_guard lock(mutex_);
    const auto found = inboxes_.find(header->client);
    if (found != inboxes_.end()) {
      inbox = found->second;
    } else {
      // Any first word of a client opens a link, since its Hello may be lost.
      if (closed_.load() || header->server != 0 || header->reply_port == 0 ||
          header->kind == DatagramKind::Bye || guests_.size() == most_guests ||
          inboxes_.size() == most_links || std::ranges::find(gone_, header->client) != gone_.end()) {
        return;
      }
      try {
        inbox = std::make_shared<LcmInbox>();
      } catch (const std::system_error& failed) {  // nothing may pass through LCM's own C
        log_warning("lcm", std::string("cannot let a client in: ") + failed.what());
        return;  // it says Hello again
      }
      inboxes_.emplace(header->client, inbox);
      guests_.push_back({header->client, header->reply_port, inbox});
    }
  }
  inbox->take(*header, datagram.subspan(DatagramHeader::bytes));
}

bool LcmDoor::next_guest(Guest& into) {
  const std::lock_guard lock(mutex_);
  if (guests_.empty()) return false;
  into = std::move(guests_.front());
  guests_.pop_front();
  return true;
}

void LcmDoor::forget(std::uint64_t client) {
  const std::lock_guard lock(mutex_);
  if (inboxes_.erase(client) == 0) return;
  if (gone_.size() == most_gone) gone_.pop_front();
  gone_.push_back(client);
}

std::unique_ptr<Medium> make_lcm(LcmOptions options) {
  return std::make_unique<Lcm>(std::move(options));
}

}  // namespace gecos::media
