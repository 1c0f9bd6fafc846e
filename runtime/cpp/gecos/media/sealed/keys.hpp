#pragma once

#include <memory>
#include <string>

#include "gecos/crypto/key_directory.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The key of the user of this program, and the keys that the user admits. The connections of a
/// medium share this object, and the object may live longer than the medium. Any thread may use
/// this object.
struct SealedKeys {
  crypto::KeyDirectory directory;
  crypto::Identity own;

  /// Opens the key directory `path`, or the user's default key directory if `path` is empty.
  /// Creates the directory and the user's key if they do not exist.
  static tl::expected<std::shared_ptr<const SealedKeys>, MediumError> open(const std::string& path);

  bool admits(const crypto::PublicKey& key) const { return directory.is_admitted(key); }
};

}  // namespace gecos::media
