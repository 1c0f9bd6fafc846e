#pragma once

#include <string>

#include "gecos/object_types.hpp"

namespace feeding {

/// Counts of a stream as the tests of both languages write them; counts that are 0 are left out.
inline std::string in_words(const gecos::FeedReport& report) {
  std::string words = "admitted " + std::to_string(report.admitted);
  const auto add = [&](const char* what, std::uint64_t count) {
    if (count != 0) words += std::string(", ") + what + " " + std::to_string(count);
  };
  add("lost", report.lost);
  add("other_session", report.other_session);
  add("session_ended", report.session_ended);
  add("no_status", report.no_status);
  add("command_not_running", report.command_not_running);
  add("too_old", report.too_old);
  add("not_newer", report.not_newer);
  add("unreadable", report.unreadable);
  if (!report.last_refusal.empty()) words += "; " + report.last_refusal;
  return words;
}

}  // namespace feeding
