#pragma once

#include <memory>
#include <type_traits>
#include <utility>

namespace gecos {

template <class Signature>
class FunctionRef;

/// A borrowed callable. Use it as the type of a parameter that a function calls only before it
/// returns. Has the size of two pointers, and allocates nothing. Must not be stored.
template <class R, class... Args>
class FunctionRef<R(Args...)> {
 public:
  template <class F>
  requires(!std::is_same_v<std::remove_cvref_t<F>, FunctionRef>)
      FunctionRef(F&& callable)  // NOLINT(google-explicit-constructor): made to be passed a lambda
      : target_(const_cast<void*>(static_cast<const void*>(std::addressof(callable)))),
        call_([](void* target, Args... args) -> R {
          return (*static_cast<std::remove_reference_t<F>*>(target))(std::forward<Args>(args)...);
        }) {}

  R operator()(Args... args) const { return call_(target_, std::forward<Args>(args)...); }

 private:
  void* target_;
  R (*call_)(void*, Args...);
};

}  // namespace gecos
