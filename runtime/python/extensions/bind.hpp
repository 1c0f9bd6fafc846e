#pragma once

#include <nanobind/nanobind.h>

/// Functions that define the Python classes of the module `_core`.
namespace gecos::python {

void bind_client(nanobind::module_& module);
void bind_lab_file(nanobind::module_& module);
void bind_server(nanobind::module_& module);
void bind_this_user(nanobind::module_& module);

}  // namespace gecos::python
