#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gecos/access/visitors.hpp"
#include "gecos/broker/directory.hpp"

namespace gecos::broker {

/// What one client sees of the directory: a visitor only the objects whose programs admit the
/// visitor, any other client everything. Not thread-safe: lives only during one call.
class View {
 public:
  /// `visitor`: no value if the client is no visitor.
  View(const Directory& directory, const access::VisitorBook& book,
       const std::optional<access::UserAtHost>& visitor)
      : directory_(directory) {
    if (visitor) seen_ = book.seen_by(*visitor);
  }

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  std::vector<Entry> query(std::string_view interface_name) const;
  std::vector<Silent> silent(TimePoint now) const;
  /// The life of a visitor's list is another one whenever the visitor sees other objects. The
  /// visitor then gets the whole list, in which the objects are missing that are hidden now.
  ListRevision revision() const;
  /// A visitor is told no change from before the lists of the objects named this user.
  ListChanges changes(const ListRevision& since, TimePoint now) const;

 private:
  bool hidden(const std::string& name) const { return seen_ && !seen_->objects.contains(name); }
  bool hides(const Entry& one) const { return hidden(one.name); }

  const Directory& directory_;
  std::optional<access::VisitorBook::Seen> seen_;  ///< no value: everything
};

}  // namespace gecos::broker
