#pragma once

#include <Python.h>

#include <cstddef>
#include <optional>
#include <span>
#include <utility>

#include "plans/plan.hpp"

/// Reading and writing of numpy arrays. numpy's C interface is loaded with the first array.
namespace gecos::python::plans {

/// Owns one reference to a Python object, or null.
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

/// The elements of a numpy array, in C order and the machine's byte order; the array owns them.
struct Numbers {
  const std::byte* data = nullptr;
  Py_ssize_t count = 0;
  std::span<const Py_ssize_t> shape;
};

/// The elements of `object`; nullopt unless it is a numpy array with the type code `code`, in C
/// order and the machine's byte order.
std::optional<Numbers> numbers_of(PyObject* object, char code);

/// Copies `count` numbers between the machine's and the wire's byte order.
void swap_numbers(char code, std::byte* to, const std::byte* from, Py_ssize_t count);

/// Reads `count` numbers into a new array of the shape of `step`; null when the Python codec must
/// read them. @pre `from` has the bytes of `count` numbers.
PyObject* array_of(const Step& step, Py_ssize_t count, const std::byte* from);

}  // namespace gecos::python::plans
