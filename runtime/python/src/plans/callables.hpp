#pragma once

#include <Python.h>

#include "plans/plan.hpp"

/// What stands in the place of functions of Python: each does the usual case, and calls the
/// function that it stands for, its `__wrapped__`, for the rest.
namespace gecos::python::plans {

/// Once: the types of the objects below, and where `gecos.wire.Decoder` keeps its members. False
/// with an error set.
bool prepare_callables(PyObject* decoder);

/// `encode` of a struct: a method.
PyObject* encoding(const Plan& plan, PyObject* python);
/// `decode` of a struct: a class method.
PyObject* decoding(const Plan& plan, PyObject* python);
/// The function of `gecos.wire` with this name, for every type that has a plan. Null with an error
/// set.
PyObject* entry(const char* name, PyObject* python);

}  // namespace gecos::python::plans
