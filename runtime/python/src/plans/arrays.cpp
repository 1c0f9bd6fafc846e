#include "plans/arrays.hpp"

#include <nanobind/nanobind.h>

#include <array>
#include <string_view>

#include "gecos/wire/swap_copy.hpp"

namespace gecos::python::plans {
namespace {

/// numpy's array; null as long as nobody has imported numpy: there is none then.
PyTypeObject* array_type() {
  static PyTypeObject* type = nullptr;
  if (type == nullptr) {
    const Owned name(PyUnicode_FromString("numpy"));
    const Owned numpy(name ? PyImport_GetModule(name.get()) : nullptr);
    if (numpy) {
      type = reinterpret_cast<PyTypeObject*>(PyObject_GetAttrString(numpy.get(), "ndarray"));
    }
    PyErr_Clear();
  }
  return type;
}

/// What the elements of a buffer are called whose code is `code`.
bool is_format(const char* format, char code, Py_ssize_t width) {
  if (format == nullptr || format[0] == '\0' || format[1] != '\0') return false;
  const bool is_signed = code == 'b' || code == 'h' || code == 'i' || code == 'q';
  const bool is_unsigned = code == 'B' || code == 'H' || code == 'I' || code == 'Q';
  constexpr std::string_view signeds = "bhilq", unsigneds = "BHILQ";
  return width == size_of(code) && (is_signed     ? signeds.find(format[0]) != signeds.npos
                                    : is_unsigned ? unsigneds.find(format[0]) != unsigneds.npos
                                                  : format[0] == code);
}

/// What new arrays are made by. Null when it cannot be had.
PyObject* numpy_empty() {
  static PyObject* empty = nullptr;
  if (empty == nullptr) {
    const Owned numpy(PyImport_ImportModule("numpy"));
    if (numpy) empty = PyObject_GetAttrString(numpy.get(), "empty");
    PyErr_Clear();
  }
  return empty;
}

/// numpy's name of a code in the machine's byte order: the one object that arrays have there.
PyObject* dtype_of(char code) {
  static std::array<PyObject*, 128> known{};
  PyObject*& dtype = known.at(static_cast<std::size_t>(code));
  if (dtype == nullptr) {
    const Owned codes(PyImport_ImportModule("gecos.wire.codes"));
    if (codes) dtype = PyObject_CallMethod(codes.get(), "native", "C", code);
    PyErr_Clear();
  }
  return dtype;
}

}  // namespace

bool Memory::open_numbers(PyObject* array, char code) {
  return Py_TYPE(array) == array_type() && open(array, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS) &&
         is_format(view_.format, code, view_.itemsize);
}

void swap_numbers(char code, std::byte* to, const std::byte* from, Py_ssize_t count) {
  const auto many = static_cast<std::size_t>(count);
  switch (size_of(code)) {
    case 1: return wire::swap_copy<1>(to, from, many);
    case 2: return wire::swap_copy<2>(to, from, many);
    case 4: return wire::swap_copy<4>(to, from, many);
    default: return wire::swap_copy<8>(to, from, many);
  }
}

PyObject* array_of(const Step& step, Py_ssize_t count, const std::byte* from) {
  PyObject* const empty = numpy_empty();
  PyObject* const dtype = dtype_of(step.code);
  if (empty == nullptr || dtype == nullptr) return nullptr;
  const Owned shape(step.shape.size() > 1
                        ? PyTuple_New(static_cast<Py_ssize_t>(step.shape.size()))
                        : PyLong_FromSsize_t(count));
  if (!shape) return nullptr;
  for (std::size_t i = 0; step.shape.size() > 1 && i < step.shape.size(); ++i) {
    PyTuple_SET_ITEM(shape.get(), static_cast<Py_ssize_t>(i), PyLong_FromSsize_t(step.shape[i]));
  }
  PyObject* const arguments[] = {shape.get(), dtype};
  Owned array(PyObject_Vectorcall(empty, arguments, 2, nullptr));
  Memory memory;
  if (!array || !memory.open(array.get(), PyBUF_WRITABLE)) return nullptr;
  swap_numbers(step.code, memory.data(), from, count);
  return array.release();
}

}  // namespace gecos::python::plans
