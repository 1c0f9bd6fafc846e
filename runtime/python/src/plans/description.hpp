#pragma once

#include <nanobind/nanobind.h>

#include "plans/plan.hpp"

/// From what `gecos.wire.plans` says of a struct to its plan.
namespace gecos::python::plans {

/// Keeps the plan of `kind` for as long as the process lives. `members`: name and step of each, in
/// wire order; `defaults`: of the last ones, where an older writer may leave them out.
/// Throws for a description that is none: a mistake in generated code.
const Plan& describe(nanobind::handle kind, std::uint64_t fingerprint,
                     const nanobind::sequence& members, const nanobind::sequence& defaults,
                     bool open);

/// The plan of a type; null when it has none.
const Plan* plan_of(PyTypeObject* kind);

/// Where a slot of `kind` is in its objects.
Py_ssize_t slot_of(nanobind::handle kind, const char* name);

}  // namespace gecos::python::plans
