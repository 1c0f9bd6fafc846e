#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gecos/access/visitors.hpp"
#include "gecos/broker/directory.hpp"

namespace gecos::broker {

/// The part of the directory that one client may see. A visitor sees only the objects whose
/// programs admit this visitor; any other client sees all objects. Not thread-safe; a View lives
/// only during one call.
class View {
 public:
  /// `visitor`: the user of the client if the client is a visitor; otherwise no value.
  View(const Directory& directory, const access::VisitorBook& book,
       const std::optional<access::UserAtHost>& visitor)
      : directory_(directory) {
    if (visitor) seen_ = book.seen_by(*visitor);
  }

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  std::vector<Entry> query(std::string_view interface_name) const;
  std::vector<Silent> silent(TimePoint now) const;
  /// Returns the revision of the list that this client sees. For a visitor, the member `life`
  /// changes whenever the set of objects that this visitor may see changes. The visitor then gets
  /// the whole list again, without the objects that are hidden now.
  ListRevision revision() const;
  /// Returns the changes that this client may see. A visitor gets no change that is older than the
  /// lists that name this visitor.
  ListChanges changes(const ListRevision& since, TimePoint now) const;

 private:
  bool hidden(const std::string& name) const { return seen_ && !seen_->objects.contains(name); }
  bool hides(const Entry& one) const { return hidden(one.name); }

  const Directory& directory_;
  std::optional<access::VisitorBook::Seen> seen_;  ///< no value: the client may see all objects
};

}  // namespace gecos::broker
