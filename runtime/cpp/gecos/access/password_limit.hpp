#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

#include "gecos/base/clock.hpp"

namespace gecos::access {

/// Limits how many wrong passwords each user may give for one object, so that nobody finds a
/// password by trying many. The caller passes the current time. Reads no clock.
class PasswordLimit {
 public:
  static constexpr std::size_t most_wrong = 5;
  static constexpr Duration within = std::chrono::minutes(1);

  /// Returns how long `user` must wait before the next password of this user is compared; zero when
  /// no wait is needed.
  Duration wait(const std::string& user, TimePoint now) const;
  /// Must be called when `user` has given a wrong password.
  void count_wrong(const std::string& user, TimePoint now);

 private:
  /// For each user, the times at which the latest wrong passwords were given, at most `most_wrong`,
  /// oldest first.
  std::map<std::string, std::vector<TimePoint>> wrong_;
};

}  // namespace gecos::access
