#include "setting.hpp"

#include <cstdio>
#include <cstdlib>
#include <sstream>
#include <string_view>

#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"

namespace stress {
namespace {

[[noreturn]] void wrong(const std::string& what) {
  std::fprintf(stderr, "%s\n", what.c_str());
  std::exit(2);
}

const gecos::Clock& real_clock() {
  static const gecos::SystemClock clock;
  return clock;
}

}  // namespace

Setting::Setting(int count, char** words, std::map<std::string, std::string> standard)
    : values_(std::move(standard)) {
  for (int at = 1; at < count; ++at) {
    const std::string word = words[at];
    const auto equals = word.find('=');
    const auto found = values_.find(word.substr(0, equals));
    if (equals == std::string::npos || found == values_.end()) wrong("not known: " + word);
    found->second = word.substr(equals + 1);
  }
}

double Setting::number(const std::string& name) const { return std::stod(text(name)); }

gecos::media::Kind Setting::medium() const {
  const auto kind = gecos::media::kind_from(text("medium"));
  if (!kind) wrong("no medium: " + text("medium"));
  return *kind;
}

gecos::Lab Setting::lab() const {
  if (text("faults").empty()) return gecos::Lab();
  gecos::media::Faults faults;
  std::istringstream from(text("faults"));
  char comma = 0;
  from >> faults.loss >> comma >> faults.duplication >> comma >> faults.reordering >> comma >>
      faults.corruption >> comma >> faults.seed;
  if (!from) wrong("faults are five numbers: " + text("faults"));
  const auto wrap = [faults](std::unique_ptr<gecos::media::Medium> inner) {
    if (inner->capabilities().name != "lcm") return inner;
    return gecos::media::make_faulty(std::move(inner), faults, real_clock());
  };
  return gecos::session::LabAccess::with_media({}, wrap);
}

}  // namespace stress
