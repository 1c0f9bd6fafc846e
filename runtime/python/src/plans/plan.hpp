#pragma once

#include <Python.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

/// Compiled codecs of generated structs, as described by `gecos.wire.plans`.
///
/// A plan handles only the usual case. It gives up at any other value or bytes; then the Python
/// codec runs from the start, and it alone reports errors. Everything here must be called with the
/// GIL. Plans live until the process ends.
namespace gecos::python::plans {

struct Plan;

/// Limits of a number, for each of the three kinds of number.
struct Limits {
  double low = -std::numeric_limits<double>::infinity();
  double high = std::numeric_limits<double>::infinity();
  std::int64_t least = std::numeric_limits<std::int64_t>::min();
  std::int64_t most = std::numeric_limits<std::int64_t>::max();
  bool there = false;

  template <class T>
  bool hold(T x) const {
    if constexpr (std::is_floating_point_v<T>) {
      return !there || (static_cast<T>(low) <= x && x <= static_cast<T>(high));
    } else {
      return !there ||
             (least <= static_cast<std::int64_t>(x) && static_cast<std::int64_t>(x) <= most);
    }
  }
};

enum class What : std::uint8_t {
  Double,  ///< without limits; the most common member
  Number,
  Enumerator,
  Array,    ///< a numpy array of a given shape
  Numbers,  ///< a sequence of numbers, as a numpy array
  Text,
  Octets,
  Struct,
  Block,  ///< an appendable struct
  Optional,
  Items,  ///< a sequence or array of other elements
};

/// How one member is written and read.
struct Step {
  What what = What::Number;
  char code = 0;  ///< of numbers: as in `wire.Fields`
  Limits limits;
  std::vector<Py_ssize_t> shape;  ///< of an array
  Py_ssize_t size = -1;           ///< elements; -1 where a count says how many
  Py_ssize_t most = 0;            ///< of a count, or of a text's bytes
  Py_ssize_t least = 0;           ///< bytes that an element takes
  const Plan* plan = nullptr;     ///< of a struct
  PyTypeObject* kind = nullptr;   ///< of an enumerator
  PyObject* known = nullptr;      ///< enumerators by number
  PyObject* otherwise = nullptr;  ///< the enumerator for an unknown number, or null
  std::vector<Step> inner;        ///< of an optional value and of items: one
};

/// A generated struct: a dataclass with slots.
struct Plan {
  PyTypeObject* kind = nullptr;
  std::uint64_t fingerprint = 0;
  std::vector<Step> steps;
  std::vector<Py_ssize_t> slots;    ///< where each member is in an object
  std::vector<PyObject*> defaults;  ///< of the last members, which an older writer may leave out
  bool open = false;                ///< members added by a newer writer are skipped
  Py_ssize_t least = 0;             ///< smallest size of a value in bytes
};

/// Calls `act` with a number of the type of a code other than `?`.
template <class Act>
bool with_number_of(char code, Act act) {
  switch (code) {
    case 'b':
      return act(std::int8_t{});
    case 'B':
      return act(std::uint8_t{});
    case 'h':
      return act(std::int16_t{});
    case 'H':
      return act(std::uint16_t{});
    case 'i':
      return act(std::int32_t{});
    case 'I':
      return act(std::uint32_t{});
    case 'q':
      return act(std::int64_t{});
    case 'Q':
      return act(std::uint64_t{});
    case 'f':
      return act(float{});
    case 'd':
      return act(double{});
    default:
      return false;
  }
}

/// Bytes of a number; 0 if `code` is not a code.
constexpr Py_ssize_t size_of(char code) {
  constexpr std::string_view codes = "?bBhHiIqQfd";
  constexpr Py_ssize_t sizes[] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  const auto at = codes.find(code);
  return at == codes.npos ? 0 : sizes[at];
}

enum class Frame : std::uint8_t {
  Bare,     ///< the fields alone
  Message,  ///< a value after its fingerprint
  Block,    ///< a value after its size
};

/// Encodes `value`; null without an error set when it must be left to Python. @pre the type of
/// `value` is the plan's kind, not derived from it.
PyObject* encoded(const Plan& plan, PyObject* value, Frame frame);

/// The bytes that are still to be read, from `at` to `end`.
struct Input {
  const std::byte* at = nullptr;
  const std::byte* end = nullptr;
  Py_ssize_t remaining() const { return end - at; }
};

/// A new value; null when these bytes must be left to Python, with no error set.
PyObject* decoded(const Plan& plan, Input& from);

}  // namespace gecos::python::plans
