#pragma once

namespace gecos::session {

/// While an instance lives, SIGINT and SIGTERM make a descriptor readable instead of ending the
/// process, whichever thread receives them. The end of the last instance restores the previous
/// signal handlers. A signal that the process ignores (SIGINT under `nohup … &`) stays ignored. In
/// a forked child both signals have their default action.
class TerminationSignals {
 public:
  /// Opens the descriptor that all instances share, or throws std::system_error. After this call no
  /// constructor fails.
  static void prepare();
  TerminationSignals();  ///< throws as `prepare` does
  ~TerminationSignals();
  TerminationSignals(const TerminationSignals&) = delete;
  TerminationSignals& operator=(const TerminationSignals&) = delete;

  int descriptor() const;  ///< readable once a signal has come; shared by all instances
};

}  // namespace gecos::session
