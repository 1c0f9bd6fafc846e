#pragma once

#include <Python.h>
#include <unistd.h>

/// The GIL, let go of for a moment. The only way to do so here.
namespace gecos::python {

/// Without the GIL as long as it lives, which begins where the GIL is held.
///
/// A daemon thread that wants the GIL back while the interpreter ends does not get it: up to
/// CPython 3.13 the interpreter ends the thread instead, and unwinds its stack to do so. That must
/// not reach the thread that waits here: frames that let no exception through would end the process
/// by std::terminate, and others would let go of Python's objects without the GIL. So the thread
/// stays here until the process has ended, as CPython from 3.14 on lets it do itself.
class WithoutGil {
 public:
  WithoutGil() : state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    try {
      PyEval_RestoreThread(state_);
    } catch (...) {  // nothing of C++ is thrown: the thread is being ended
      for (;;) ::pause();
    }
  }

 private:
  PyThreadState* state_;
};

}  // namespace gecos::python
