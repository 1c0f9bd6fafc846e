#pragma once

#include <sys/types.h>
#include <unistd.h>

#include <atomic>
#include <memory>

namespace gecos {

/// An object that exists once in each process. A forked child makes a new object, because the
/// object of its parent describes the parent, and because a thread of the parent may have held a
/// mutex of that object. Must have static storage duration.
template <class T>
class PerProcess {
 public:
  constexpr PerProcess() = default;
  PerProcess(const PerProcess&) = delete;
  PerProcess& operator=(const PerProcess&) = delete;

  /// Returns the object of this process. The first call makes the object, and throws what the
  /// constructor of T throws. The object is never destroyed. Any thread may call this function.
  T& get() {
    Made* known = newest_.load();
    while (known == nullptr || known->owner != ::getpid()) {
      auto made = std::make_unique<Made>(known);
      if (newest_.compare_exchange_strong(known, made.get())) known = made.release();
    }
    return known->object;
  }

 private:
  struct Made {
    explicit Made(const Made* parents) : of_parent(parents) {}

    const pid_t owner = ::getpid();
    /// The object of the process that forked this process. The object is not used. The pointer
    /// keeps the object reachable, so that leak checkers do not report a leak.
    const Made* const of_parent;
    T object;
  };

  std::atomic<Made*> newest_{nullptr};  // publishes the object that it points to
};

}  // namespace gecos
