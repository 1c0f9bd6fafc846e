#include "gecos/command.hpp"

#include <array>
#include <charconv>
#include <ostream>
#include <sstream>

namespace gecos {
namespace {

constexpr std::array detail_names = {"SENT",           "QUEUED",         "EXECUTING",
                                     "CANCELING",      "UNREACHABLE",    "DONE",
                                     "REJECTED",       "BAD_PARAMETER",  "UNKNOWN_OPERATION",
                                     "DENIED",         "QUEUE_FULL",     "EXPIRED",
                                     "TIMED_OUT",      "FAULT",          "CANCELED",
                                     "PREEMPTED",      "STOPPED",        "LEASE_LOST",
                                     "PRESENCE_LOST",  "SERVER_CRASHED", "OUTCOME_UNKNOWN",
                                     "NOT_STARTED",    "NO_SERVER",      "REFUSED",
                                     "QOS_UNAVAILABLE"};
static_assert(detail_names.size() == static_cast<std::size_t>(Detail::QosUnavailable) + 1);

}  // namespace

std::string_view to_string(State state) {
  switch (state) {
    case State::Running:
      return "RUNNING";
    case State::Finished:
      return "FINISHED";
    case State::CommandFailed:
      return "COMMAND_FAILED";
    case State::ConnectionFailed:
      return "CONNECTION_FAILED";
  }
  return "?";
}

State project(Detail detail) {
  if (detail < Detail::Done) return State::Running;
  if (detail == Detail::Done) return State::Finished;
  return detail < Detail::NotStarted ? State::CommandFailed : State::ConnectionFailed;
}

std::string_view to_string(Detail detail) {
  const auto index = static_cast<std::size_t>(detail);
  return index < detail_names.size() ? detail_names[index] : "?";
}

std::optional<Detail> detail_from(std::uint8_t number) {
  if (number >= detail_names.size()) return std::nullopt;
  return static_cast<Detail>(number);
}

std::string to_string(const CommandId& id) {
  std::ostringstream text;
  text << std::hex << id.incarnation << '-' << id.session << '-' << id.counter;
  return text.str();
}

std::optional<CommandId> command_id_from(std::string_view text) {
  CommandId id;
  const char* at = text.data();
  const char* const end = at + text.size();
  for (std::uint64_t* part : {&id.incarnation, &id.session, &id.counter}) {
    const auto [next, problem] = std::from_chars(at, end, *part, 16);
    const bool last = part == &id.counter;
    if (problem != std::errc() || (last ? next != end : next == end || *next != '-')) {
      return std::nullopt;
    }
    at = last ? next : next + 1;
  }
  return id;
}

std::ostream& operator<<(std::ostream& out, const CommandId& id) { return out << to_string(id); }
std::ostream& operator<<(std::ostream& out, State state) { return out << to_string(state); }
std::ostream& operator<<(std::ostream& out, Detail detail) { return out << to_string(detail); }

std::ostream& operator<<(std::ostream& out, const Failure& failure) {
  out << to_string(failure.state()) << '/' << to_string(failure.detail);
  if (!failure.exception.empty()) out << ' ' << failure.exception;
  if (!failure.text.empty()) out << ": " << failure.text;
  return out;
}

}  // namespace gecos
