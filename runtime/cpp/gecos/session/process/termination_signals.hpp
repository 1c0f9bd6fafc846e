#pragma once

namespace gecos::session {

/// While an instance lives, SIGINT and SIGTERM make a descriptor readable instead of ending the
/// process, whichever thread they are delivered to. Handlers that were there before come back
/// afterwards; a signal that the process ignores (SIGINT under `nohup … &`) stays ignored. In a
/// forked child the signals do again what they do by default.
class TerminationSignals {
 public:
  /// Opens the descriptor that all instances share, or throws std::system_error. No constructor
  /// fails after it.
  static void prepare();
  TerminationSignals();  ///< as `prepare`
  ~TerminationSignals();
  TerminationSignals(const TerminationSignals&) = delete;
  TerminationSignals& operator=(const TerminationSignals&) = delete;

  int descriptor() const;  ///< readable once a signal has come; the same for all that live
};

}  // namespace gecos::session
