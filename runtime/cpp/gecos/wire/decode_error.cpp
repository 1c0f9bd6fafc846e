#include "gecos/wire/decode_error.hpp"

#include <string_view>

#include "gecos/wire/check.hpp"

namespace gecos::wire {

const char* describe(DecodeProblem problem) {
  switch (problem) {
    case DecodeProblem::Truncated:
      return "the bytes end before the value does";
    case DecodeProblem::InvalidBoolean:
      return "a boolean must be 0 or 1";
    case DecodeProblem::NegativeCount:
      return "the count is negative";
    case DecodeProblem::OverBound:
      return "more elements than allowed";
    case DecodeProblem::MissingNul:
      return "the string does not end with NUL";
    case DecodeProblem::NulInString:
      return "the string contains NUL";
    case DecodeProblem::InvalidUtf8:
      return "the string is not UTF-8";
    case DecodeProblem::TooDeep:
      return "nested deeper than 16";
    case DecodeProblem::TrailingBytes:
      return "bytes are left over";
    case DecodeProblem::UnknownEnumerator:
      return "no enumerator has this number";
    case DecodeProblem::UnknownUnionTag:
      return "the union's discriminator and members do not agree";
    case DecodeProblem::OutOfRange:
      return "outside its declared range";
    case DecodeProblem::UnsortedMap:
      return "the map's keys are not ascending";
    case DecodeProblem::WrongFingerprint:
      return "a message of another type";
    case DecodeProblem::InvalidValue:
      return "not a valid value of its type";
  }
  return "unknown problem";
}

std::string DecodeError::message() const {
  std::string text;
  if (*field != '\0') text.append("field '").append(field).append("' ");
  text.append("at byte ").append(std::to_string(offset)).append(": ");
  if (*limits == '\0') return text.append(describe(problem));
  if (problem == DecodeProblem::OutOfRange) return text.append(outside_limits(number, limits));
  return text.append(none_of(number, limits));
}

bool operator==(const DecodeError& a, const DecodeError& b) {
  return a.problem == b.problem && a.offset == b.offset &&
         std::string_view(a.field) == std::string_view(b.field);
}

}  // namespace gecos::wire
