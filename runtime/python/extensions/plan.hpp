#pragma once

#include <Python.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <string_view>
#include <type_traits>
#include <vector>

/// Compiled codecs of generated structs. `gecos.wire.plans` gives the descriptions of the structs.
///
/// A plan is the codec of one struct. `encoded` and `decoded` handle only the usual values and
/// bytes, and return null for all others. The Python codec then handles the value from the start;
/// only the Python codec reports errors. Callers must hold the GIL. Plans live until the process
/// ends.
namespace gecos::python::plans {

struct Plan;

/// The limits of a number. `low` and `high` are the limits of floats; `least` and `most` are the
/// limits of integers.
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
  Double,  ///< a double without limits; the most common member
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

/// The step of a plan that encodes and decodes one member of a struct.
struct Step {
  What what = What::Number;
  char code = 0;  ///< type code of numbers, as in `wire.Fields`
  Limits limits;
  std::vector<Py_ssize_t> shape;  ///< dimensions of an array
  Py_ssize_t size = -1;           ///< number of elements of an array; -1 for a sequence
  Py_ssize_t most = 0;            ///< greatest number of elements, or of bytes of a text
  Py_ssize_t least = 0;           ///< smallest size of an element in bytes
  const Plan* plan = nullptr;     ///< plan of a nested struct
  PyTypeObject* kind = nullptr;   ///< the Python enum of an enumerator
  PyObject* known = nullptr;      ///< dict from numbers to enumerators
  PyObject* otherwise = nullptr;  ///< the enumerator that replaces an unknown number, or null
  std::vector<Step> inner;        ///< the step of an optional value or of items
};

/// The plan of a generated struct, which is a dataclass with slots.
struct Plan {
  PyTypeObject* kind = nullptr;
  std::uint64_t fingerprint = 0;
  std::vector<Step> steps;
  std::vector<Py_ssize_t> slots;    ///< byte offset of each member in an object
  std::vector<PyObject*> defaults;  ///< values of members that an older writer may omit
  bool open = false;                ///< members added by a newer writer are skipped
  Py_ssize_t least = 0;             ///< smallest size of a value in bytes
};

/// Calls `act` with a zero of the C++ type that the type code `code` denotes. Returns false for the
/// code `?` and for unknown codes.
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

/// Returns the size in bytes of a number with the type code `code`; 0 if `code` is unknown.
constexpr Py_ssize_t size_of(char code) {
  constexpr std::string_view codes = "?bBhHiIqQfd";
  constexpr Py_ssize_t sizes[] = {1, 1, 1, 2, 2, 4, 4, 8, 8, 4, 8};
  const auto at = codes.find(code);
  return at == codes.npos ? 0 : sizes[at];
}

enum class Frame : std::uint8_t {
  Bare,     ///< the members only
  Message,  ///< the fingerprint, then the members
  Block,    ///< the size, then the members
};

/// Encodes `value`. When the Python codec must encode it, returns null and sets no Python error.
/// @pre the type of `value` is exactly the class of the plan, and not a derived class.
PyObject* encoded(const Plan& plan, PyObject* value, Frame frame);

/// The bytes that are not decoded yet, from `at` to `end`.
struct Input {
  const std::byte* at = nullptr;
  const std::byte* end = nullptr;
  Py_ssize_t remaining() const { return end - at; }
};

/// Decodes a new value. When the Python codec must decode it, returns null and sets no Python
/// error.
PyObject* decoded(const Plan& plan, Input& from);

}  // namespace gecos::python::plans
