#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl

namespace gecos::session {

/// A watcher's copy of the broker's list. Turns the answers of the broker into changes. Returns
/// each change once, even if the broker was restarted and its servers register again. Does no I/O
/// and reads no clock.
class ListView {
 public:
  /// After the start of a new broker, each running server registers with this broker within this
  /// time: the server learns within 1.3 s that its old broker is gone, and then searches every 200
  /// ms.
  static constexpr Duration servers_return_within = std::chrono::milliseconds(2500);

  /// The view contains only the objects that have the interface `interface_name`, or an interface
  /// derived from it. If `interface_name` is empty, the view contains all objects.
  explicit ListView(std::string interface_name = {}) : interface_name_(std::move(interface_name)) {}

  /// The revision up to which this view is complete.
  const ListRevision& revision() const { return revision_; }
  /// Takes over the broker's answer to a request for the changes since `revision()`. Returns the
  /// changes that are new. If an object is missing in the list of a new broker, it is reported as
  /// gone only after its server has had enough time to register again.
  std::vector<Registration> take(const ListChanges& answer, TimePoint now);
  /// Reports the objects whose servers have not returned in time as gone, and returns these
  /// changes.
  std::vector<Registration> missing(TimePoint now);
  /// The time at which `missing` must be called next; nullopt if no server is expected to return.
  std::optional<TimePoint> next_check() const;
  /// Number of changes that the broker no longer kept when this view asked for them. The view
  /// contains the result of these changes, but has not reported each of them.
  std::uint64_t skipped() const { return skipped_; }

 private:
  bool watched(const Registration& one) const;
  /// Updates the view with `one`, the present state of one object. If that changes the view, adds
  /// the change to `news`.
  void put(const Registration& one, std::vector<Registration>& news);

  const std::string interface_name_;
  ListRevision revision_;
  std::uint64_t skipped_ = 0;
  std::map<std::string, Registration> known_;  ///< online or silent
  /// For names in `known_`: the time by which the server must have registered again.
  std::map<std::string, TimePoint> expected_back_by_;
};

}  // namespace gecos::session
