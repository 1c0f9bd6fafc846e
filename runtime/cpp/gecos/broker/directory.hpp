#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// Whether a server runs on the broker's host.
enum class Host : std::uint8_t {
  Other,
  /// The server runs on the broker's host. When its process ends, Directory::process_ended is
  /// called.
  Same,
};

/// A server's claim to the name of an object.
struct Claim {
  std::uint64_t session = 0;
  std::uint64_t incarnation = 0;  ///< incarnation of the server process, as its session reports
  Duration served_for{};          ///< how long the object has been served
  Host host = Host::Other;
  /// How long ago the server last asked for the name and got a final answer; nullopt: never.
  std::optional<Duration> confirmed_ago = std::nullopt;
};

/// An object whose server fell silent without withdrawing the object.
struct Silent {
  Entry entry;
  TimePoint since;  ///< when the server was heard last
  std::uint64_t epoch = 0;
  Host host = Host::Other;
  bool certain = true;    ///< see `Directory::of_this_host`
  bool expected = false;  ///< see `Directory::expect`; the object is not listed as silent yet
};

struct DirectoryOptions {
  /// The time after the broker's start during which its answers to claims are provisional: a server
  /// with a better claim may still get the name.
  Duration young = std::chrono::seconds(1);
  /// The time for which a silent server of another host keeps its name.
  Duration name_hold = std::chrono::seconds(10);
  std::uint64_t life = 0;  ///< a number that no other directory has
};

/// The known objects, each with the session that enlisted it. Does no I/O. Not thread-safe.
///
/// Within the time `young` after the broker's start, servers register the objects that they served
/// before. If several such objects have one name, the object whose name a broker confirmed last
/// gets the name, because the broker before gave it the name of the others. Of objects that were
/// never confirmed, the one that has been served longest gets the name, if it was served before the
/// broker started.
/// During `young` the answer to a claim is provisional. After `young` a name stays with its object,
/// whether its server has asked again or not.
///
/// A registration ends with the session that made it. If the server has not withdrawn the object,
/// the object is then silent, and no other server gets its name until `free` is called. Without
/// that call, a server on the broker's host keeps the name until its process has ended, and a
/// server on another host for `name_hold`. The names of objects that are expected to return from
/// the previous broker (`expect`) are kept in the same way.
///
/// Each change has a number, and the last `most_changes` are kept, so that a watcher sees each
/// change once. All moments are read from CLOCK_BOOTTIME.
class Directory {
 public:
  static constexpr Duration remembered = std::chrono::hours(1);
  /// The maximum number of silent objects that are remembered after their names became free.
  static constexpr std::size_t most_silent = 256;
  static constexpr std::size_t most_changes = 1024;
  /// An expected server that has not returned within this time after the broker's start counts as
  /// silent. Watchers wait longer before they report it as gone
  /// (`ListView::servers_return_within`).
  static constexpr Duration servers_return_within = std::chrono::seconds(2);

  explicit Directory(TimePoint started, const DirectoryOptions& options = {})
      : started_(started), settled_(started + options.young), options_(options) {}

