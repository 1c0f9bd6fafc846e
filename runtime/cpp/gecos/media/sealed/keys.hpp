#pragma once

#include <memory>
#include <string>

#include "gecos/crypto/key_directory.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The key of this program, and the keys that it admits. Connections share the keys, which may
/// outlive the medium that opened them. Any thread.
struct SealedKeys {
  crypto::KeyDirectory directory;
  crypto::Identity own;

  /// Reads the keys in the directory `path`, or makes them. Empty: the user's default key
  /// directory.
  static tl::expected<std::shared_ptr<const SealedKeys>, MediumError> open(const std::string& path);

  bool admits(const crypto::PublicKey& key) const { return directory.is_admitted(key); }
};

}  // namespace gecos::media
