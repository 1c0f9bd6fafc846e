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
       std::optional<access::UserAtHost> visitor)
      : directory_(directory), book_(book), visitor_(std::move(visitor)) {}

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;
  std::vector<Entry> query(std::string_view interface_name) const;
  std::vector<Silent> silent(TimePoint now) const;
  /// The life of a visitor's list is another one whenever the visitor sees other objects. The
  /// visitor then gets the whole list, in which the objects are missing that are hidden now.
  ListRevision revision() const;
  ListChanges changes(const ListRevision& since, TimePoint now) const;

 private:
  bool hidden(const std::string& name) const { return visitor_ && !book_.shows(name, *visitor_); }
  bool hides(const Entry& one) const { return hidden(one.name); }

  const Directory& directory_;
  const access::VisitorBook& book_;
  const std::optional<access::UserAtHost> visitor_;
};

}  // namespace gecos::broker
