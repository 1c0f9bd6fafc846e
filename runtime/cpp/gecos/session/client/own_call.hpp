// Calls operations of interfaces that belong to the runtime itself, by the generated structs of
// their arguments and results.
#pragma once

#include <memory>
#include <utility>

#include "gecos/object.hpp"
#include "gecos/wire/encodable.hpp"

namespace gecos::session {

/// Calls `operation`. When the arguments are invalid, nothing is sent and the command ends as
/// BAD_PARAMETER.
template <wire::Encodable Arguments>
std::shared_ptr<CommandCore> own_call(ClientSession& session, const OperationDescription& operation,
                                      const Arguments& arguments) {
  if (auto wrong = wire::violation_of(arguments); !wrong.empty()) {
    return ended({Detail::BadParameter, std::move(wrong), {}, {}});
  }
  return session.call(operation, arguments.encoded_size(),
                      [&](wire::Encoder& to) { arguments.encode(to); }, {});
}

inline std::shared_ptr<CommandCore> own_call(ClientSession& session,
                                             const OperationDescription& operation) {
  return session.call(operation, 0, [](wire::Encoder&) {}, {});
}

/// Decodes a `Reply` and stores its member `result` in `value`. Returns false when the reply does
/// not decode.
template <wire::Encodable Reply, class T>
bool read_result(wire::Decoder& from, T& value) {
  Reply reply;
  if (!reply.decode(from)) return false;
  value = std::move(reply.result);
  return true;
}

}  // namespace gecos::session
