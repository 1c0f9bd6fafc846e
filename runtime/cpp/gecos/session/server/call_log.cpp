#include "gecos/session/server/call_log.hpp"

#include <sstream>

#include "gecos/session/server/object_host.hpp"

namespace gecos::session {
namespace {

std::string name_of(std::string_view object, const OperationDescription& operation) {
  return std::string(object) + "." + std::string(operation.name);
}

}  // namespace

std::string who(const Caller& caller) {
  return caller.user + " on " + caller.host + " (" + caller.program + ", pid " +
         std::to_string(caller.pid) + ")";
}

void log_begin(const ServerCall& call) {
  log_debug("server", name_of(call.object().name(), call.operation()) + " of " +
                          who(call.caller()) + " begins");
}

void log_end(const ServerCall& call, Detail detail, const std::string& text, TimePoint now) {
  std::ostringstream line;
  line << name_of(call.object().name(), call.operation()) << " of " << who(call.caller())
       << " ended " << project(detail) << '/' << detail;
  if (call.arrived != TimePoint{}) {
    line << " after " << std::chrono::duration<double>(now - call.arrived).count() << " s";
  }
  if (!text.empty()) line << ": " << text;
  log(level_of(call.operation()), "server", std::move(line).str());
}

void log_refused(std::string_view object, const OperationDescription& operation,
                 const Caller& caller, const Failure& failure) {
  std::ostringstream line;
  line << name_of(object, operation) << " of " << who(caller) << " ended " << failure;
  log(level_of(operation), "server", std::move(line).str());
}

void log_arrival(std::string_view object, ServerSession& session) {
  log_info("server", std::string(object) + ": " + who(session.caller()) + " connects over " +
                         std::string(session.connection().capabilities().name));
}

void log_departure(std::string_view object, const ServerSession& session) {
  log_info("server", std::string(object) + ": " + who(session.caller()) +
                         (session.left ? " leaves" : " is gone"));
}

}  // namespace gecos::session
