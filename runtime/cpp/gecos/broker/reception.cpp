#include "gecos/broker/reception.hpp"

#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/broker_interface.hpp"

namespace gecos::broker {

Reception::Reception() : visitors_(std::make_shared<session::Visitors>()) {
  visitors_->open = {BrokerInterface::lookup.code,         BrokerInterface::list.code,
                     BrokerInterface::silent.code,         BrokerInterface::query.code,
                     BrokerInterface::changes.code,        BrokerInterface::revision.code,
                     BrokerInterface::revision_stream.code};
}

TimePoint Reception::look(TimePoint now) {
  access::VisitorBook& book = visitors_->book;
  if (book.empty()) {
    read_at_.reset();
    next_ = {};
    return TimePoint::max();
  }
  if (now < next_) return next_;
  next_ = now + between_looks;
  const auto found = revoked_->read();
  if (found) {
    book.revoke((*found)->revoked);
    read_at_ = now;
    reported_ = false;
  } else if (!read_at_ || now - *read_at_ >= known_for) {
    book.revoke(std::nullopt);
    if (!std::exchange(reported_, true)) {
      log_warning("broker", "no visitor is admitted: " + found.error());
    }
  }
  return next_;
}

void Reception::prepare(const std::optional<AdmittedNames>& admitted) {
  if (!admitted || visitors_->book.knows_revoked()) return;
  if (const auto found = revoked_->read()) visitors_->book.revoke((*found)->revoked);
}

bool Reception::note(const Entry& what, const std::optional<AdmittedNames>& admitted) {
  std::optional<access::ProgramList> list;
  if (admitted) {
    list = {{what.user, what.hostname},
            what.boot,
            admitted->number,
            {admitted->users, admitted->hosts, "Server::allow in the program of " + what.name}};
  }
  return visitors_->book.set(what.name, what.boot, std::move(list));
}

}  // namespace gecos::broker
