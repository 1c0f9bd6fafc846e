#include "gecos/media/kinds.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "gecos/media/layers/checked.hpp"
#include "gecos/media/layers/fragments.hpp"
#include "gecos/media/layers/transfer.hpp"
#include "gecos/media/registration.hpp"
#include "gecos/media/shm/directory.hpp"

namespace gecos::media {
namespace {

constexpr std::array kinds{
#define GECOS_KIND(kind, name) Kind::kind,
    GECOS_MEDIA(GECOS_KIND)
#undef GECOS_KIND
};

const Registration& registration_of(Kind kind) {
  static constexpr std::array<const Registration*, kinds.size()> all{
#define GECOS_REGISTRATION(kind, name) &name##_registration,
      GECOS_MEDIA(GECOS_REGISTRATION)
#undef GECOS_REGISTRATION
  };
  return *all.at(static_cast<std::size_t>(kind));
}

/// Returns the part of a host identity that identifies the machine: the boot id. Returns an empty
/// text if `identity` has no boot id. Also returns an empty text if `identity` has spaces before
/// the '/', because an older program sends an error text in place of its identity.
std::string_view boot_of(std::string_view identity) {
  const std::string_view boot = identity.substr(0, identity.find('/'));
  return boot.size() == identity.size() || boot.find(' ') != boot.npos ? std::string_view() : boot;
}

}  // namespace

std::string_view to_string(Kind kind) { return registration_of(kind).capabilities.name; }

std::optional<Kind> kind_from(std::string_view name) {
  const auto found = std::ranges::find(kinds, name, to_string);
  return found == kinds.end() ? std::nullopt : std::optional(*found);
}

std::optional<Kind> kind_of(std::string_view address) {
  return kind_from(address.substr(0, address.find(':')));
}

std::span<const Kind> all_kinds() { return kinds; }

std::span<const std::string_view> all_names() {
  static const auto names = [] {
    std::array<std::string_view, kinds.size()> all;
    std::ranges::transform(kinds, all.begin(), to_string);
    return all;
  }();
  return names;
}

Reach reach_of(Kind kind) { return registration_of(kind).capabilities.reach; }

bool within_process(std::span<const Kind> kinds) {
  return !kinds.empty() &&
         std::ranges::all_of(kinds, [](Kind kind) { return reach_of(kind) == Reach::Process; });
}

tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap) {
  static const SystemClock clock;
  auto opened = registration_of(kind).open();
  if (!opened) return opened;
  return with_layers(wrap ? wrap(std::move(*opened)) : std::move(*opened), clock);
}

std::unique_ptr<Medium> with_layers(std::unique_ptr<Medium> medium, const Clock& clock) {
  if (!medium->capabilities().intact) medium = make_checked(std::move(medium));
  if (medium->capabilities().largest_packet < largest_transfer) {
    medium = make_fragmented(std::move(medium), clock);
  }
  return medium;
}

std::string runtime_directory() {
  std::string directory = shm::default_runtime_directory();
  return shm::prepare_directory(directory) ? directory : std::string();
}

std::string host_identity() {
  std::string boot = shm::kernel_boot();
  if (boot.empty()) return boot;
  const auto directory = shm::directory_identity(shm::default_runtime_directory());
  return std::move(boot) + "/" + directory.value_or("");
}

bool open_to_this_user(std::string_view identity) {
  const std::string boot = shm::kernel_boot();
  const auto directories = shm::directories_of_the_host(shm::default_runtime_directory());
  return std::ranges::any_of(directories, [&](const std::string& directory) {
    return share_memory(boot + "/" + shm::inode_of(directory), identity);
  });
}

bool open_to_other_users() { return shm::open_to_all_users(shm::default_runtime_directory()); }

bool serves_all_users(std::string_view user) { return shm::serves_the_host(user); }

bool share_memory(std::string_view one, std::string_view other) {
  return one == other && !boot_of(one).empty() && !one.ends_with('/');
}

bool on_one_machine(std::string_view one, std::string_view other) {
  return !boot_of(one).empty() && boot_of(one) == boot_of(other);
}

}  // namespace gecos::media
