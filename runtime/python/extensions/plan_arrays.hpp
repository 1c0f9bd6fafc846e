#pragma once

#include <Python.h>

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "plan.hpp"

/// Functions that read and write numpy arrays. The C interface of numpy is loaded for the first
/// array.
namespace gecos::python::plans {

/// Owns one reference to a Python object, or holds null.
class Owned {
 public:
  explicit Owned(PyObject* object) : object_(object) {}
  Owned(const Owned&) = delete;
  Owned& operator=(const Owned&) = delete;
  ~Owned() { Py_XDECREF(object_); }
  explicit operator bool() const { return object_ != nullptr; }
  PyObject* get() const { return object_; }
  PyObject* release() { return std::exchange(object_, nullptr); }

 private:
  PyObject* object_ = nullptr;
};

/// A view of the elements of a numpy array. The array owns the elements. The elements are in C
/// order and in the machine's byte order.
struct Numbers {
  const std::byte* data = nullptr;
  Py_ssize_t count = 0;
  std::span<const Py_ssize_t> shape;
};

/// Returns the elements of `object` if it is a numpy array whose type code is `code` and whose
/// elements are in C order and in the machine's byte order. Otherwise returns nullopt.
std::optional<Numbers> numbers_of(PyObject* object, char code);

/// Copies `count` numbers and converts them between the machine's byte order and the byte order of
/// encoded values.
void swap_numbers(char code, std::byte* to, const std::byte* from, Py_ssize_t count);

/// Reads `count` numbers into a new array that has the shape of `step`. Returns null when the
/// Python codec must read them. @pre `from` has the bytes of `count` numbers.
PyObject* array_of(const Step& step, Py_ssize_t count, const std::byte* from);

}  // namespace gecos::python::plans
