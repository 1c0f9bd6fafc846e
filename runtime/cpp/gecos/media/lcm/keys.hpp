#pragma once

#include <memory>
#include <mutex>
#include <string>

#include "gecos/crypto/key_directory.hpp"
#include "gecos/media/medium.hpp"

namespace gecos::media {

/// Who this program is on lcm, and whom it lets in. What is opened once by a medium outlives it
/// with those who share it. Any thread.
struct LcmKeys {
  crypto::KeyDirectory directory;
  crypto::Identity own;

  /// Reads, or makes, the keys in `path`; empty: the user's usual place.
  static tl::expected<std::shared_ptr<const LcmKeys>, MediumError> open(const std::string& path);

  bool admits(const crypto::PublicKey& key) const { return directory.is_admitted(key); }
};

}  // namespace gecos::media
