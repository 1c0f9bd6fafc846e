#include "plan_arrays.hpp"

#define NPY_NO_DEPRECATED_API NPY_2_0_API_VERSION
#include <numpy/arrayobject.h>

#include "gecos/wire/swap_copy.hpp"

namespace gecos::python::plans {
namespace {

static_assert(sizeof(npy_intp) == sizeof(Py_ssize_t));

/// Imports the C interface of numpy at the first call. Returns whether the import succeeded.
bool numpy_there() {
  static bool there = false;
  if (!there) {
    there = PyArray_ImportNumPyAPI() == 0;
    PyErr_Clear();
  }
  return there;
}

/// Returns whether the program has imported numpy and numpy can be used. Before the import, no
/// numpy arrays exist.
bool numpy_used() {
  static bool used = false;
  if (!used) {
    const Owned name(PyUnicode_FromString("numpy"));
    const Owned numpy(name ? PyImport_GetModule(name.get()) : nullptr);
    used = numpy && numpy_there();
    PyErr_Clear();
  }
  return used;
}

int type_of(char code) {
  switch (code) {
    case '?':
      return NPY_BOOL;
    case 'b':
      return NPY_INT8;
    case 'B':
      return NPY_UINT8;
    case 'h':
      return NPY_INT16;
    case 'H':
      return NPY_UINT16;
    case 'i':
      return NPY_INT32;
    case 'I':
      return NPY_UINT32;
    case 'q':
      return NPY_INT64;
    case 'Q':
      return NPY_UINT64;
    case 'f':
      return NPY_FLOAT32;
    default:
      return NPY_FLOAT64;
  }
}

}  // namespace

std::optional<Numbers> numbers_of(PyObject* object, char code) {
  if (!numpy_used() || !PyArray_CheckExact(object)) return std::nullopt;
  auto* const array = reinterpret_cast<PyArrayObject*>(object);
  if (PyArray_TYPE(array) != type_of(code) || !PyArray_ISCARRAY_RO(array)) return std::nullopt;
  return Numbers{static_cast<const std::byte*>(PyArray_DATA(array)),
                 PyArray_SIZE(array),
                 {PyArray_DIMS(array), static_cast<std::size_t>(PyArray_NDIM(array))}};
}

void swap_numbers(char code, std::byte* to, const std::byte* from, Py_ssize_t count) {
  const auto many = static_cast<std::size_t>(count);
  switch (size_of(code)) {
    case 1:
      return wire::swap_copy<1>(to, from, many);
    case 2:
      return wire::swap_copy<2>(to, from, many);
    case 4:
      return wire::swap_copy<4>(to, from, many);
    default:
      return wire::swap_copy<8>(to, from, many);
  }
}

PyObject* array_of(const Step& step, Py_ssize_t count, const std::byte* from) {
  if (!numpy_there()) return nullptr;
  const bool counted = step.what == What::Numbers;
  const int dimensions = counted ? 1 : static_cast<int>(step.shape.size());
  PyObject* const made =
      PyArray_SimpleNew(dimensions, counted ? &count : step.shape.data(), type_of(step.code));
  if (made == nullptr) return nullptr;
  auto* const data = static_cast<std::byte*>(PyArray_DATA(reinterpret_cast<PyArrayObject*>(made)));
  swap_numbers(step.code, data, from, count);
  return made;
}

}  // namespace gecos::python::plans
