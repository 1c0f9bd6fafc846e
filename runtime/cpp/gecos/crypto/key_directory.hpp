#pragma once

#include <string>

#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"

namespace gecos::crypto {

struct KeyError {
  std::string text;  ///< what is wrong, with which file, and what to do
};

/// A user's keys, stored as files. The only part of gecos/crypto that does I/O. Thread-safe.
///
///     own.secret              this user's secret key, created at first use and never sent
///     <64 hex digits>.public  the public key of an admitted user; its name is the key
///
/// Only the user may access the directory (0700) and its files (0600; others may read a .public
/// file). A user with the same home directory on several hosts has one key. To connect with another
/// user, copy that user's .public file here, and this user's .public file there.
class KeyDirectory {
 public:
  /// $GECOS_KEY_DIR, else $XDG_CONFIG_HOME/gecos/keys, else ~/.config/gecos/keys.
  static std::string default_path();

  /// Creates the directory when there is none. Fails when other users may access the directory or
  /// it cannot be created.
  static tl::expected<KeyDirectory, KeyError> open(std::string path = default_path());

  const std::string& path() const { return path_; }

  /// The user's own keys, created when there are none. Processes that create them at the same time
  /// all get the same keys. Fails when the file is damaged, open to other users or cannot be
  /// written. A damaged file is never replaced, because other users may have admitted its key.
  tl::expected<Identity, KeyError> identity() const;

  /// Checks that `key` is admitted now. Fails when the directory has no file for `key`, or the file
  /// is damaged, holds another key or is open to other users.
  tl::expected<void, KeyError> admission(const PublicKey& key) const;
  bool is_admitted(const PublicKey& key) const { return admission(key).has_value(); }

 private:
  explicit KeyDirectory(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace gecos::crypto
