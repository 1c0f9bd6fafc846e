#include "devices/zone/zone_servant.hpp"

#include <algorithm>
#include <chrono>
#include <random>
#include <string_view>
#include <utility>

namespace devices {
namespace {

/// The characters of the codes for check-ins. Letters and digits that look alike are left out.
constexpr std::string_view code_letters = "ABCDEFGHJKLMNPQRSTUVWXYZ23456789";
constexpr std::size_t code_length = 6;

std::string new_code() {
  std::random_device random;
  std::uniform_int_distribution<std::size_t> draw(0, code_letters.size() - 1);
  std::string code;
  while (code.size() < code_length) code += code_letters[draw(random)];
  return code;
}

/// Returns a number for the constructor of access::Zone: the first time of presence gets the next
/// number. The returned number is the Unix time in ns. Therefore it is larger at each start of this
/// program, and no time of presence has the number of an earlier one.
std::uint64_t spells_before() { return static_cast<std::uint64_t>(gecos::unix_now_ns()); }

}  // namespace

ZoneServant::ZoneServant(std::string name, gecos::access::Zone::Sources sources, Display display)
    : sources_(std::move(sources)),
      display_(std::move(display)),
      zone_(std::move(name), sources_, spells_before()) {}

void ZoneServant::publish() {
  const gecos::MutexLock lock(mutex_);
  publish_verdict();
}

void ZoneServant::simulate(const std::vector<std::string>& sources) {
  const gecos::MutexLock lock(mutex_);
  for (const std::string& source : sources) {
    if (!zone_.door(source, true, now())) zone_.button(source, true, now());
  }
  publish_change();
}

void ZoneServant::publish_verdict() {
  published_ = zone_.verdict(now());
  publish_presence({published_.present, published_.spell, published_.why});
}

void ZoneServant::publish_change() {
  if (zone_.verdict(now()) != published_) publish_verdict();
}

gecos::Result<gecos::ZonePresence> ZoneServant::presence() {
  const gecos::MutexLock lock(mutex_);
  const auto verdict = zone_.verdict(now());
  return gecos::ZonePresence{verdict.present, verdict.spell, verdict.why};
}

gecos::Result<void> ZoneServant::show_code() {
  const std::string code = new_code();
  {
    const gecos::MutexLock lock(mutex_);
    const auto shown = zone_.show(code, now());
    if (!shown) return tl::unexpected(gecos::CheckInRefused{shown.error()});
    if (!*shown) return {};
  }
  display_(code);
  return {};
}

gecos::Result<void> ZoneServant::check_in(const std::string& code, const std::string& person,
                                          double stay) {
  const auto length =
      std::chrono::duration_cast<gecos::Duration>(std::chrono::duration<double>(stay));
  const gecos::MutexLock lock(mutex_);
  if (const auto done = zone_.check_in(code, person, length, now()); !done) {
    return tl::unexpected(gecos::CheckInRefused{done.error()});
  }
  publish_change();
  return {};
}

gecos::Result<bool> ZoneServant::check_out(const std::string& person) {
  const gecos::MutexLock lock(mutex_);
  const bool was_here = zone_.check_out(person, now());
  publish_change();
  return was_here;
}

gecos::Result<void> ZoneServant::report_door(const std::string& door, bool closed) {
  const gecos::MutexLock lock(mutex_);
  if (!zone_.door(door, closed, now())) {
    return tl::unexpected(gecos::UnknownSource{door, sources_.doors});
  }
  publish_change();
  return {};
}

gecos::Result<void> ZoneServant::report_button(const std::string& button, bool held) {
  const gecos::MutexLock lock(mutex_);
  if (!zone_.button(button, held, now())) {
    return tl::unexpected(gecos::UnknownSource{button, sources_.buttons});
  }
  publish_change();
  return {};
}

}  // namespace devices
