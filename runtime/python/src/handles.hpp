#pragma once

#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "gecos/session/lab.hpp"
#include "gecos/session/reserved.hpp"
#include "waiting.hpp"

/// What Python holds of the session. The GIL guards them; letting go of one may say goodbye to a
/// server, which is done without it.
namespace gecos::python {

/// Lets go of a pointer without the GIL. Only where the GIL is held.
template <class T>
void let_go(std::shared_ptr<T>& pointer) {
  if (pointer == nullptr) return;
  without_gil([dropped = std::exchange(pointer, nullptr)]() mutable { dropped.reset(); });
}

class SessionHandle {
 public:
  SessionHandle(std::shared_ptr<session::ClientSession> session, const InterfaceDescription& table)
      : session_(std::move(session)), table_(table) {}
  SessionHandle(const SessionHandle&) = delete;
  SessionHandle& operator=(const SessionHandle&) = delete;
  ~SessionHandle() { let_go(session_); }

  /// Never null: after `close` whatever is asked of it says that its Lab is closed.
  std::shared_ptr<session::ClientSession> get() const { return session_; }
  const InterfaceDescription& table() const { return table_; }
  void close() {
    auto open = std::exchange(session_, session::closed_session(*session_));
    let_go(open);
  }

 private:
  std::shared_ptr<session::ClientSession> session_;
  const InterfaceDescription& table_;
};

class LabHandle {
 public:
  explicit LabHandle(LabOptions options) : lab_(std::make_shared<Lab>(std::move(options))) {}
  LabHandle(const LabHandle&) = delete;
  LabHandle& operator=(const LabHandle&) = delete;
  ~LabHandle() { let_go(lab_); }

  /// Throws once it is closed.
  std::shared_ptr<Lab> get() const {
    if (lab_ == nullptr) throw nanobind::value_error("this Lab is closed; make a new one");
    return lab_;
  }
  /// Closes the session with the lab at the latest.
  std::shared_ptr<SessionHandle> keep(std::shared_ptr<SessionHandle> session) {
    std::erase_if(sessions_, [](const auto& known) { return known.expired(); });
    sessions_.push_back(session);
    return session;
  }
  void close() {
    for (const auto& known : std::exchange(sessions_, {})) {
      if (const auto session = known.lock()) session->close();
    }
    let_go(lab_);
  }

 private:
  std::shared_ptr<Lab> lab_;
  std::vector<std::weak_ptr<SessionHandle>> sessions_;
};

class CommandHandle {
 public:
  explicit CommandHandle(std::shared_ptr<session::CommandCore> core) : core_(std::move(core)) {}
  CommandHandle(CommandHandle&&) = default;
  ~CommandHandle() { let_go(core_); }

  session::CommandCore& core() const { return *core_; }

 private:
  std::shared_ptr<session::CommandCore> core_;
};

class StreamHandle {
 public:
  explicit StreamHandle(std::shared_ptr<session::StreamCore> core) : core_(std::move(core)) {}
  StreamHandle(StreamHandle&&) = default;
  ~StreamHandle() { let_go(core_); }

  /// Null once it is closed.
  std::shared_ptr<session::StreamCore> get() const { return core_; }
  /// Its memory is used again by each reading.
  media::StreamSample& sample() { return sample_; }
  void close() { let_go(core_); }

 private:
  std::shared_ptr<session::StreamCore> core_;
  media::StreamSample sample_;
};

class LeaseHandle {
 public:
  explicit LeaseHandle(Lease lease)
      : status_(static_cast<int>(lease.status())),
        epoch_(lease.epoch()),
        lease_(std::make_shared<Lease>(std::move(lease))) {}
  LeaseHandle(LeaseHandle&&) = default;
  ~LeaseHandle() { release(); }

  int status() const { return status_; }
  std::uint64_t epoch() const { return epoch_; }
  /// Again does nothing.
  void release() { let_go(lease_); }
  void release_now() {
    if (lease_) without_gil([lease = std::exchange(lease_, nullptr)] { lease->release_now(); });
  }

 private:
  int status_;
  std::uint64_t epoch_;
  std::shared_ptr<Lease> lease_;
};

}  // namespace gecos::python
