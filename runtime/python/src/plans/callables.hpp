#pragma once

#include <Python.h>

#include "plans/plan.hpp"

/// Callables that replace Python functions: each handles the usual case and calls the replaced
/// function, its `__wrapped__`, for the rest.
namespace gecos::python::plans {

/// Must be called once, first: prepares the types of the objects below and finds the slots of
/// `gecos.wire.Decoder`. Returns false with an error set on failure.
bool prepare_callables(PyObject* decoder);

/// `encode` of a struct: a method.
PyObject* encoding(const Plan& plan, PyObject* python);
/// `decode` of a struct: a class method.
PyObject* decoding(const Plan& plan, PyObject* python);
/// The function of `gecos.wire` with this name, for every type that has a plan. Null with an error
/// set.
PyObject* entry(const char* name, PyObject* python);

}  // namespace gecos::python::plans
