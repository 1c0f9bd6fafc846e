#include "gecos/access/zone.hpp"

#include <algorithm>
#include <utility>

namespace gecos::access {
namespace {

std::string joined(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

std::vector<std::string> lasting(const std::map<std::string, TimePoint>& until, TimePoint now) {
  std::vector<std::string> names;
  for (const auto& [name, end] : until) {
    if (now < end) names.push_back(name);
  }
  return names;
}

std::map<std::string, TimePoint> silent(const std::vector<std::string>& names) {
  std::map<std::string, TimePoint> all;
  for (const std::string& name : names) all.emplace(name, TimePoint::min());
  return all;
}

/// Returns whether `person` can stand in texts for people and in lines of logs: it is not blank and
/// has no control characters.
bool is_name(const std::string& person) {
  const auto control = [](unsigned char one) { return one < ' ' || one == 0x7f; };
  return person.find_first_not_of(' ') != std::string::npos &&
         std::ranges::none_of(person, control);
}

bool take_report(std::map<std::string, TimePoint>& sources, const std::string& name, bool good,
                 TimePoint now) {
  const auto source = sources.find(name);
  if (source == sources.end()) return false;
  source->second = good ? now + Zone::report_life : TimePoint::min();
  return true;
}

}  // namespace

Zone::Zone(std::string name, const Sources& sources, std::uint64_t earlier_spells)
    : name_(std::move(name)),
      buttons_(silent(sources.buttons)),
      doors_(silent(sources.doors)),
      spell_(earlier_spells) {}

Zone::Verdict Zone::verdict(TimePoint now) {
  judge(now);
  return {present_, spell_, present_ ? who(now) : why_absent(now)};
}

/// Between two reports, presence can end but not begin. Therefore judge() sees every change when it
/// is called before and after each report.
void Zone::judge(TimePoint now) {
  std::erase_if(people_, [&](const auto& person) { return now >= person.second; });
  const bool before = std::exchange(present_, person_here(now) && open_doors(now).empty());
  if (present_ && !before) ++spell_;
}

bool Zone::person_here(TimePoint now) const {
  return !people_.empty() || !lasting(buttons_, now).empty();
}

std::vector<std::string> Zone::open_doors(TimePoint now) const {
  std::vector<std::string> open;
  for (const auto& [name, until] : doors_) {
    if (now >= until) open.push_back(name);
  }
  return open;
}

std::string Zone::who(TimePoint now) const {
  std::vector<std::string> all;
  for (const auto& [person, until] : people_) all.push_back(person + " has checked in");
  for (const std::string& button : lasting(buttons_, now)) all.push_back(button + " is held");
  return joined(all);
}

std::string Zone::why_absent(TimePoint now) const {
  std::string text;
  if (!person_here(now)) {
    text = "no person has checked in" + std::string(buttons_.empty() ? "" : " or holds a button") +
           "; call show_code() of " + name_ +
           ", read the code in the laboratory, and call check_in()";
    for (const auto& [button, until] : buttons_) text += ", or hold " + button;
  }
  if (const auto open = open_doors(now); !open.empty()) {
    text += (text.empty() ? "" : "; ") + joined(open) +
            (open.size() == 1 ? " is open or silent; close it" : " are open or silent; close them");
  }
  return text;
}

bool Zone::door(const std::string& name, bool closed, TimePoint now) {
  judge(now);
  const bool known = take_report(doors_, name, closed, now);
  judge(now);
  return known;
}

bool Zone::button(const std::string& name, bool held, TimePoint now) {
  judge(now);
  const bool known = take_report(buttons_, name, held, now);
  judge(now);
  return known;
}

std::optional<std::string> Zone::too_many_wrong(TimePoint now) {
  std::erase_if(wrong_, [&](TimePoint at) { return now >= at + wrong_codes_within; });
  if (wrong_.size() < most_wrong_codes) return std::nullopt;
  const auto left =
      std::chrono::ceil<std::chrono::seconds>(wrong_.front() + wrong_codes_within - now);
  return name_ + " accepts no code for " + std::to_string(left.count()) +
         " s, because too many codes were wrong";
}

tl::expected<bool, std::string> Zone::show(std::string code, TimePoint now) {
  if (auto why = too_many_wrong(now)) return tl::unexpected(*std::move(why));
  if (code_ && now < code_->until) return false;
  code_ = Code{std::move(code), now + code_life};
  return true;
}

tl::expected<void, std::string> Zone::check_in(const std::string& code, const std::string& person,
                                               Duration stay, TimePoint now) {
  judge(now);
  if (auto why = too_many_wrong(now)) return tl::unexpected(*std::move(why));
  if (!is_name(person)) {
    return tl::unexpected(
        std::string("say who checks in: the name is empty or contains control characters"));
  }
  if (!code_ || now >= code_->until) {
    return tl::unexpected("no code is shown; call show_code() of " + name_ +
                          ", and read the code in the laboratory");
  }
  if (code != code_->text) {
    wrong_.push_back(now);
    return tl::unexpected("the code is not the one that " + name_ + " shows in the laboratory");
  }
  code_.reset();
  people_[person] = now + std::clamp(stay, Duration{}, longest_stay);
  judge(now);
  return {};
}

bool Zone::check_out(const std::string& person, TimePoint now) {
  judge(now);
  const bool was_here = people_.erase(person) != 0;
  judge(now);
  return was_here;
}

}  // namespace gecos::access
