#pragma once

#include <nanobind/nanobind.h>

#include <cstddef>
#include <span>

namespace gecos::python {

/// Makes Python see an object as a buffer: `memoryview(object)` views `object.buffer()`, and keeps
/// the object alive. `Handle::writable` says whether Python may write into the buffer.
template <class Handle>
struct BufferSlots {
  static int get(PyObject* object, Py_buffer* view, int flags) {
    const std::span<std::byte> bytes = nanobind::inst_ptr<Handle>(object)->buffer();
    return PyBuffer_FillInfo(view, object, bytes.data(), static_cast<Py_ssize_t>(bytes.size()),
                             Handle::writable ? 0 : 1, flags);
  }
  static inline PyType_Slot slots[] = {{Py_bf_getbuffer, reinterpret_cast<void*>(&get)},
                                       {0, nullptr}};
};

}  // namespace gecos::python
