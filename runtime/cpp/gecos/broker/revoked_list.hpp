#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "gecos/access/revocations.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/file_thread.hpp"
#include "gecos/base/result.hpp"

namespace gecos::broker {

/// The file `revoked` in the key folder of the broker's user (access/revocations.hpp), which `gecos
/// revoke` writes. A separate thread reads the file, because the file system may not answer.
/// Thread-safe.
class RevokedList {
 public:
  /// @param path the path of the file, which need not exist; empty: the file `revoked` in the key
  /// folder of this user
  explicit RevokedList(const std::string& path = "");

  struct Found {
    std::uint64_t number = 0;  ///< access::number_of_revocations
    std::vector<access::RevokedUser> revoked{};
  };
  using Reading = tl::expected<std::shared_ptr<const Found>, std::string>;
  /// Reads the file and returns the list in it. Fails when the file has an error, when other users
  /// may write to the file, and when the file system has not answered within 250 ms.
  Reading read();

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  FileThread thread_;
};

}  // namespace gecos::broker
