// Numbers that must not be mixed up with each other.
#pragma once

#include <cstdint>
#include <type_traits>

namespace gecos {

/// One proxy's conversation with one object; chosen by the server, 0 before it has chosen.
enum class SessionId : std::uint64_t {};

/// Which operation is meant: the hash of its scoped name, or its `@id`.
enum class FunctionCode : std::uint32_t {};

/// One life of a server process. A restarted server has another one.
enum class IncarnationId : std::uint64_t {};

/// Fencing token of a status: commands of an older epoch do not start.
enum class Epoch : std::uint64_t {};

/// The plain number behind an id, for the wire, for hashing and for printing.
template <typename Id>
requires std::is_enum_v<Id>
constexpr std::underlying_type_t<Id> number(Id id) {
  return static_cast<std::underlying_type_t<Id>>(id);
}

}  // namespace gecos
