#pragma once

#include <nanobind/nanobind.h>

#include "gecos/description.hpp"

namespace gecos::python {

/// Returns the C++ description of an interface that generated Python code describes
/// (`gecos.interface.Interface`).
///
/// The description of an interface is made only once and is kept until the process ends, like the
/// descriptions in generated C++ code. Therefore sessions, commands and servers may keep references
/// to it.
const InterfaceDescription& description_of(nanobind::handle interface);

}  // namespace gecos::python
