#include "gecos/qos/match.hpp"

#include <algorithm>
#include <cstdio>
#include <tuple>
#include <utility>

namespace gecos::qos {
namespace {

/// Returns a text such as "shm was measured at 3ms".
std::string measured(const LineCapabilities& line) {
  const auto& [round_trip, answered] = *line.latency;
  return line.name + (answered ? " was measured at " : " gave no answer within ") +
         with_unit(round_trip);
}

/// Returns why HARD_REALTIME is not possible over `line`; an empty text when it is.
std::string why_not_real_time(const LineCapabilities& line) {
  if (line.stated) return line.stated->real_time ? "" : line.stated->text;
  if (line.real_time) return "";
  return "the medium " + line.name + " shares a queue with other programs and may lose packets";
}

bool too_slow(const Quality& asked, const LineCapabilities& line) {
  return binds_latency(asked) && line.latency && line.latency->round_trip > asked.latency;
}

bool too_unreliable(const Quality& asked, const LineCapabilities& line, Traffic traffic) {
  const bool reliable = traffic == Traffic::Samples ? line.keeps_samples : line.reliable;
  return demands_reliable(asked.reliability, traffic) && !reliable;
}

}  // namespace

std::string with_unit(Duration duration) {
  const double seconds = std::chrono::duration<double>(duration).count();
  char text[32];
  // Each bound, in s, is the smallest duration that the next format would print with an exponent,
  // such as 1e+03ms.
  if (seconds >= 9999.5) {
    std::snprintf(text, sizeof text, "%.0fs", seconds);
  } else if (seconds >= 0.9995) {
    std::snprintf(text, sizeof text, "%.4gs", seconds);
  } else if (seconds >= 0.9995e-3) {
    std::snprintf(text, sizeof text, "%.3gms", seconds * 1e3);
  } else {
    std::snprintf(text, sizeof text, "%.3gus", seconds * 1e6);
  }
  return text;
}

std::vector<Violation> violations(const Quality& asked, const LineCapabilities& line,
                                  Traffic traffic) {
  std::vector<Violation> found;
  if (asked.line == Class::HardRealtime) {
    if (std::string why = why_not_real_time(line); !why.empty()) {
      found.push_back({"class=" + std::string(to_string(asked.line)), std::move(why)});
    }
  }
  if (too_unreliable(asked, line, traffic)) {
    const std::string what = traffic == Traffic::Samples ? "samples" : "packets";
    found.push_back({"reliability=RELIABLE", "the medium " + line.name + " may lose " + what +
                                                 ", and nothing retransmits them"});
  }
  if (!allows(asked.media, line.name)) {
    found.push_back({"media=" + to_string(asked.media), line.name + " is not one of these media"});
  }
  if (too_slow(asked, line)) {
    found.push_back({"latency=" + with_unit(asked.latency), measured(line)});
  }
  return found;
}

std::vector<std::size_t> rank(const Quality& asked, std::span<const LineCapabilities> lines) {
  std::vector<std::size_t> fitting;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (violations(asked, lines[i]).empty()) fitting.push_back(i);
  }
  std::ranges::stable_sort(fitting, [&](std::size_t left, std::size_t right) {
    const LineCapabilities& a = lines[left];
    const LineCapabilities& b = lines[right];
    const auto promises = [](const LineCapabilities& line) {
      return std::tuple(!line.real_time, !line.reliable, !line.reports_death, line.between_hosts);
    };
    if (promises(a) != promises(b)) return promises(a) < promises(b);
    const auto round_trip = [](const LineCapabilities& line) {
      return line.latency ? line.latency->round_trip : Duration::max();
    };
    return round_trip(a) < round_trip(b);
  });
  return fitting;
}

tl::expected<std::size_t, std::string> choose(const Quality& asked,
                                              std::span<const LineCapabilities> lines) {
  if (lines.empty()) return tl::unexpected(std::string("there is no medium to choose from"));
  const std::vector<std::size_t> best_first = rank(asked, lines);
  if (!best_first.empty()) return best_first.front();
  std::string text = "no medium meets the required quality";
  std::vector<Violation> listed;
  for (const LineCapabilities& line : lines) {
    for (Violation& violation : violations(asked, line)) {
      if (std::ranges::find(listed, violation) != listed.end()) continue;
      text += "; " + violation.term + ": " + violation.why;
      listed.push_back(std::move(violation));
    }
  }
  return tl::unexpected(std::move(text));
}

}  // namespace gecos::qos
