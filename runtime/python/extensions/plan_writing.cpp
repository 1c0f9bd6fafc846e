#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <utility>

#include "gecos/wire/swap_copy.hpp"
#include "plan.hpp"
#include "plan_arrays.hpp"

namespace gecos::python::plans {
namespace {

constexpr std::int64_t exact_in_double = std::int64_t{1} << 53;

/// A buffer that grows and becomes a Python bytes object.
class Output {
 public:
  explicit Output(Py_ssize_t expected)
      : bytes_(PyBytes_FromStringAndSize(nullptr, std::max<Py_ssize_t>(expected, 1))),
        capacity_(bytes_ == nullptr ? 0 : std::max<Py_ssize_t>(expected, 1)) {}
  Output(const Output&) = delete;
  Output& operator=(const Output&) = delete;
  ~Output() { Py_XDECREF(bytes_); }

  /// Reserves `size` bytes at the end of the buffer and returns them; null if there is not enough
  /// memory.
  std::byte* room(Py_ssize_t size) {
    if (size > capacity_ - used_ && !grow(size)) return nullptr;
    std::byte* const at = data() + used_;
    used_ += size;
    return at;
  }
  template <class T>
  bool put(T value) {
    std::byte* const at = room(sizeof value);
    if (at != nullptr) wire::store_big_endian(at, value);
    return at != nullptr;
  }
  bool put_bytes(const void* from, Py_ssize_t size) {
    std::byte* const at = room(size);
    if (at != nullptr) std::memcpy(at, from, static_cast<std::size_t>(size));
    return at != nullptr;
  }
  Py_ssize_t used() const { return used_; }
  std::byte* data() const { return reinterpret_cast<std::byte*>(PyBytes_AS_STRING(bytes_)); }
  PyObject* finished() {
    if (used_ != capacity_) _PyBytes_Resize(&bytes_, used_);
    return std::exchange(bytes_, nullptr);
  }

 private:
  bool grow(Py_ssize_t size) {
    if (bytes_ == nullptr || size > std::numeric_limits<Py_ssize_t>::max() / 2 - used_)
      return false;
    const Py_ssize_t wanted = std::max(2 * capacity_, used_ + size);
    const bool grown = _PyBytes_Resize(&bytes_, wanted) == 0;  // frees the bytes on failure
    capacity_ = grown ? wanted : 0;
    return grown;
  }

