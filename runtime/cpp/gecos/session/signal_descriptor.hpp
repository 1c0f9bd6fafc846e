#pragma once

#include <signal.h>

namespace gecos::session {

/// Signals as a descriptor to sleep on. @pre they are blocked
class SignalDescriptor {
 public:
  explicit SignalDescriptor(const sigset_t& signals);  ///< throws std::system_error
  ~SignalDescriptor();
  SignalDescriptor(const SignalDescriptor&) = delete;
  SignalDescriptor& operator=(const SignalDescriptor&) = delete;

  int descriptor() const { return descriptor_; }
  /// Takes one that has come, so that it is not delivered later.
  void take() const;

 private:
  int descriptor_;
};

}  // namespace gecos::session
