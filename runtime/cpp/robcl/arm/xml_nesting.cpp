#include "robcl/arm/xml_nesting.hpp"

#include <array>

namespace robcl::arm {
namespace {

constexpr auto nowhere = std::string_view::npos;

/// Markup that is not an element, such as a comment: the characters with which it begins and ends.
struct Other {
  std::string_view begin, end;
};
constexpr std::array<Other, 4> others{
    {{"<!--", "-->"}, {"<![CDATA[", "]]>"}, {"<?", ">"}, {"<!", ">"}}};

/// Returns the place of the character '>' that ends the tag at `from`. Ignores each '>' inside
/// quotes.
std::size_t end_of_tag(std::string_view xml, std::size_t from) {
  std::size_t at = from;
  while ((at = xml.find_first_of("\"'>", at)) != nowhere && xml[at] != '>') {
    at = xml.find(xml[at], at + 1);
    if (at == nowhere) return nowhere;
    ++at;
  }
  return at;
}

/// If `from` is the beginning of markup that is not an element, returns the place after the last
/// character of this markup. Otherwise returns `from`.
std::size_t after_other(std::string_view xml, std::size_t from) {
  for (const auto& [begin, end] : others) {
    if (xml.substr(from, begin.size()) != begin) continue;
    const std::size_t at = xml.find(end, from + begin.size());
    return at == nowhere ? xml.size() : at + end.size();
  }
  return from;
}

}  // namespace

bool nested_deeper_than(std::size_t most, std::string_view xml) {
  std::size_t depth = 0;
  for (std::size_t at = 0; (at = xml.find('<', at)) != nowhere;) {
    if (depth > 0 && xml.substr(at, 2) == "<?") return true;
    if (const std::size_t after = after_other(xml, at); after != at) {
      at = after;
      continue;
    }
    const std::size_t end = end_of_tag(xml, at);
    if (end == nowhere) return false;
    if (xml[at + 1] == '/') {
      if (depth > 0) --depth;
    } else if (xml[end - 1] != '/' && ++depth > most) {
      return true;
    }
    at = end + 1;
  }
  return false;
}

}  // namespace robcl::arm
