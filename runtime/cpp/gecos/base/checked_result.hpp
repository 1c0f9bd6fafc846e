// A type that holds the result of an operation or its error. If a program uses the result although
// there is an error, the program ends.
#pragma once

#include <sstream>
#include <string>
#include <utility>

#include "gecos/base/result.hpp"

namespace gecos {

/// Logs `why`, the text of an error, and aborts the program. Called when the program uses a result
/// that holds this error.
[[noreturn]] void used_unchecked(const std::string& why);

/// A `tl::expected` that checks each access. When it holds an error, `*result` and `result->…` end
/// the program with the text of that error. They do so even in a build with NDEBUG, in which a
/// plain `tl::expected` would read memory that holds no value.
template <class T, class E>
class [[nodiscard]] Checked : public tl::expected<T, E> {
 public:
  using Base = tl::expected<T, E>;
  using Base::Base;
  Checked(Base base) : Base(std::move(base)) {}  // NOLINT(google-explicit-constructor)

  const T* operator->() const { return &**this; }
  T* operator->() { return &**this; }
  const T& operator*() const& { return demand(), Base::operator*(); }
  T& operator*() & { return demand(), Base::operator*(); }
  T&& operator*() && { return demand(), std::move(*this).Base::operator*(); }

 private:
  void demand() const {
    if (this->has_value()) [[likely]]
      return;
    std::ostringstream why;
    why << this->error();
    used_unchecked(std::move(why).str());
  }
};

}  // namespace gecos
