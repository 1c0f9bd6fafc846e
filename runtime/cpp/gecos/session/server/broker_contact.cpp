#include "gecos/session/server/broker_contact.hpp"

#include <algorithm>
#include <chrono>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/broker_calls.hpp"      // generated from idl/gecos/broker.gidl
#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/session/client/client_connection.hpp"
#include "gecos/session/client/own_call.hpp"

namespace gecos::session {
namespace {

constexpr Duration between_questions = std::chrono::seconds(1);

}  // namespace

void BrokerContact::need() {
  const MutexLock lock(mutex_);
  needed_ = true;
}

BrokerContact::Question BrokerContact::ask(ClientConnection& broker) {
  std::uint64_t applied = 0;
  {
    const MutexLock lock(mutex_);
    applied = number_;
  }
  const TimePoint asked = clock_.since_boot();
  auto command =
      own_call(broker, BrokerInterface::revocations, Broker_revocations_arguments{applied});
  command->observe();  // a failure is not worth a warning: the next question follows
  return {asked, std::move(command)};
}

void BrokerContact::renew(ClientConnection& broker, TimePoint deadline) {
  need();
  if (out_of_contact().empty()) return;
  const Question question = ask(broker);
  if (question.command->wait_until(deadline)) take(question);
}

void BrokerContact::on_tick(const std::shared_ptr<ClientConnection>& broker) {
  if (open_) {
    if (open_->command->progress().detail < Detail::Done) return;
    take(*std::exchange(open_, std::nullopt));
  }
  const TimePoint now = clock_.since_boot();
  if (broker == nullptr || broker->lost() || now < next_) return;
  next_ = now + between_questions;
  open_ = ask(*broker);
}

void BrokerContact::take(const Question& question) {
  const Detail detail = question.command->progress().detail;
  if (detail == Detail::UnknownOperation) {  // a broker of an older version revokes nobody
    return take(question.asked, 0, std::vector<access::RevokedUser>());
  }
  if (detail != Detail::Done) {
    log_debug("session", "the broker does not say which users the laboratory has revoked: " +
                             question.command->failure().text);
    return;
  }
  RevocationList answer;
  wire::Decoder from(question.command->result());
  if (!read_result<Broker_revocations_result>(from, answer)) return;
  std::optional<std::vector<access::RevokedUser>> list;
  if (answer.changed) {
    list.emplace();
    for (Revocation& one : answer.revoked) list->push_back({one.key, one.owner});
  }
  take(question.asked, answer.number, std::move(list));
}

void BrokerContact::take(TimePoint asked, std::uint64_t number,
                         std::optional<std::vector<access::RevokedUser>> list) {
  const MutexLock lock(mutex_);
  if (!list && number != number_)
    return;  // the answer is about another list than that of this server
  known_at_ = std::max(known_at_.value_or(asked), asked);
  number_ = number;
  if (list) list_ = *std::move(list);
}

bool BrokerContact::revokes(std::string_view key, const access::UserAtHost& who) const {
  const MutexLock lock(mutex_);
  return access::revokes(list_, key, who);
}

std::string BrokerContact::out_of_contact() const {
  const TimePoint now = clock_.since_boot();
  const MutexLock lock(mutex_);
  if (!needed_) return {};
  if (!known_at_) return "since it was started";
  const Duration since = now - *known_at_;
  if (since < known_for) return {};
  return "for " + std::to_string(std::chrono::floor<std::chrono::seconds>(since).count()) + " s";
}

}  // namespace gecos::session
