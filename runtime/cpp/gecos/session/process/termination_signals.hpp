#pragma once

#include <sys/types.h>

namespace gecos::session {

/// While an instance exists, SIGINT and SIGTERM do not end the process but make a descriptor
/// readable, whichever thread of the process receives the signal. The destructor of the last
/// instance restores the previous signal handlers. A signal that the process already ignores (for
/// example SIGINT under `nohup … &`) stays ignored. In a forked child both signals have their
/// default action until the child makes an instance of its own.
class TerminationSignals {
 public:
  /// Opens the descriptor that all instances share, or throws std::system_error. After this call no
  /// constructor fails.
  static void prepare();
  TerminationSignals();  ///< throws std::system_error, like `prepare`
  ~TerminationSignals();
  TerminationSignals(const TerminationSignals&) = delete;
  TerminationSignals& operator=(const TerminationSignals&) = delete;

  int descriptor() const;  ///< readable once a signal has arrived; shared by all instances

 private:
  const pid_t made_by_;
};

}  // namespace gecos::session
