#pragma once

#include <nanobind/nanobind.h>

#include "gecos/base/bytes.hpp"

namespace gecos::python {

inline nanobind::bytes to_python(ByteView bytes) {
  return nanobind::bytes(reinterpret_cast<const char*>(bytes.data()), bytes.size());
}

/// Returns a view of the contents of `bytes`. The view is valid as long as `bytes` lives.
inline ByteView from_python(const nanobind::bytes& bytes) {
  return {reinterpret_cast<const std::byte*>(bytes.c_str()), bytes.size()};
}

}  // namespace gecos::python
