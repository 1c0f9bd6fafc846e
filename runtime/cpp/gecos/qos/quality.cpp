#include "gecos/qos/quality.hpp"

#include <array>
#include <utility>

namespace gecos::qos {
namespace {

constexpr std::array<std::pair<Media, std::string_view>, 5> names{{{Media::Inproc, "inproc"},
                                                                   {Media::Shm, "shm"},
                                                                   {Media::Lcm, "lcm"},
                                                                   {Media::Tcp, "tcp"},
                                                                   {Media::Can, "can"}}};

constexpr bool has(Media media, Media one) {
  return (static_cast<std::uint8_t>(media) & static_cast<std::uint8_t>(one)) != 0;
}

}  // namespace

std::string_view to_string(Class line) {
  switch (line) {
    case Class::TimeIndependent:
      return "TIME_INDEPENDENT";
    case Class::SoftRealtime:
      return "SOFT_REALTIME";
    case Class::HardRealtime:
      return "HARD_REALTIME";
  }
  return "unknown class";
}

bool demands_reliable(Reliability asked, Traffic traffic) {
  if (asked == Reliability::Default) return traffic == Traffic::Calls;
  return asked == Reliability::Reliable;
}

std::string to_string(Media media) {
  std::string text;
  for (const auto& [one, name] : names) {
    if (has(media, one)) text += (text.empty() ? "" : "|") + std::string(name);
  }
  return text.empty() ? "any" : text;
}

bool allows(Media media, std::string_view name) {
  if (media == Media::Any) return true;
  if (name == "inproc" && has(media, Media::Shm)) return true;
  for (const auto& [one, its_name] : names) {
    if (name == its_name) return has(media, one);
  }
  return false;
}

}  // namespace gecos::qos
