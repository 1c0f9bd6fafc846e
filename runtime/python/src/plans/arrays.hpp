#pragma once

#include <Python.h>

#include <cstddef>
#include <utility>

#include "plans/plan.hpp"

/// Arrays of numpy, by the protocol of buffers: nothing here is built against numpy.
namespace gecos::python::plans {

/// A new reference that this owns.
class Owned {
 public:
  Owned() = default;
  explicit Owned(PyObject* object) : object_(object) {}
  Owned(Owned&& other) noexcept : object_(std::exchange(other.object_, nullptr)) {}
  Owned& operator=(Owned&&) = delete;
  ~Owned() { Py_XDECREF(object_); }
  explicit operator bool() const { return object_ != nullptr; }
  PyObject* get() const { return object_; }
  PyObject* release() { return std::exchange(object_, nullptr); }

 private:
  PyObject* object_ = nullptr;
};

/// The memory of an object for as long as this lives.
class Memory {
 public:
  Memory() = default;
  Memory(const Memory&) = delete;
  Memory& operator=(const Memory&) = delete;
  ~Memory() {
    if (view_.obj != nullptr) PyBuffer_Release(&view_);
  }

  /// False, with no error set, when it cannot be had so.
  bool open(PyObject* object, int flags) {
    if (PyObject_GetBuffer(object, &view_, flags) == 0) return true;
    PyErr_Clear();
    view_.obj = nullptr;
    return false;
  }
  /// An array of numpy in C order whose elements are those of `code`, in the machine's byte order.
  bool open_numbers(PyObject* array, char code);

  std::byte* data() const { return static_cast<std::byte*>(view_.buf); }
  const Py_buffer& view() const { return view_; }

 private:
  Py_buffer view_{};
};

/// Copies numbers to or from the wire.
void swap_numbers(char code, std::byte* to, const std::byte* from, Py_ssize_t count);

/// Reads so many numbers, which are there, into a new array of the shape of `step`; null when they
/// must be left to Python.
PyObject* array_of(const Step& step, Py_ssize_t count, const std::byte* from);

}  // namespace gecos::python::plans