  PyObject* bytes_;
  Py_ssize_t capacity_;
  Py_ssize_t used_ = 0;
};

bool put_all(Output& out, const Plan& plan, PyObject* value);

/// Converts `value` to a double. `value` must be a float, or an int that a double can represent
/// exactly. If the member has limits, objects of classes derived from float are refused, because
/// such a class may define other comparisons with the limits.
bool as_double(PyObject* value, bool limited, double& x) {
  if (PyFloat_CheckExact(value) || (!limited && PyFloat_Check(value))) {
    x = PyFloat_AS_DOUBLE(value);
    return true;
  }
  if (!PyLong_CheckExact(value)) return false;
  int overflow = 0;
  const long long whole = PyLong_AsLongLongAndOverflow(value, &overflow);
  x = static_cast<double>(whole);
  return overflow == 0 && -exact_in_double <= whole && whole <= exact_in_double;
}

template <class T>
bool as_number(PyObject* value, const Limits& limits, T& x) {
  if constexpr (std::is_floating_point_v<T>) {
    double wide = 0;
    if (!as_double(value, limits.there, wide) || !limits.hold(wide)) return false;
    x = static_cast<T>(wide);
    return std::isfinite(x) || !std::isfinite(wide);  // else the value is too great for a float
  } else {
    if (!PyLong_CheckExact(value) && (limits.there || !PyLong_Check(value))) return false;
    if constexpr (std::is_same_v<T, std::uint64_t>) {
      x = PyLong_AsUnsignedLongLong(value);
      return x != static_cast<T>(-1) || PyErr_Occurred() == nullptr;
    } else {
      int overflow = 0;
      const long long whole = PyLong_AsLongLongAndOverflow(value, &overflow);
      x = static_cast<T>(whole);
      return overflow == 0 && static_cast<long long>(x) == whole && limits.hold(whole);
    }
  }
}

bool put_double(Output& out, PyObject* value) {
  if (PyFloat_CheckExact(value)) return out.put(PyFloat_AS_DOUBLE(value));
  double x = 0;
  return as_double(value, false, x) && out.put(x);
}

bool put_number(Output& out, char code, const Limits& limits, PyObject* value) {
  if (code == '?') {
    return (value == Py_True || value == Py_False) && out.put(std::uint8_t{value == Py_True});
  }
  return with_number_of(code, [&](auto x) { return as_number(value, limits, x) && out.put(x); });
}

bool put_count(Output& out, const Step& step, Py_ssize_t count) {
  if (step.size >= 0) return count == step.size;
  return count <= step.most && out.put(static_cast<std::int32_t>(count));
}

bool all_within(const Step& step, const std::byte* numbers, Py_ssize_t count) {
  if (!step.limits.there) return true;
  const auto* const first = reinterpret_cast<const double*>(numbers);  // only doubles have limits
  return std::all_of(first, first + count, [&](double x) { return step.limits.hold(x); });
}

/// Encodes a list of floats for a member whose values are numpy arrays.
bool put_list(Output& out, const Step& step, PyObject* list) {
  if (!PyList_CheckExact(list) || step.code != 'd' || step.shape.size() > 1) return false;
  const Py_ssize_t count = PyList_GET_SIZE(list);
  if (!put_count(out, step, count)) return false;
  std::byte* at = out.room(count * 8);
  if (at == nullptr) return false;
  for (Py_ssize_t i = 0; i < count; ++i, at += 8) {
    PyObject* const each = PyList_GET_ITEM(list, i);
    if (!PyFloat_CheckExact(each) || !step.limits.hold(PyFloat_AS_DOUBLE(each))) return false;
    wire::store_big_endian(at, PyFloat_AS_DOUBLE(each));
  }
  return true;
}

bool put_numbers(Output& out, const Step& step, PyObject* value) {
  const std::optional<Numbers> given = numbers_of(value, step.code);
  if (!given) return put_list(out, step, value);
  const bool fits = step.what == What::Numbers
                        ? given->shape.size() == 1
                        : std::equal(step.shape.begin(), step.shape.end(), given->shape.begin(),
                                     given->shape.end());
  if (!fits || !all_within(step, given->data, given->count)) return false;
  if (!put_count(out, step, given->count)) return false;
  std::byte* const at = out.room(given->count * step.least);
  if (at == nullptr) return false;
  swap_numbers(step.code, at, given->data, given->count);
  return true;
}

bool put_text(Output& out, const Step& step, PyObject* value) {
  if (!PyUnicode_CheckExact(value)) return false;
  Py_ssize_t size = 0;
  const char* const text = PyUnicode_AsUTF8AndSize(value, &size);
  return text != nullptr && size <= step.most &&
         std::memchr(text, 0, static_cast<std::size_t>(size)) == nullptr &&
         out.put(static_cast<std::int32_t>(size + 1)) && out.put_bytes(text, size + 1);
}

bool put_block(Output& out, const Plan& plan, PyObject* value) {
  const Py_ssize_t start = out.used();
  if (!out.put(std::int32_t{0}) || !put_all(out, plan, value)) return false;
  const Py_ssize_t size = out.used() - start - 4;
  if (size > std::numeric_limits<std::int32_t>::max()) return false;
  wire::store_big_endian(out.data() + start, static_cast<std::int32_t>(size));
  return true;
}

bool put(Output& out, const Step& step, PyObject* value);

bool put_items(Output& out, const Step& step, PyObject* value) {
  if (!PyList_CheckExact(value)) return false;
  if (!put_count(out, step, PyList_GET_SIZE(value))) return false;
  for (Py_ssize_t i = 0; i < PyList_GET_SIZE(value); ++i) {
    if (!put(out, step.inner.front(), PyList_GET_ITEM(value, i))) return false;
  }
  return true;
}

/// Encodes a member. Returns false when the Python codec must encode it; a Python error may then be
/// set. No Python code runs meanwhile, so that borrowed references stay valid.
bool put(Output& out, const Step& step, PyObject* value) {
  switch (step.what) {
    case What::Double:
      return put_double(out, value);
    case What::Number:
      return put_number(out, step.code, step.limits, value);
    case What::Enumerator:
      return Py_TYPE(value) == step.kind && put_number(out, step.code, step.limits, value);
    case What::Array:
    case What::Numbers:
      return put_numbers(out, step, value);
    case What::Text:
      return put_text(out, step, value);
    case What::Octets:
      return PyBytes_CheckExact(value) && put_count(out, step, PyBytes_GET_SIZE(value)) &&
             out.put_bytes(PyBytes_AS_STRING(value), PyBytes_GET_SIZE(value));
    case What::Struct:
      return Py_TYPE(value) == step.plan->kind && put_all(out, *step.plan, value);
    case What::Block:
      return Py_TYPE(value) == step.plan->kind && put_block(out, *step.plan, value);
    case What::Optional:
      return out.put(std::uint8_t{value != Py_None}) &&
             (value == Py_None || put(out, step.inner.front(), value));
    case What::Items:
      return put_items(out, step, value);
  }
  return false;
}

/// Encodes all members of `value`. @pre the type of `value` is exactly the class of the plan, and
/// not a derived class.
bool put_all(Output& out, const Plan& plan, PyObject* value) {
  for (std::size_t i = 0; i < plan.steps.size(); ++i) {
    PyObject* const member =
        *reinterpret_cast<PyObject**>(reinterpret_cast<char*>(value) + plan.slots[i]);
    if (member == nullptr) return false;
    const Step& step = plan.steps[i];
    if (!(step.what == What::Double ? put_double(out, member) : put(out, step, member)))
      return false;
  }
  return true;
}

}  // namespace

PyObject* encoded(const Plan& plan, PyObject* value, Frame frame) {
  Output out(plan.least + 8);
  const bool well = frame == Frame::Block ? put_block(out, plan, value)
                    : frame == Frame::Message
                        ? out.put(plan.fingerprint) && put_all(out, plan, value)
                        : put_all(out, plan, value);
  if (well) return out.finished();
  PyErr_Clear();
  return nullptr;
}

}  // namespace gecos::python::plans
