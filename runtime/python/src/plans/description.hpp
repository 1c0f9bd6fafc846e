#pragma once

#include <nanobind/nanobind.h>

#include "plans/plan.hpp"

/// Builds plans from the descriptions of structs by `gecos.wire.plans`.
namespace gecos::python::plans {

/// Builds the plan of `kind` and keeps it until the process ends. `members` are the names and steps
/// in wire order; `defaults` are the values of the last members, which an older writer may omit.
/// Throws for an invalid description, which is a mistake in generated code.
const Plan& describe(nanobind::handle kind, std::uint64_t fingerprint,
                     const nanobind::sequence& members, const nanobind::sequence& defaults,
                     bool open);

/// The plan of a type; null when it has none.
const Plan* plan_of(PyTypeObject* kind);

/// Byte offset of the slot `name` in the objects of `kind`.
Py_ssize_t slot_of(nanobind::handle kind, const char* name);

}  // namespace gecos::python::plans
