// Why bytes were refused, and where.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace gecos::wire {

enum class DecodeProblem : std::uint8_t {
  Truncated,          ///< the value, or what a count promises, goes past the end
  InvalidBoolean,     ///< neither 0 nor 1
  NegativeCount,      ///< a count below 0, or a string length below 1 (its NUL)
  OverBound,          ///< more elements than the interface allows, or over 65,536 of size 0
  MissingNul,         ///< a string does not end with NUL
  NulInString,        ///< a string has a NUL before its end
  InvalidUtf8,        ///< a string is not UTF-8
  TooDeep,            ///< nested deeper than 16
  TrailingBytes,      ///< bytes left over where nothing may follow
  UnknownEnumerator,  ///< an unknown number for an enum without a default
  UnknownUnionTag,    ///< a union's tag and its arms do not agree
  OutOfRange,         ///< outside the declared `@range`
  UnsortedMap,        ///< the keys of a map are not strictly ascending
  WrongFingerprint,   ///< a message of another type
  InvalidValue,       ///< a hand-written value type refused the value
};

/// The problem in words: "the string is not UTF-8".
const char* describe(DecodeProblem problem);

struct DecodeError {
  DecodeProblem problem{};
  std::size_t offset =
      0;  ///< position of the refused value, counted from the first byte given to the decoder
  const char* field = "";  ///< static text; empty when the caller of `get` passed no name

  /// "field 'speed' at byte 12: outside its declared range"
  std::string message() const;

  friend bool operator==(const DecodeError& a, const DecodeError& b);
};
inline std::string describe(const DecodeError& error) { return error.message(); }

}  // namespace gecos::wire
