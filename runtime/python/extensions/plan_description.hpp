#pragma once

#include <nanobind/nanobind.h>

#include "plan.hpp"

/// Functions that make plans from the descriptions of structs that `gecos.wire.plans` gives.
namespace gecos::python::plans {

/// Makes the plan of the struct `kind` and keeps it until the process ends. `members` are the names
/// and steps of the members in the order of encoding. `defaults` are the values of the last
/// members, which an older writer may omit. Throws for an invalid description, which is a mistake
/// in generated code.
const Plan& describe(nanobind::handle kind, std::uint64_t fingerprint,
                     const nanobind::sequence& members, const nanobind::sequence& defaults,
                     bool open);

/// Returns the plan of a type; null when the type has no plan.
const Plan* plan_of(PyTypeObject* kind);

/// Returns the byte offset of the slot `name` in the objects of the class `kind`.
Py_ssize_t slot_of(nanobind::handle kind, const char* name);

}  // namespace gecos::python::plans
