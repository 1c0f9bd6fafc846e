// The error that says why a decoder refused bytes, and at which position.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <variant>

namespace gecos::wire {

enum class DecodeProblem : std::uint8_t {
  Truncated,          ///< the bytes end before the value or the counted elements
  InvalidBoolean,     ///< a boolean is neither 0 nor 1
  NegativeCount,      ///< a count is below 0, or below 1 for a string (its NUL)
  OverBound,          ///< more elements than the interface allows, or over 65,536 empty ones
  MissingNul,         ///< a string does not end with NUL
  NulInString,        ///< a string has a NUL before its end
  InvalidUtf8,        ///< a string is not UTF-8
  TooDeep,            ///< values are nested more than 16 levels deep
  TrailingBytes,      ///< bytes left over where nothing may follow
  UnknownEnumerator,  ///< an unknown number for an enum without a default
  UnknownUnionTag,    ///< a union's discriminator and members do not agree
  OutOfRange,         ///< a number is outside the declared `@range`
  UnsortedMap,        ///< the keys of a map are not strictly ascending
  WrongFingerprint,   ///< a message of another type
  InvalidValue,       ///< a hand-written type refused the value
};

/// Returns the problem as a text, for example "the string is not UTF-8".
const char* describe(DecodeProblem problem);

/// A refused number: a number that is outside its range, or that is no enumerator of its enum.
using RefusedNumber = std::variant<double, std::int64_t, std::uint64_t>;

struct DecodeError {
  DecodeProblem problem{};
  std::size_t offset =
      0;  ///< position of the refused value, counted from the first byte given to the decoder
  const char* field = "";  ///< static text; empty when the reader passed no field name

  /// A static text that says which numbers are valid. If `number` is outside a range, the text is
  /// the range, for example "[0.01, 1.0] m/s". If `number` is no enumerator, the text lists the
  /// known enumerators. The text is empty when the problem is not about a number.
  const char* limits = "";
  RefusedNumber number{};

  /// Returns a text such as "field 'speed' at byte 12: 3 is outside [0.01, 1.0] m/s; …"
  std::string message() const;

  /// Two errors are equal if their problem, offset and field are equal.
  friend bool operator==(const DecodeError& a, const DecodeError& b);
};
inline std::string describe(const DecodeError& error) { return error.message(); }

}  // namespace gecos::wire
