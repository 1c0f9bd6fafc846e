#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/lab.hpp"

namespace gecos {

/// Returns the objects online that have the interface `interface_name` (for example
/// "robcl::Manipulator") or an interface derived from it, sorted by name; all objects if it is
/// empty. On failure returns a text that says why the broker gave no answer.
tl::expected<std::vector<Entry>, std::string> find_objects(
    const Lab& lab, std::string_view interface_name = {},
    Duration patience = std::chrono::seconds(2));

/// Reports which objects come online, fall silent and go. Reports each change once, even if the
/// broker is restarted meanwhile. Not thread-safe.
class ObjectWatch {
 public:
  /// Watches the objects that have the interface `interface_name` or an interface derived from it;
  /// all objects if it is empty. Does not connect yet.
  explicit ObjectWatch(const Lab& lab, std::string interface_name = {});
  ~ObjectWatch();
  ObjectWatch(const ObjectWatch&) = delete;
  ObjectWatch& operator=(const ObjectWatch&) = delete;

  /// Returns the next change, and waits for it at most `patience`, or 2 s longer if the broker does
  /// not answer. At first returns each object that is online or silent already. While no broker
  /// answers, there are no changes: the objects continue to run. After the Lab was closed, returns
  /// nullopt at once.
  std::optional<Registration> next(Duration patience);

  /// Returns the number of changes that this watch read too late: the broker keeps only the last
  /// 1024. The watch did not report each of these changes, but it reported the state that they led
  /// to.
  std::uint64_t skipped() const;
  /// Returns true when the Lab was closed.
  bool closed() const;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gecos
