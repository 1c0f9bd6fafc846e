#pragma once

#include <string>

#include "gecos/base/result.hpp"
#include "gecos/crypto/keys.hpp"

namespace gecos::crypto {

struct KeyError {
  std::string text;  ///< what is wrong, with which file, and what to do
};

/// A user's keys, as files. The only part of this room that does I/O; any thread.
///
///     own.secret            this user's secret key, made on first use and never sent anywhere
///     <64 hex digits>.public  somebody who is admitted: the file is named after the key that it
///     holds
///
/// The directory is the user's alone (0700), and so are its files (0600; a .public one may be
/// read). A user with one home on several hosts has one key. For another, copy its .public file
/// here, and ours there.
class KeyDirectory {
 public:
  /// $GECOS_KEY_DIR, else $XDG_CONFIG_HOME/gecos/keys, else ~/.config/gecos/keys.
  static std::string default_path();

  /// Makes the directory when there is none. Fails when it is not ours alone or cannot be made.
  static tl::expected<KeyDirectory, KeyError> open(std::string path = default_path());

  const std::string& path() const { return path_; }

  /// The user's own keys, made when there are none. Of several processes that make them at once all
  /// get the same. Fails when the file is damaged, open to others or cannot be written; a damaged
  /// one is never replaced, since others may have admitted its key.
  tl::expected<Identity, KeyError> identity() const;

  /// Fails when no file of that key lies here now, or what lies here is damaged, holds another key
  /// or is open to others.
  tl::expected<void, KeyError> admission(const PublicKey& key) const;
  bool is_admitted(const PublicKey& key) const { return admission(key).has_value(); }

 private:
  explicit KeyDirectory(std::string path) : path_(std::move(path)) {}

  std::string path_;
};

}  // namespace gecos::crypto
