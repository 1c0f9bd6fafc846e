// Calls operations of the runtime's own interfaces. The arguments and results of these operations
// are structs that gidl generates.
#pragma once

#include <memory>
#include <utility>

#include "gecos/object.hpp"
#include "gecos/wire/layout.hpp"

namespace gecos::session {

/// Calls `operation` and returns its command. When the arguments are invalid, sends nothing and
/// returns a command that has ended as BAD_PARAMETER.
template <layout::Listed Arguments>
std::shared_ptr<CommandCore> own_call(ClientSession& session, const OperationDescription& operation,
                                      const Arguments& arguments) {
  if (auto wrong = layout::violation(arguments); !wrong.empty()) {
    return ended({Detail::BadParameter, std::move(wrong), {}, {}});
  }
  return session.call(operation, layout::encoded_size(arguments),
                      [&](wire::Encoder& to) { layout::encode(to, arguments); }, {});
}

inline std::shared_ptr<CommandCore> own_call(ClientSession& session,
                                             const OperationDescription& operation) {
  return session.call(operation, 0, [](wire::Encoder&) {}, {});
}

/// Decodes a `Reply` and stores its member `result` in `value`. Returns false when the reply does
/// not decode.
template <layout::Listed Reply, class T>
bool read_result(wire::Decoder& from, T& value) {
  Reply reply;
  if (!layout::decode(from, reply)) return false;
  value = std::move(reply.result);
  return true;
}

}  // namespace gecos::session
