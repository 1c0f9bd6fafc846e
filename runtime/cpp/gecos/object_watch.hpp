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
/// "robcl::Manipulator") or an interface derived from it, sorted by name; all objects if
/// `interface_name` is empty. On failure returns a text that says why the broker gave no answer.
tl::expected<std::vector<Entry>, std::string> find_objects(
    const Lab& lab, std::string_view interface_name = {},
    Duration patience = std::chrono::seconds(2));

/// Reports which objects come online, which fall silent, and which are gone. Reports each change
/// once, even if the broker is restarted meanwhile. Not thread-safe.
class ObjectWatch {
 public:
  /// Watches the objects that have the interface `interface_name` or an interface derived from it;
  /// all objects if `interface_name` is empty. Does not connect yet.
  explicit ObjectWatch(const Lab& lab, std::string interface_name = {});
  ~ObjectWatch();
  ObjectWatch(const ObjectWatch&) = delete;
  ObjectWatch& operator=(const ObjectWatch&) = delete;

  /// Waits at most `patience` for the next change, or 2 s longer if the broker does not answer.
  /// Returns the change; nullopt when there was none. The first calls return each object that is
  /// already online or silent. While no broker answers, there are no changes, because the objects
  /// continue to run. After the Lab was closed, returns nullopt at once.
  std::optional<Registration> next(Duration patience);

  /// Returns the number of changes that this watch did not report, because the broker keeps only
  /// the last 1024 changes and the watch asked for changes too late. The watch reported only the
  /// state after these changes.
  std::uint64_t skipped() const;
  /// Returns true when the Lab was closed.
  bool closed() const;

 private:
  class Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gecos
