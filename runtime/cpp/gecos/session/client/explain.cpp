#include <algorithm>
#include <ostream>

#include "gecos/lab.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/client/select.hpp"

namespace gecos {

std::string to_string(const std::vector<qos::Violation>& violations) {
  std::string text;
  for (const auto& [term, why] : violations) {
    text += (text.empty() ? "" : "; ") + term + ": " + why;
  }
  return text;
}

std::ostream& operator<<(std::ostream& out, const Explanation& explanation) {
  out << explanation.name << " (" << explanation.interface_name
      << (explanation.simulated ? ", simulated" : "") << ") on " << explanation.hostname;
  bool chosen = false;
  for (const MediumVerdict& each : explanation.media) {
    out << "\n  " << each.medium << ": ";
    if (each.suitable()) {
      out << (chosen ? "used if no medium above it answers" : "chosen");
      chosen = true;
    }
    out << each.unreachable << to_string(each.violations);
    if (!each.real_time_by.empty()) out << "\n    " << each.real_time_by;
    for (const UnsuitedMember& member : each.members) {
      out << "\n    not " << (member.samples_only ? "the samples of " : "") << member.name << ": "
          << to_string(member.violations);
    }
  }
  return out;
}

}  // namespace gecos

namespace gecos::session {
namespace {

/// Returns the statement of the lab file without which `line` would not be real-time; an empty text
/// if there is none.
std::string permission(const qos::LineCapabilities& line) {
  const bool permits = line.stated && line.stated->real_time && !line.real_time;
  return permits ? line.stated->text : "";
}

}  // namespace

tl::expected<Explanation, CreateError> explain(const LabOrWhyNot& lab,
                                               const InterfaceDescription& wanted,
                                               const std::string& name,
                                               const CreateOptions& options) {
  const auto failed = [&](Detail detail, std::string why) {
    return tl::unexpected(CreateError{{{name, detail, std::move(why)}}});
  };
  if (!lab) return failed(Detail::NoServer, lab.error().text);
  const auto entry = find_entry(**lab, wanted, name, options);
  if (!entry) return tl::unexpected(CreateError{{entry.error()}});
  Explanation found{name, entry->interface_name, entry->hostname, entry->simulated, {}};
  std::vector<qos::LineCapabilities> lines;
  std::vector<MediumVerdict> suitable;
  const qos::Quality demanded = demanded_of(wanted.quality, entry->simulated);
  const StatedMedia stated = stated_media(**lab, wanted, *entry, deadline_after(options.patience));
  for (const auto& address : entry->addresses) {
    MediumVerdict verdict{medium_of(address), address, {}, {}, {}, {}};
    const auto line = line_to(*(*lab)->runtime(), *entry, address, stated);
    if (!line) verdict.unreachable = line.error();
    if (line) verdict.violations = qos::violations(demanded, *line);
    if (line) verdict.real_time_by = permission(*line);
    if (!verdict.suitable()) {
      found.media.push_back(std::move(verdict));
      continue;
    }
    verdict.members = unsuited_members(wanted, *line, entry->simulated);
    lines.push_back(*line);
    suitable.push_back(std::move(verdict));
  }
  std::vector<MediumVerdict> ranked;
  for (const std::size_t index : qos::rank(demanded, lines)) {
    ranked.push_back(std::move(suitable[index]));
  }
  found.media.insert(found.media.begin(), std::make_move_iterator(ranked.begin()),
                     std::make_move_iterator(ranked.end()));
  return found;
}

}  // namespace gecos::session
