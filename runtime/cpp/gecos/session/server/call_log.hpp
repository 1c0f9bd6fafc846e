#pragma once

#include <string>
#include <string_view>

#include "gecos/base/log.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/server_session.hpp"

/// Writes the log lines of a server about its calls: caller, operation, object and outcome.
/// GECOS_LOG enables these lines, so check log_enabled() before you call these functions.
namespace gecos::session {

/// Returns a text such as "alice on lab1 (lift.py, pid 12)".
std::string who(const Caller& caller);

/// Returns the log level for calls of `operation`: info if the operation needs a status, otherwise
/// debug.
inline LogLevel level_of(const OperationDescription& operation) {
  return operation.status == access::Status::Sensor ? LogLevel::Debug : LogLevel::Info;
}

void log_begin(const ServerCall& call);
void log_end(const ServerCall& call, Detail detail, const std::string& text, TimePoint now);
/// Logs a call that was refused.
void log_refused(std::string_view object, const OperationDescription& operation,
                 const Caller& caller, const Failure& failure);

void log_arrival(std::string_view object, ServerSession& session);
void log_departure(std::string_view object, const ServerSession& session);

}  // namespace gecos::session
