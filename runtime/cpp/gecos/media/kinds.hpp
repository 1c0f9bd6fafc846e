#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gecos/media/medium.hpp"

/// The list of the media of this library, for code that opens a medium by its name and must not
/// know how the medium works.
namespace gecos::media {

/// The list of all media; the medium with the shortest reach comes first. Each line has the
/// enumerator of a medium and the name of the medium, which is also the name of its folder. To add
/// a medium, add its folder and one line here (see registration.hpp). Other code must check the
/// Capabilities, not the enumerator.
#define GECOS_MEDIA(MEDIUM) \
  MEDIUM(Inproc, inproc)    \
  MEDIUM(Shm, shm)          \
  MEDIUM(Lcm, lcm)

enum class Kind : std::uint8_t {
#define GECOS_ENUMERATOR(kind, name) kind,
  GECOS_MEDIA(GECOS_ENUMERATOR)
#undef GECOS_ENUMERATOR
};

std::string_view to_string(Kind kind);
std::optional<Kind> kind_from(std::string_view name);
/// Returns the medium of an address, which is the name before the first ':'.
std::optional<Kind> kind_of(std::string_view address);
std::span<const Kind> all_kinds();
/// Returns the names of all media, in the order of all_kinds().
std::span<const std::string_view> all_names();
Reach reach_of(Kind kind);
/// Returns whether `kinds` is not empty and has only media that stay within this process.
bool within_process(std::span<const Kind> kinds);

/// A function that wraps a medium: it takes a medium and returns the medium to use in its place.
using WrapMedium = std::function<std::unique_ptr<Medium>(std::unique_ptr<Medium>)>;

/// Opens the medium `kind` with its usual settings and with the layers that it needs. Returns an
/// error when the medium cannot be used here. If `wrap` is set, it wraps the medium below these
/// layers.
tl::expected<std::unique_ptr<Medium>, MediumError> open(Kind kind, const WrapMedium& wrap = {});

/// Wraps `medium` in the layers that its capabilities require: in checksums if packets may be
/// damaged, and in fragmentation if the session's largest packet does not fit.
std::unique_ptr<Medium> with_layers(std::unique_ptr<Medium> medium, const Clock& clock);

/// Returns the directory with the sockets of this user's programs. Returns an empty text when no
/// directory can be used.
std::string runtime_directory();

/// Returns a text that identifies this host and its runtime directory: the boot id of the kernel,
/// '/', and the inode of the directory. The inode is left out when shm cannot be used here. The
/// text is empty when the kernel does not publish a boot id. Use only the functions below to
/// compare these texts.
std::string host_identity();

/// Returns whether this program can reach a server with the host identity `identity` over shm
/// although the server runs as another user. The server must be on this host, and its runtime
/// directory must be open to all users.
bool open_to_this_user(std::string_view identity);

/// Returns whether programs of other users can reach the servers of this program over shm. They can
/// if this program runs as root or as `gecos`, and its runtime directory is open to all users.
bool open_to_other_users();

/// The words by which error texts name the servers that programs of all users can reach over shm
/// (see serves_all_users).
inline constexpr std::string_view servers_of_all_users = "servers of root and of gecos";

/// Returns whether `user` is one of the users whose servers can be open to the programs of all
/// users: root or `gecos`.
bool serves_all_users(std::string_view user);

/// Returns whether programs with these host identities can reach each other over shm. They can if
/// they have the same runtime directory.
bool share_memory(std::string_view one, std::string_view other);

/// Returns whether two host identities belong to the same machine. Their runtime directories may
/// differ. Returns false when an identity is not known.
bool on_one_machine(std::string_view one, std::string_view other);

}  // namespace gecos::media
