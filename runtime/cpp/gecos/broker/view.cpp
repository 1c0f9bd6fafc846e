#include "gecos/broker/view.hpp"

namespace gecos::broker {

tl::expected<Entry, UnknownName> View::look_up(const std::string& name) const {
  if (!seen_) return directory_.look_up(name);
  // Hidden objects are not looked up, so that the time of a refusal does not tell whether a hidden
  // object exists.
  if (!hidden(name)) {
    if (auto found = directory_.look_up(name)) return found;
  }
  UnknownName unknown{name, {}};
  for (const Entry& known : list()) unknown.known.push_back(known.name);
  return tl::unexpected(std::move(unknown));
}

std::vector<Entry> View::list() const {
  auto entries = directory_.list();
  std::erase_if(entries, [this](const Entry& one) { return hides(one); });
  return entries;
}

std::vector<Entry> View::query(std::string_view interface_name) const {
  auto entries = directory_.query(interface_name);
  std::erase_if(entries, [this](const Entry& one) { return hides(one); });
  return entries;
}

std::vector<Silent> View::silent(TimePoint now) const {
  auto found = directory_.silent(now);
  std::erase_if(found, [this](const Silent& one) { return hides(one.entry); });
  return found;
}

ListRevision View::revision() const {
  ListRevision revision = directory_.revision();
  if (seen_) revision.life ^= seen_->view;
  return revision;
}

ListChanges View::changes(const ListRevision& since, TimePoint now) const {
  if (!seen_) return directory_.changes(since, now);
  const ListRevision seen = revision();
  ListRevision asked = directory_.revision();
  if (since.life == seen.life && since.number >= seen_->since) {
    asked.number = since.number;
  } else {
    asked.life = ~asked.life;
  }
  ListChanges answer = directory_.changes(asked, now);
  answer.revision = seen;
  std::erase_if(answer.changed, [this](const Registration& one) { return hides(one.entry); });
  return answer;
}

}  // namespace gecos::broker
