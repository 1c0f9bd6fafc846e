#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "gecos/crypto/key_directory.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The key of this program, and the keys that it admits. Shared: outlives the medium that opened
/// it. Any thread.
struct SealedKeys {
  crypto::KeyDirectory directory;
  crypto::Identity own;

  /// Reads, or makes, the keys in `path`; empty: the user's usual place.
  static tl::expected<std::shared_ptr<const SealedKeys>, MediumError> open(const std::string& path);

  bool admits(const crypto::PublicKey& key) const { return directory.is_admitted(key); }
};

}  // namespace gecos::media
