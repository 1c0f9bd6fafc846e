#pragma once

#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/lab.hpp"

namespace gecos::session {

class ObjectHost;
class Runtime;

/// Reads from a zone (idl/gecos/presence.gidl) whether a person is present, and tells the objects
/// of a server that are in the zone. While the zone cannot be reached, tells the objects the
/// reason. Uses sessions of its own with the broker and the zone. These sessions stay open when the
/// program closes its Lab.
class ZoneWatch {
 public:
  ZoneWatch(std::shared_ptr<Runtime> runtime, std::string zone);
  ~ZoneWatch();
  ZoneWatch(const ZoneWatch&) = delete;
  ZoneWatch& operator=(const ZoneWatch&) = delete;

  const std::string& zone() const { return zone_; }
  void add(const std::shared_ptr<ObjectHost>& object);
  void remove(const ObjectHost& object);

 private:
  void run();
  /// Until the session with the zone ends, tells the objects what the samples of `presence` say.
  void follow(StreamCore& presence);
  void tell_unknown(const std::string& why);
  /// Calls `tell` for each object that still exists.
  template <class Tell>
  void each(Tell tell);
  /// Returns false when the watch has ended or has no objects.
  bool watches();
  /// Sleeps while the watch has no objects. Returns false when the watch ends.
  bool await_object();
  /// Sleeps for a while before the next attempt. Returns false when the watch ends.
  bool rest();

  const std::string zone_;
  const LabOrWhyNot lab_;
  Mutex mutex_;
  ConditionVariable changed_;
  std::vector<std::weak_ptr<ObjectHost>> objects_ GECOS_GUARDED_BY(mutex_);
  bool ended_ GECOS_GUARDED_BY(mutex_) = false;
  std::thread thread_;  ///< own thread, because the search for a zone blocks
};

/// The watches of all zones in which one server has objects. Not thread-safe.
class ZoneWatches {
 public:
  explicit ZoneWatches(std::shared_ptr<Runtime> runtime) : runtime_(std::move(runtime)) {}

  /// From now on tells `object` whether a person is present in `zone`, and no longer what other
  /// zones report. If no thread can be created, throws an exception and changes nothing.
  void add(const std::string& zone, const std::shared_ptr<ObjectHost>& object);
  void end() { watches_.clear(); }

 private:
  const std::shared_ptr<Runtime> runtime_;
  std::vector<std::unique_ptr<ZoneWatch>> watches_;
};

}  // namespace gecos::session
