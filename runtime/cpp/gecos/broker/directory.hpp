#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "gecos/base/result.hpp"
#include "gecos/broker_types.hpp"

namespace gecos::broker {

/// Which objects there are, and which session enlisted each of them. Pure; not thread-safe.
class Directory {
 public:
  /// Adds it, as the session's. The server of that life (`boot`) may say the same again, in a new
  /// session perhaps before the end of its last one is known. Whatever else has that name, it is
  /// taken.
  tl::expected<void, NameTaken> enlist(std::uint64_t session, std::uint64_t boot,
                                       const Entry& entry);
  /// Only who enlisted an object takes it off.
  tl::expected<void, UnknownName> withdraw(std::uint64_t session, const std::string& name);
  /// Drops all that the session enlisted, and names it.
  std::vector<std::string> end_session(std::uint64_t session);

  tl::expected<Entry, UnknownName> look_up(const std::string& name) const;
  std::vector<Entry> list() const;

 private:
  struct Place {
    std::uint64_t session;
    Entry entry;
  };
  UnknownName unknown(const std::string& name) const;

  std::map<std::string, Place> places_;
};

}  // namespace gecos::broker
