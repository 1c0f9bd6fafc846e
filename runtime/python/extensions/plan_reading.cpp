#include <cstring>

#include "gecos/wire/swap_copy.hpp"
#include "plan.hpp"
#include "plan_arrays.hpp"

namespace gecos::python::plans {
namespace {

PyObject* taken(Input& from, const Step& step);

/// Returns the next `size` bytes and advances `from`; null if there are fewer bytes.
const std::byte* next(Input& from, Py_ssize_t size) {
  if (size > from.remaining()) return nullptr;
  const std::byte* const at = from.at;
  from.at += size;
  return at;
}

template <class T>
bool take(Input& from, T& x) {
  const std::byte* const at = next(from, sizeof x);
  if (at != nullptr) x = wire::load_big_endian<T>(at);
  return at != nullptr;
}

PyObject* taken_double(Input& from) {
  double x = 0;
  return take(from, x) ? PyFloat_FromDouble(x) : nullptr;
}

PyObject* taken_number(Input& from, char code, const Limits& limits) {
  if (code == '?') {
    std::uint8_t bit = 0;
    return take(from, bit) && bit <= 1 ? PyBool_FromLong(bit) : nullptr;
  }
  PyObject* made = nullptr;
  with_number_of(code, [&](auto x) {
    using T = decltype(x);
    if (!take(from, x) || !limits.hold(x)) return false;
    if constexpr (std::is_floating_point_v<T>) {
      made = PyFloat_FromDouble(static_cast<double>(x));
    } else if constexpr (std::is_unsigned_v<T>) {
      made = PyLong_FromUnsignedLongLong(x);
    } else {
      made = PyLong_FromLongLong(x);
    }
    return true;
  });
  return made;
}

PyObject* taken_enumerator(Input& from, const Step& step) {
  const Owned number(taken_number(from, step.code, step.limits));
  if (!number) return nullptr;
  PyObject* found = PyDict_GetItemWithError(step.known, number.get());
  if (found == nullptr) found = step.otherwise;
  Py_XINCREF(found);
  return found;
}

/// Decodes the number of elements that follow. Returns -1 if the number is invalid or too few bytes
/// follow; the Python codec then reports the error.
Py_ssize_t taken_count(Input& from, const Step& step) {
  std::int32_t count = 0;
  if (step.size >= 0) {
    count = static_cast<std::int32_t>(step.size);
  } else if (!take(from, count) || count < 0 || count > step.most) {
    return -1;
  }
  return count * step.least <= from.remaining() ? count : -1;
}

bool are_well(const Step& step, const std::byte* at, Py_ssize_t count) {
  for (Py_ssize_t i = 0; step.code == '?' && i < count; ++i) {
    if (at[i] > std::byte{1}) return false;
  }
  for (Py_ssize_t i = 0; step.limits.there && i < count; ++i) {
    if (!step.limits.hold(wire::load_big_endian<double>(at + 8 * i))) return false;
  }
  return true;
}

PyObject* taken_numbers(Input& from, const Step& step) {
  const Py_ssize_t count = taken_count(from, step);
  const std::byte* const at = count < 0 ? nullptr : next(from, count * step.least);
  return at != nullptr && are_well(step, at, count) ? array_of(step, count, at) : nullptr;
}

PyObject* taken_text(Input& from, const Step& step) {
  std::int32_t size = 0;
  if (!take(from, size) || size < 1 || size - 1 > step.most) return nullptr;
  const std::byte* const at = next(from, size);
  if (at == nullptr) return nullptr;
  const char* const text = reinterpret_cast<const char*>(at);
  if (std::memchr(text, 0, static_cast<std::size_t>(size)) != text + size - 1) return nullptr;
  return PyUnicode_DecodeUTF8(text, size - 1, nullptr);
}

PyObject* taken_octets(Input& from, const Step& step) {
  const Py_ssize_t count = taken_count(from, step);
  const std::byte* const at = count < 0 ? nullptr : next(from, count);
  if (at == nullptr) return nullptr;
  return PyBytes_FromStringAndSize(reinterpret_cast<const char*>(at), count);
}

PyObject* taken_block(Input& from, const Step& step) {
  std::int32_t size = 0;
  if (!take(from, size) || size < 0) return nullptr;
  const std::byte* const at = next(from, size);
  if (at == nullptr) return nullptr;
  Input inside{at, from.at};
  return decoded(*step.plan, inside);
}

PyObject* taken_optional(Input& from, const Step& step) {
  std::uint8_t bit = 0;
  if (!take(from, bit) || bit > 1) return nullptr;
  return bit == 1 ? taken(from, step.inner.front()) : Py_NewRef(Py_None);
}

PyObject* taken_items(Input& from, const Step& step) {
  const Py_ssize_t count = taken_count(from, step);
  Owned list(count < 0 ? nullptr : PyList_New(0));
  for (Py_ssize_t i = 0; list && i < count; ++i) {
    const Owned each(taken(from, step.inner.front()));
    if (!each || PyList_Append(list.get(), each.get()) != 0) return nullptr;
  }
  return list.release();
}

/// Decodes the next member. Returns null when the Python codec must decode it; a Python error may
/// then be set.
PyObject* taken(Input& from, const Step& step) {
  switch (step.what) {
    case What::Double:
      return taken_double(from);
    case What::Number:
      return taken_number(from, step.code, step.limits);
    case What::Enumerator:
      return taken_enumerator(from, step);
    case What::Array:
    case What::Numbers:
      return taken_numbers(from, step);
    case What::Text:
      return taken_text(from, step);
    case What::Octets:
      return taken_octets(from, step);
    case What::Struct:
      return decoded(*step.plan, from);
    case What::Block:
      return taken_block(from, step);
    case What::Optional:
      return taken_optional(from, step);
    case What::Items:
      return taken_items(from, step);
  }
  return nullptr;
}

}  // namespace

PyObject* decoded(const Plan& plan, Input& from) {
  Owned value(plan.kind->tp_alloc(plan.kind, 0));
  if (!value) PyErr_Clear();
  const std::size_t required = plan.steps.size() - plan.defaults.size();
  for (std::size_t i = 0; value && i < plan.steps.size(); ++i) {
    const bool missing = i >= required && from.remaining() == 0;
    const Step& step = plan.steps[i];
    PyObject* const member = missing                     ? Py_NewRef(plan.defaults[i - required])
                             : step.what == What::Double ? taken_double(from)
                                                         : taken(from, step);
    if (member == nullptr) {
      PyErr_Clear();
      return nullptr;
    }
    *reinterpret_cast<PyObject**>(reinterpret_cast<char*>(value.get()) + plan.slots[i]) = member;
  }
  if (plan.open) from.at = from.end;
  return value.release();
}

}  // namespace gecos::python::plans
