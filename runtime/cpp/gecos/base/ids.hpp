// Ids of different things have different types, so that the compiler finds an id that is used in
// place of another.
#pragma once

#include <cstdint>
#include <type_traits>

namespace gecos {

/// Identifies the session of one proxy with one object. The server chooses the id. Until then the
/// id is 0.
enum class SessionId : std::uint64_t {};

/// Identifies an operation. The code is the hash of the operation's scoped name, or the number that
/// its `@id` annotation states.
enum class FunctionCode : std::uint32_t {};

/// Identifies one run of a server process. A server that is restarted gets another id.
enum class IncarnationId : std::uint64_t {};

/// Fencing token of a client's status for an object. The object does not start commands that were
/// issued under an older epoch.
enum class Epoch : std::uint64_t {};

/// Returns the plain number of an id, for encoding, hashing and printing.
template <typename Id>
requires std::is_enum_v<Id>
constexpr std::underlying_type_t<Id> number(Id id) {
  return static_cast<std::underlying_type_t<Id>>(id);
}

}  // namespace gecos
