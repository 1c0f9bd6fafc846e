#pragma once

#include <Python.h>
#include <unistd.h>

/// The only class with which this module may release the GIL.
namespace gecos::python {

/// Releases the GIL for its lifetime. @pre the GIL is held.
///
/// A daemon thread that wants the GIL back while the interpreter ends does not get it: up to
/// CPython 3.13 the interpreter ends the thread instead, by unwinding its stack. The unwinding must
/// not leave this destructor: noexcept frames would end the process by std::terminate, and others
/// would release Python objects without the GIL. So the thread pauses here until the process has
/// ended, as CPython itself does from 3.14 on.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {  // not a C++ exception: the thread is being ended
      for (;;) ::pause();
    }
  }

 private:
  PyThreadState* state_;
};

}  // namespace gecos::python
