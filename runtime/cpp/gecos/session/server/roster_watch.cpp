#include "gecos/session/server/roster_watch.hpp"

#include <algorithm>

#include "gecos/base/seconds.hpp"
#include "gecos/session/server/status_line.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {
namespace {

/// Returns the number from which the changes of the holders of an object are counted when the
/// object is served anew. The number is a hash with 2^52 values, so another object, or the same
/// object in another process, begins with another number. Programs that read JSON numbers as
/// doubles read such a number exactly.
std::uint64_t first_number(TimePoint now) {
  const auto moment = static_cast<std::uint64_t>(now.time_since_epoch().count());
  return (((number(process_incarnation()) + moment) * 0x9e37'79b9'7f4a'7c15U) >> 12) | 1;
}

Holder holder_line(const access::Holder& holder, TimePoint now) {
  Holder line;
  line.status = static_cast<Status>(holder.status);
  line.user = cut_to(holder.client.user, 64);
  line.host = cut_to(holder.client.host, 64);
  line.program = cut_to(holder.client.program, 128);
  line.pid = holder.client.pid;
  line.held_for = to_seconds(now - holder.since);
  line.expires_in = std::max(0.0, to_seconds(holder.expires - now));
  line.releasing = holder.releasing;
  line.taken_over = holder.taken_over;
  if (holder.taken_over) line.taken_over_for = to_seconds(now - holder.taken_over_since);
  return line;
}

RosterChange change_line(const access::RosterChange& change, TimePoint now) {
  RosterChange line;
  line.number = change.number;
  line.what = static_cast<HolderChange>(change.kind);
  line.holder = holder_line(change.holder, change.at);
  line.ago = to_seconds(now - change.at);
  line.why = change.why;
  return line;
}

}  // namespace

std::vector<Holder> shown_to_clients(const std::vector<access::Holder>& roster, TimePoint now) {
  std::vector<Holder> lines;
  for (const access::Holder& holder : roster) lines.push_back(holder_line(holder, now));
  return lines;
}

RosterWatch::RosterWatch(const ObjectSetup& setup, const access::LeaseTable& leases,
                         const SuspendAwareClock& clock)
    : leases_(leases),
      clock_(clock),
      changes_(first_number(setup.clock().now())),
      questions_(setup.name + ": too many questions about the holders of the status",
                 setup.clock()) {}

std::vector<Holder> RosterWatch::holders() const {
  return shown_to_clients(leases_.roster(), clock_.now());
}

void RosterWatch::note_change(std::string_view why_ended) {
  changes_.note(leases_.roster(), clock_.now(), why_ended);
  answer();
}

void RosterWatch::ask(const std::shared_ptr<ServerSession>& session, std::uint64_t counter,
                      const GecosObject_roster_arguments& asked) {
  questions_.add(session, counter, asked.after, asked.patience);
  answer();
}

void RosterWatch::answer() {
  questions_.answer([&](std::uint64_t known) { return known != changes_.newest(); },
                    [&](const OpenQuestions::Question& question) { reply(question); });
}

void RosterWatch::close() {
  questions_.answer([](std::uint64_t) { return true; },
                    [&](const OpenQuestions::Question& question) { reply(question); });
}

void RosterWatch::reply(const OpenQuestions::Question& question) const {
  Roster roster;
  roster.newest = changes_.newest();
  roster.holders = holders();
  for (const access::RosterChange& change : changes_.after(question.after)) {
    roster.changes.push_back(change_line(change, clock_.now()));
  }
  question.session->reply(question.counter,
                          layout::to_bytes(GecosObject_roster_result{std::move(roster)}));
}

}  // namespace gecos::session
