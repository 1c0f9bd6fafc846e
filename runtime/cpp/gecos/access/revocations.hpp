#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/result.hpp"

/// The list of the users whom a laboratory has revoked. The user of the broker keeps the list as a
/// file, which `gecos revoke` writes; the broker tells it to all servers.
namespace gecos::access {

/// A user, or one key of a user, who may not connect any more.
struct RevokedUser {
  std::string key;    ///< 64 hexadecimal digits; empty: every key of `owner`
  std::string owner;  ///< "anna@desk", or "anna" for all hosts; empty: all who have `key`
  friend bool operator==(const RevokedUser&, const RevokedUser&) = default;
};

/// The largest file that is read. It has room for some 8,000 revocations.
inline constexpr std::size_t largest_revocation_file = 1 << 20;

/// Reads the text of the file. Each line has a key and an owner, with a blank between them; "-"
/// stands for a member that is empty. The error names the line.
tl::expected<std::vector<RevokedUser>, std::string> read_revocations(std::string_view text);

/// Returns the number of the list in `text`: equal for equal texts, and 0 for the empty one.
std::uint64_t number_of_revocations(std::string_view text);

/// Returns whether `list` revokes a client. `key`: the key that the client has proved; empty if the
/// kernel names its user. `who`: its user and host; both are empty for a key without an owner.
bool revokes(const std::vector<RevokedUser>& list, std::string_view key, const UserAtHost& who);

}  // namespace gecos::access
