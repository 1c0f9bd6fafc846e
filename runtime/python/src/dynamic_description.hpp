#pragma once

#include <nanobind/nanobind.h>

#include "gecos/description.hpp"

namespace gecos::python {

/// The session's table of an interface that generated Python describes
/// (`gecos.interface.Interface`).
///
/// Made once per interface and kept until the process ends, as the tables of generated C++ are:
/// what refers to one, a session, a command, a server, need not ask how long.
const InterfaceDescription& description_of(nanobind::handle interface);

}  // namespace gecos::python
