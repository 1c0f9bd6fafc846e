#include "gecos/media/shm/shm.hpp"

#include <unistd.h>

#include <cerrno>
#include <utility>

#include "gecos/base/system_error.hpp"
#include "gecos/media/registration.hpp"
#include "gecos/media/shm/acceptor.hpp"
#include "gecos/media/shm/connection.hpp"

namespace gecos::media {
namespace {

constexpr std::string_view prefix = "shm:";

class Shm final : public Medium {
 public:
  explicit Shm(ShmOptions options) : options_(std::move(options)) {}

  const Capabilities& capabilities() const override { return shm_capabilities; }

  tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                              bool well_known) override {
    return shm::ShmAcceptor::open(options_, name, well_known);
  }

  tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) override {
    const auto error = [&](const std::string& text) {
      return tl::unexpected(MediumError{std::string(address) + ": " + text});
    };
    if (!address.starts_with(prefix)) return error("an address of shm begins with \"shm:\"");
    Descriptor socket = shm::connect_to(std::string(address.substr(prefix.size())));
    if (!socket) {
      if (errno == ENOENT || errno == ECONNREFUSED) return error(no_server(address));
      if (errno == EAGAIN) return error("too many clients wait for this server; try again");
      if (errno == EACCES)
        return error(
            "the socket belongs to another user, whose programs are reached over lcm only");
      return error(system_text(errno));
    }
    auto server = shm::peer_of(socket.get());
    if (!server) return error(server.error());
    if (server->uid != ::geteuid() && !shm::serves_the_host(*server->uid)) {
      return error("the server runs as another user, " + server->description +
                   ", and is reached over lcm only");
    }
    auto death = shm::death_of_peer(socket.get(), *server->pid);
    if (!death) return error(no_server(address) + ": " + death.error());
    return shm::ShmConnection::greet(std::move(socket), std::move(*server), std::move(*death));
  }

  std::string well_known_address(std::string_view name) const override {
    return std::string(prefix) + shm::well_known_path(options_.directory, name);
  }

  std::vector<std::string> shared_addresses(std::string_view name) const override {
    std::vector<std::string> addresses;
    for (const std::string& directory : shm::directories_of_the_host(options_.directory)) {
      addresses.push_back(std::string(prefix) + shm::well_known_path(directory, name));
    }
    return addresses;
  }

 private:
  std::string no_server(std::string_view address) const {
    const bool ours = address.starts_with(std::string(prefix) + options_.directory + "/");
    if (!ours) return "no server listens at this address";
    return "no server listens at this address (only servers of uid " + std::to_string(::geteuid()) +
           " are in the directory of this address; use GECOS_BROKER=lcm to reach programs of other "
           "users)";
  }

  const ShmOptions options_;
};

}  // namespace

std::unique_ptr<Medium> make_shm(ShmOptions options) {
  return std::make_unique<Shm>(std::move(options));
}

const Registration shm_registration{
    shm_capabilities, []() -> tl::expected<std::unique_ptr<Medium>, MediumError> {
      const ShmOptions options;
      return shm::prepare_directory(options.directory).map([&] { return make_shm(options); });
    }};

}  // namespace gecos::media
