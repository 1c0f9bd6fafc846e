#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <vector>

#include "gecos/session/command.hpp"
#include "gecos/session/handshake.hpp"
#include "gecos/session/wakeup.hpp"

namespace gecos::session {

class LinkedSession;

/// A call on its way. Its session keeps it until it is terminal, and it keeps its session as long;
/// ending cuts both ties, so a dropped command still runs and nothing is kept afterwards.
class PendingCommand final : public CommandCore {
 public:
  explicit PendingCommand(std::shared_ptr<LinkedSession> session) : session_(std::move(session)) {}
  /// One that ended before it was sent.
  explicit PendingCommand(Failure failure);

  CommandId id() const override { return {boot, session_id, counter}; }
  Progress progress() const override;
  Bytes feedback() const override;
  bool wait_until(TimePoint deadline) override;
  void cancel() override;
  ByteView result() const override { return result_; }
  const Failure& failure() const override { return failure_; }
  int descriptor() override;
  void when_ended(std::function<void()> then) override;

  bool terminal() const { return project(detail_.load(std::memory_order_acquire)) != State::Running; }

  // For its session.
  void report(Detail detail, const ProgressBody& body);
  void finish(ByteView result);
  void fail(Failure failure);
  std::uint64_t counter = 0;      ///< written before the command is shared, as the two below
  std::uint64_t session_id = 0;
  std::uint64_t boot = 0;
  std::uint64_t sent_as = 0;      ///< the packet's number on the link; written before it is shared

  /// What a medium that loses packets needs; guarded by the session's mutex.
  struct Retry {
    Bytes packet;
    TimePoint next{};
    TimePoint deadline = TimePoint::max();
    int sent = 1;
    bool on_its_way = false;  ///< sent at least once
    bool arrived = false;     ///< the server has it: only its outcome is asked for
    bool cancel = false;
  } retry;

 private:
  std::shared_ptr<LinkedSession> session() const;
  template <class Publish>
  void end(Detail detail, Publish publish);

  mutable std::mutex mutex_;
  std::atomic<Detail> detail_{Detail::Sent};  // terminal: publishes result_ and failure_ to all
  std::uint32_t position_ = 0;
  double fraction_ = 0;
  Bytes feedback_;
  Bytes result_;
  Failure failure_;
  std::unique_ptr<Wakeup> exported_;
  std::vector<std::function<void()>> callbacks_;
  std::shared_ptr<LinkedSession> session_;  ///< null once terminal
};

}  // namespace gecos::session