  /// Keeps the name of `entry` for its server. The server was registered with the previous broker,
  /// and its process lives on the broker's host. Must be called before the first claim.
  void expect(const Entry& entry);
  /// Adds `entry` for the session of `claim`. The same incarnation of a server may enlist an entry
  /// again in a new session, even before the directory knows that its previous session has ended.
  /// Fails when another entry keeps the name. Returns how long the answer is still provisional; 0
  /// when the answer is final.
  tl::expected<Duration, NameTaken> enlist(const Claim& claim, const Entry& entry, TimePoint now);
  /// Removes an object. Only the session that enlisted the object may remove it.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Marks as silent all objects that the session has enlisted, and returns the names of these
  /// objects. `heard` is the time of the last sign of life of the server.
  std::vector<std::string> end_session(std::uint64_t session, TimePoint heard);
  /// Returns true when the session enlisted the object and still has the name.
  bool has(std::uint64_t session, const std::string& name) const;
  /// Returns the names of the objects for whose sessions `applies` returns true, in the order of
  /// names.
  std::vector<std::string> names_of(
      const std::function<bool(std::uint64_t session)>& applies) const;
  /// Returns true when the session enlisted an object whose process is on the broker's host.
  bool is_of_this_host(std::uint64_t session) const;
  /// Called when the process `pid` of the broker's host has ended. Removes the objects of that
  /// process, and returns their names.
  std::vector<std::string> process_ended(std::int32_t pid);
  /// Frees the name of a silent object. Fails when the directory does not have the name, when the
  /// server of the object is heard, and when the process of the server lives on the broker's host.
  tl::expected<void, std::variant<UnknownName, NameInUse>> free(const std::string& name);
  /// Marks the expected servers that have not returned in time as silent. Forgets the objects whose
  /// names are free and that have been silent for longer than `remembered`. Keeps at most
  /// `most_silent` silent objects whose names are free, namely the objects that were heard last.
  /// Returns the time at which this function must be called again: at the latest the end of
  /// `young`, at which names become certain, if that is not over.
  TimePoint on_tick(TimePoint now);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  /// Returns the objects that have the interface, or an interface derived from it, sorted by name.
  std::vector<Entry> query(std::string_view interface_name) const;
  /// Returns the silent objects whose name is kept or that were heard within `remembered`, sorted
  /// by name. Leaves out the objects that are still expected (`expect`).
  std::vector<Silent> silent(TimePoint now) const;

  /// Returns how long the server of a silent object keeps the name; nullopt: until its process
  /// ends.
  std::optional<Duration> free_in(const Silent& one, TimePoint now) const;

  ListRevision revision() const { return {options_.life, number_}; }
  /// Returns the changes after `since`, or the whole list when some of these changes are no longer
  /// kept.
  ListChanges changes(const ListRevision& since, TimePoint now) const;
  /// Returns whether the name belongs to an online object, or is kept for a silent object.
  bool keeps_name(const std::string& name, TimePoint now) const;
  /// Returns whether the process `pid` of the broker's host has an object, online or silent.
  bool uses_process(std::int32_t pid) const;
  /// Returns whether the time `young` is over, so that each name stays with its object.
  bool has_settled(TimePoint now) const { return now >= settled_; }
  /// Returns the objects, online or silent, whose processes are on the broker's host. The next
  /// broker keeps their names. During `young` leaves out the names that are not certain: no broker
  /// before this one is known to have had the name for the server.
  std::vector<Entry> of_this_host(TimePoint now) const;

 private:
  /// What decides, soon after the broker's start, which of two objects gets a name.
  struct Standing {
    TimePoint since;                     ///< when the server began to serve the object
    std::optional<TimePoint> confirmed;  ///< when a broker last confirmed the name

    bool outranks(const Standing& other) const;
  };
  struct Place {
    std::uint64_t session = 0;
    Entry entry;
    Standing standing;
    std::vector<Entry> displaced{};  ///< entries that lost this name and cannot get it back
    std::uint64_t epoch = 0;
    Host host = Host::Other;
    bool certain = true;  ///< see `of_this_host`
  };
  struct Change {
    Registration what;  ///< the change; the member `silent_for` is not set
    TimePoint heard;    ///< when the server of a silent object was heard last
  };

  bool gives_way(const Place& place, const Entry& entry, const Standing& claimed,
                 TimePoint now) const;
  UnknownName unknown(const std::string& name) const;
  void forget_most(TimePoint now);
  /// Records a change of the list under the next number. Returns the epoch of the object: `epoch`,
  /// or the number of the change if `epoch` is 0.
  std::uint64_t note(const Entry& entry, Presence presence, std::uint64_t epoch,
                     TimePoint heard = {});

  TimePoint started_;
  TimePoint settled_;
  DirectoryOptions options_;
  std::map<std::string, Place> places_;
  std::map<std::string, Silent> silent_;
  std::deque<Change> changes_;
  std::uint64_t number_ = 0;  ///< the number of the last change
};

}  // namespace gecos::broker
