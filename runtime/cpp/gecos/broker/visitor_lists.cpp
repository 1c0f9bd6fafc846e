#include "gecos/broker/visitor_lists.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/broker_interface.hpp"

namespace gecos::broker {

VisitorLists::VisitorLists() : visitors_(std::make_shared<session::Visitors>()) {
  visitors_->open = {BrokerInterface::lookup.code,         BrokerInterface::list.code,
                     BrokerInterface::silent.code,         BrokerInterface::query.code,
                     BrokerInterface::changes.code,        BrokerInterface::revision.code,
                     BrokerInterface::revision_stream.code};
}

TimePoint VisitorLists::refresh_revoked(TimePoint now) {
  access::VisitorBook& book = visitors_->book;
  if (!book.names_somebody()) {
    read_at_.reset();
    next_ = {};
    return TimePoint::max();
  }
  if (now < next_) return next_;
  next_ = now + between_readings;
  const auto found = revoked_->read();
  if (found) {
    book.set_revoked((*found)->revoked);
    read_at_ = now;
    reported_ = false;
  } else if (!read_at_ || now - *read_at_ >= known_for) {
    book.lose_revoked();
    if (!std::exchange(reported_, true)) {
      log_warning("broker", "no visitor is admitted: " + found.error());
    }
  }
  return next_;
}

void VisitorLists::ensure_revoked_known(const std::optional<AdmittedNames>& admitted) {
  if (!admitted || (admitted->users.empty() && admitted->hosts.empty())) return;
  if (visitors_->book.knows_revoked()) return;
  if (const auto found = revoked_->read()) visitors_->book.set_revoked((*found)->revoked);
}

bool VisitorLists::set(const Entry& what, const std::optional<session::ProvedUser>& user,
                       const std::optional<AdmittedNames>& admitted, std::uint64_t revision) {
  access::ServerLife server{{what.user, what.hostname}, what.boot, !user, user ? user->key : ""};
  access::VisitorBook& book = visitors_->book;
  if (!admitted) return book.drop_other(what.name, server);
  return book.set(what.name,
                  {std::move(server),
                   admitted->number,
                   {admitted->users, admitted->hosts, "the list in the program of " + what.name}},
                  revision);
}

}  // namespace gecos::broker
