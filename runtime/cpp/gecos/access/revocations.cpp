#include "gecos/access/revocations.hpp"

#include <algorithm>

namespace gecos::access {
namespace {

constexpr std::size_t key_digits = 64;
constexpr std::string_view empty_member = "-";

bool is_key(std::string_view text) {
  return text.size() == key_digits &&
         text.find_first_not_of("0123456789abcdef") == std::string_view::npos;
}

}  // namespace

tl::expected<std::vector<RevokedUser>, std::string> read_revocations(std::string_view text) {
  std::vector<RevokedUser> list;
  for (int number = 1; !text.empty(); ++number) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    const std::size_t blank = line.find(' ');
    const std::string_view key = line.substr(0, blank);
    const std::string_view owner =
        blank == std::string_view::npos ? std::string_view() : line.substr(blank + 1);
    const bool any_key = key == empty_member, any_owner = owner == empty_member;
    if ((!any_key && !is_key(key)) || owner.empty() || (any_key && any_owner)) {
      return tl::unexpected(
          "line " + std::to_string(number) +
          " must be a key of 64 hexadecimal digits, a blank and the owner of the key");
    }
    list.push_back({any_key ? "" : std::string(key), any_owner ? "" : std::string(owner)});
  }
  return list;
}

/// FNV-1a of 64 bits.
std::uint64_t number_of_revocations(std::string_view text) {
  if (text.empty()) return 0;
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const char letter : text) {
    hash = (hash ^ static_cast<unsigned char>(letter)) * 0x100000001b3u;
  }
  return std::max<std::uint64_t>(hash, 1);
}

bool revokes(const std::vector<RevokedUser>& list, std::string_view key, const UserAtHost& who) {
  return std::ranges::any_of(list, [&](const RevokedUser& one) {
    if (!one.key.empty()) return one.key == key;
    return !who.user.empty() && (one.owner == who.user || one.owner == who.user + "@" + who.host);
  });
}

}  // namespace gecos::access
