#pragma once

#include <Python.h>

#include "plan.hpp"

/// Callables that replace Python functions. A callable handles only the usual case. In all other
/// cases it calls the function that it replaced, which is its `__wrapped__`.
namespace gecos::python::plans {

/// Makes the Python types of the callables that the functions below return, and finds the slots of
/// the class `decoder`, which is `gecos.wire.Decoder`. Must be called once, before the other
/// functions. On failure, sets a Python error and returns false.
bool prepare_callables(PyObject* decoder);

/// Makes the method `encode` of a struct. The method replaces the Python function `python`.
PyObject* encoding(const Plan& plan, PyObject* python);
/// Makes the class method `decode` of a struct. The method replaces the Python function `python`.
PyObject* decoding(const Plan& plan, PyObject* python);
/// Makes a function that decodes a value of one struct from the beginning of bytes. The function
/// replaces the Python function `python`. `decode` is the class method `decode` of the struct. If
/// decoding() has not made this class method, there is no plan, and `python` itself is returned.
PyObject* from_start(PyObject* decode, PyObject* python);
/// Makes the compiled form of the function `name` of `gecos.wire`, for example "to_bytes". The
/// compiled form handles values of all types that have a plan, and replaces the Python function
/// `python`. On failure, sets a Python error and returns null.
PyObject* entry(const char* name, PyObject* python);

}  // namespace gecos::python::plans
