// Distinct types for ids, which must not be confused with each other.
#pragma once

#include <cstdint>
#include <type_traits>

namespace gecos {

/// Identifies the session of one proxy with one object. The server chooses the id; 0 before that.
enum class SessionId : std::uint64_t {};

/// Identifies an operation: the hash of its scoped name, or its `@id`.
enum class FunctionCode : std::uint32_t {};

/// Identifies one run of a server process. A restarted server has another id.
enum class IncarnationId : std::uint64_t {};

/// Fencing token of a status: commands issued under an older epoch do not start.
enum class Epoch : std::uint64_t {};

/// The plain number behind an id, for the wire, for hashing and for printing.
template <typename Id>
requires std::is_enum_v<Id>
constexpr std::underlying_type_t<Id> number(Id id) {
  return static_cast<std::underlying_type_t<Id>>(id);
}

}  // namespace gecos
