#pragma once

#include <cstdint>
#include <string>
#include <string_view>

/// The audit of a server records who was admitted or refused and why, who held which status, and
/// which commands moved what. Each line of the audit is one JSON object.
///
/// A line contains no argument of a call and no result, so that no password can be in it.
namespace gecos::audit {

/// Identifies one request: a call, or a connection that was refused. For a call, the three numbers
/// are those of its CommandId. For a refused connection, and for a call that was refused to a
/// visitor, `session` is a hash of the user, the object and the reason, and `counter` is the
/// running number of these refusals at the server or at the object.
struct RequestId {
  std::uint64_t incarnation = 0;  ///< incarnation of the server's process
  std::uint64_t session = 0;
  std::uint64_t counter = 0;  ///< 0: the line is about no request
};

/// Returns the request as three hexadecimal numbers, in the form of to_string(CommandId).
std::string to_string(const RequestId& id);

/// A line of the audit, which describes one event. to_json() leaves out the members that are empty
/// or 0.
struct Line {
  std::string_view event;  ///< for example "command"; a literal
  std::int64_t time = 0;   ///< Unix time in ms
  std::string object{};
  RequestId request{};
  std::string operation{};
  std::string status{};
  std::string outcome{};
  std::string why{};
  std::string user{};
  std::string host{};
  std::string program{};
  std::int32_t pid = 0;  ///< pid of the client
  std::string medium{};
  std::uint64_t count = 0;  ///< how many events the line stands for, if it stands for several
  std::uint64_t last = 0;   ///< the request counter of the last of these events
};

/// Returns the event as JSON text. The text is one line and ends with a newline. Bytes that are not
/// ASCII are copied: they must be UTF-8. Texts longer than 1 KiB are cut.
std::string to_json(const Line& line);

/// Returns the current time for Line::time. Its resolution is a few milliseconds, and reading it
/// costs some nanoseconds.
std::int64_t now();

}  // namespace gecos::audit
