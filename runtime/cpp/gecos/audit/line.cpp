#include "gecos/audit/line.hpp"

#include <array>
#include <charconv>
#include <cstdio>
#include <ctime>

#include "gecos/base/whole_characters.hpp"

namespace gecos::audit {
namespace {

constexpr std::size_t longest_text = 1024;

void add_text(std::string& to, std::string_view text) {
  to += '"';
  for (const char c : whole_characters(text, longest_text)) {
    if (c == '"' || c == '\\') {
      to += '\\';
      to += c;
    } else if (static_cast<unsigned char>(c) < 0x20) {
      std::array<char, 8> escape;
      std::snprintf(escape.data(), escape.size(), "\\u%04x", static_cast<unsigned>(c));
      to += escape.data();
    } else {
      to += c;
    }
  }
  to += '"';
}

void add(std::string& to, const char* member, std::string_view text) {
  if (text.empty()) return;
  to.append(",\"").append(member).append("\":");
  add_text(to, text);
}

void add(std::string& to, const char* member, std::uint64_t number) {
  if (number == 0) return;
  to.append(",\"").append(member).append("\":").append(std::to_string(number));
}

void add_hexadecimal(std::string& to, std::uint64_t number) {
  std::array<char, 16> digits;
  const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), number, 16).ptr;
  to.append(digits.data(), end);
}

std::string date_and_time(std::int64_t unix_ms) {
  const std::time_t seconds = unix_ms / 1000;
  std::tm parts{};
  ::gmtime_r(&seconds, &parts);
  std::array<char, 24> text;
  const std::size_t length = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%S", &parts);
  std::array<char, 8> rest;
  std::snprintf(rest.data(), rest.size(), ".%03uZ", static_cast<unsigned>(unix_ms % 1000) % 1000);
  return std::string(text.data(), length) + rest.data();
}

}  // namespace

std::string to_string(const RequestId& id) {
  std::string text;
  add_hexadecimal(text, id.incarnation);
  text += '-';
  add_hexadecimal(text, id.session);
  text += '-';
  add_hexadecimal(text, id.counter);
  return text;
}

std::string to_json(const Line& line) {
  std::string text = "{\"time\":\"" + date_and_time(line.time) + "\"";
  add(text, "event", line.event);
  add(text, "object", line.object);
  if (line.request.counter != 0) add(text, "request", to_string(line.request));
  if (line.last != 0) {
    add(text, "last_request",
        to_string({line.request.incarnation, line.request.session, line.last}));
  }
  add(text, "count", line.count);
  add(text, "operation", line.operation);
  add(text, "status", line.status);
  add(text, "outcome", line.outcome);
  add(text, "user", line.user);
  add(text, "host", line.host);
  add(text, "program", line.program);
  if (line.pid > 0) add(text, "pid", static_cast<std::uint64_t>(line.pid));
  add(text, "medium", line.medium);
  add(text, "why", line.why);
  return text + "}\n";
}

std::int64_t now() {
  timespec time{};
  ::clock_gettime(CLOCK_REALTIME_COARSE, &time);
  return std::int64_t{time.tv_sec} * 1000 + time.tv_nsec / 1'000'000;
}

}  // namespace gecos::audit
