#include "gecos/audit/shared_lines.hpp"

#include <algorithm>
#include <functional>
#include <iterator>
#include <utility>

namespace gecos::audit {
namespace {

Repeats::Key key_of(const Line& further) {
  std::string what = std::string(further.event) + '\0' + further.user + '\0' + further.host + '\0' +
                     further.object + '\0';
  std::ranges::copy_if(further.why, std::back_inserter(what),
                       [](char c) { return c < '0' || c > '9'; });
  const std::uint64_t number = std::hash<std::string>()(what);
  return {0, number, 0, std::move(what)};
}

/// Returns the line that counts events of several users.
Line of_several_users(Line further, const std::string& object) {
  further.object = object;
  further.why.clear();
  further.user = "several users";
  further.host.clear();
  return further;
}

}  // namespace

std::uint64_t SharedLines::add(Line line, Line further) {
  const std::uint64_t counter = line.request.counter;
  Repeats::Key key = key_of(further);
  if (repeats_.count(key, counter)) return key.code;
  Line of_several = of_several_users(further, object_);
  Repeats::Key several = key_of(of_several);
  if (repeats_.count(several, counter)) return several.code;
  if (repeats_.kinds() >= most_kinds) {
    key = std::move(several);
    further = std::move(of_several);
  }
  line.request.session = further.request.session = key.code;
  repeats_.begin(key, further, Repeats::Window::Growing);
  audit_->add(std::move(line));
  return key.code;
}

void SharedLines::on_tick(std::int64_t now) {
  for (Line& repeated : repeats_.due(now)) audit_->add(std::move(repeated));
}

void SharedLines::end(std::int64_t now) {
  for (Line& repeated : repeats_.all(now)) audit_->add(std::move(repeated));
}

}  // namespace gecos::audit
