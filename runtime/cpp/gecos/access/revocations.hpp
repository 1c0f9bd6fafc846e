#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/result.hpp"

/// The list of the users whom a laboratory has revoked. The user of the broker keeps the list as a
/// file, which `gecos revoke` writes; the broker sends the list to all servers.
namespace gecos::access {

/// A user, or one key of a user, who may not connect any more.
struct RevokedUser {
  std::string key;    ///< 64 hexadecimal digits; empty: every key of `owner`
  std::string owner;  ///< "anna@desk", or "anna" for all hosts; empty: all who have `key`
  friend bool operator==(const RevokedUser&, const RevokedUser&) = default;
};

/// The largest size in bytes of a file of revocations. A file of this size has room for some 8,000
/// revocations.
inline constexpr std::size_t largest_revocation_file = 1 << 20;

/// Reads the text of a file of revocations. Each line has a key and an owner, with a blank between
/// them; "-" stands for an empty key or owner. The error names the line.
tl::expected<std::vector<RevokedUser>, std::string> read_revocations(std::string_view text);

/// Returns a hash of `text`, the contents of a file of revocations; 0 for an empty text.
std::uint64_t number_of_revocations(std::string_view text);

/// Returns whether `list` revokes a client. `key`: the key that the client has proved; empty if the
/// kernel names the user. `who`: the user and the host of the client; both are empty for a key
/// without an owner.
bool revokes(const std::vector<RevokedUser>& list, std::string_view key, const UserAtHost& who);

}  // namespace gecos::access
