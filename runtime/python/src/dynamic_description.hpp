#pragma once

#include <nanobind/nanobind.h>

#include "gecos/description.hpp"

namespace gecos::python {

/// The session's table of an interface that generated Python describes
/// (`gecos.interface.Interface`).
///
/// Each table is made once per interface and kept until the process ends, like the tables of
/// generated C++, so sessions, commands and servers may keep references to it.
const InterfaceDescription& description_of(nanobind::handle interface);

}  // namespace gecos::python
