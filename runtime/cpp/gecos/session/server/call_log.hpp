#pragma once

#include <string>
#include <string_view>

#include "gecos/base/log.hpp"
#include "gecos/session/server/server_call.hpp"
#include "gecos/session/server/server_session.hpp"

/// What a server writes of its calls, where GECOS_LOG asks for it: who called what on which object,
/// and how it ended. Whoever calls these asks log_enabled() first.
namespace gecos::session {

/// "alice on lab1 (lift.py, pid 12)"
std::string who(const Caller& caller);

/// Commands that need a status are told at info, everything else at debug.
inline LogLevel level_of(const OperationDescription& operation) {
  return operation.status == access::Status::Sensor ? LogLevel::Debug : LogLevel::Info;
}

void log_begin(const ServerCall& call);
void log_end(const ServerCall& call, Detail detail, const std::string& text, TimePoint now);
/// Of one that was not taken.
void log_refused(std::string_view object, const OperationDescription& operation,
                 const Caller& caller, const Failure& failure);

void log_arrival(std::string_view object, ServerSession& session);
void log_departure(std::string_view object, const ServerSession& session);

}  // namespace gecos::session
