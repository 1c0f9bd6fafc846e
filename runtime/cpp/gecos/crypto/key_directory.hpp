#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"

namespace gecos::crypto {

struct KeyError {
  std::string text;      ///< what is wrong, with which file, and what to do
  bool passing = false;  ///< no descriptor or memory was left: this says nothing about a key
};

/// The user to whom a key belongs, and the host on which that user has it. Only the user who has
/// the key directory decides this; the claims of a peer have no influence.
struct KeyOwner {
  static constexpr std::size_t longest = 255;  ///< characters of "user@host"
  std::string user;
  std::string host;

  /// Reads a text such as "anna@desk". Returns nullopt when it is not of this form, or has blanks,
  /// quotes, asterisks, control characters or characters that are not ASCII.
  static std::optional<KeyOwner> parse(std::string_view text);
  friend bool operator==(const KeyOwner&, const KeyOwner&) = default;
};

/// The directory with a user's keys. No other part of gecos/crypto reads or writes files.
/// Thread-safe. The directory has three kinds of files:
///
///     own.secret              this user's secret key, created at first use and never sent
///     <64 hex digits>.public  the public key of an admitted user; its name is the key
///     <64 hex digits>.owner   the owner of that key, such as "anna@desk"; may be missing
///
/// Only the user may access the directory (mode 0700) and its files (mode 0600). Only a .public
/// file and a .owner file may also have permissions for other users to read it. A user who has the
/// same home directory on several hosts has one key. To let two users connect, each user adds the
/// .public file of the other user, with the name of its owner, by `gecos keys add FILE USER@HOST`.
/// A key without a .owner file counts as another key of this user, and no list of users excludes
/// this user.
class KeyDirectory {
 public:
  /// Returns the path of the user's key directory: $GECOS_KEY_DIR if that variable is set, else
  /// $XDG_CONFIG_HOME/gecos/keys, else ~/.config/gecos/keys.
  static std::string default_path();

  /// Opens the key directory `path`, and creates it when it does not exist. Fails when other users
  /// may access the directory, or when it cannot be created.
  static tl::expected<KeyDirectory, KeyError> open(std::string path = default_path());

  const std::string& path() const { return path_; }

  /// Returns the user's own keys, and creates them when there are none. Processes that create the
  /// keys at the same time all get the same keys. Fails when the key file is damaged, when other
  /// users may access it, or when it cannot be written. Never replaces a damaged file, because
  /// other users may have admitted its key.
  tl::expected<Identity, KeyError> identity() const;

  /// Checks that the user admits the key `key` now. Fails when the directory has no file for `key`,
  /// when the file is damaged or holds another key, when other users may write it, or when it has
  /// an owner that cannot be read.
  tl::expected<void, KeyError> admission(const PublicKey& key) const;
  /// Returns the owner of `key`, as the .owner file of `key` states it. Returns nullopt when there
  /// is no such file. Fails when the file cannot be read, when it does not name an owner, or when
  /// other users may write it.
  tl::expected<std::optional<KeyOwner>, KeyError> owner(const PublicKey& key) const;
  bool is_admitted(const PublicKey& key) const { return admission(key).has_value(); }

 private:
  explicit KeyDirectory(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace gecos::crypto
