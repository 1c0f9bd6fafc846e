#pragma once

#include <Python.h>
#include <unistd.h>

/// The class WithoutGil. The code of this Python module may release the GIL only with this class.
namespace gecos::python {

/// Releases the GIL while this object lives. @pre the calling thread holds the GIL.
///
/// While the interpreter ends, a daemon thread cannot take the GIL again. Up to CPython 3.13, the
/// interpreter then ends the thread by unwinding its stack. This unwinding must not leave the
/// destructor of this class: a noexcept function on the stack would end the process by
/// std::terminate, and other functions would release Python objects without the GIL. Therefore the
/// thread pauses in the destructor until the process has ended. CPython 3.14 and later versions do
/// the same.
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
