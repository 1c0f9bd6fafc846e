#pragma once

#include <Python.h>

#include "plans/plan.hpp"

/// Callables that replace Python functions: each handles the usual case and calls the replaced
/// function, its `__wrapped__`, for the rest.
namespace gecos::python::plans {

/// Must be called once, before the other functions: prepares the types of their results and finds
/// the slots of `gecos.wire.Decoder`. Returns false with an error set on failure.
bool prepare_callables(PyObject* decoder);

/// Makes the method `encode` of a struct, which replaces the function `python`.
PyObject* encoding(const Plan& plan, PyObject* python);
/// Makes the class method `decode` of a struct, which replaces the function `python`.
PyObject* decoding(const Plan& plan, PyObject* python);
/// Makes the function `name` of `gecos.wire` for all types with a plan; it replaces `python`. Null
/// with an error set on failure.
PyObject* entry(const char* name, PyObject* python);

}  // namespace gecos::python::plans
