#pragma once

#include <nanobind/nanobind.h>

/// The parts that make up the module.
namespace gecos::python {

void bind_client(nanobind::module_& module);
void bind_server(nanobind::module_& module);

}  // namespace gecos::python
