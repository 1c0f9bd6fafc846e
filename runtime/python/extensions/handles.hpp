#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "fork_generation.hpp"
#include "gecos/binding.hpp"
#include "gecos/builtin_operations.hpp"
#include "gecos/lab.hpp"
#include "gecos/object_watch.hpp"
#include "waiting.hpp"

/// The handles through which Python uses labs, sessions, commands, streams and leases. The GIL
/// guards the handles. Dropping a handle may close a session; this is done without the GIL.
namespace gecos::python {

/// Detects, in a forked child, that a handle belongs to the parent. The child does not have the
/// threads that the object behind the handle needs, and locks that these threads held at the fork
/// stay locked. Therefore the child must not call this object or wait for it.
class Owner {
 public:
  bool inherited() const { return fork_generation_ != fork_generation(); }
  /// Throws if this handle was made before the fork of this process. `what` names the handle in the
  /// error text, for example "this Lab".
  void demand(const char* what) const {
    if (!inherited()) return;
    throw std::runtime_error(std::string(what) +
                             " belongs to the process that forked this one; in the child, make a "
                             "new Lab and new proxies, streams and servers from it");
  }

 private:
  std::uint64_t fork_generation_ = fork_generation();
};

/// Resets `pointer`, and releases the GIL while an object is destroyed. The caller must hold the
/// GIL. In a forked child, leaks an object of the parent, because the threads of this object do not
/// exist in the child.
template <class T>
void drop(std::shared_ptr<T>& pointer, const Owner& owner) {
  if (pointer == nullptr) return;
  if (owner.inherited()) {
    static_cast<void>(new std::shared_ptr<T>(std::exchange(pointer, nullptr)));
    return;
  }
  without_gil([dropped = std::exchange(pointer, nullptr)]() mutable { dropped.reset(); });
}

class SessionHandle {
 public:
  SessionHandle(std::shared_ptr<session::ClientSession> session, const InterfaceDescription& table)
      : session_(std::move(session)), table_(table) {}
  SessionHandle(const SessionHandle&) = delete;
  SessionHandle& operator=(const SessionHandle&) = delete;
  ~SessionHandle() { drop(session_, owner_); }

  /// Returns the session, which is never null: after `close`, every call on the session reports
  /// that its Lab is closed. Throws in a forked child.
  std::shared_ptr<session::ClientSession> get() const {
    owner_.demand("this proxy");
    return session_;
  }
  const session::ClientSession& about() const { return *session_; }
  const InterfaceDescription& table() const { return table_; }
  void close() {
    if (owner_.inherited()) return;
    auto open = std::exchange(session_, session::closed_session(*session_));
    drop(open, owner_);
  }

 private:
  const Owner owner_;
  std::shared_ptr<session::ClientSession> session_;
  const InterfaceDescription& table_;
};

class LabHandle {
 public:
  /// Makes a Lab. Throws std::system_error when the process has no thread or descriptor left for
  /// the Lab, and std::runtime_error when the value of an environment variable is invalid.
  explicit LabHandle(LabOptions options) : lab_(std::make_shared<Lab>(std::move(options))) {
    const session::LabOrWhyNot& context = session::LabAccess::context(*lab_);
    if (context) return;
    const session::NoLab& why = context.error();
    if (why.missing) throw std::system_error(*why.missing);
    throw std::runtime_error(why.text);
  }
  LabHandle(const LabHandle&) = delete;
  LabHandle& operator=(const LabHandle&) = delete;
  ~LabHandle() { drop(lab_, owner_); }

  /// Returns the Lab. Throws after `close`, and in a forked child.
  std::shared_ptr<Lab> get() const {
    owner_.demand("this Lab");
    if (lab_ == nullptr) throw nanobind::value_error("this Lab is closed; make a new one");
    return lab_;
  }
  /// Registers `session`, so that closing the Lab also closes this session.
  std::shared_ptr<SessionHandle> keep(std::shared_ptr<SessionHandle> session) {
    std::erase_if(sessions_, [](const auto& known) { return known.expired(); });
    sessions_.push_back(session);
    return session;
  }
  /// Closes the Lab and ends all its sessions, even those to which a proxy still refers.
  void close() {
    if (lab_ != nullptr && !owner_.inherited()) {
      without_gil([lab = lab_] { lab->close(); });
    }
    for (const auto& known : std::exchange(sessions_, {})) {
      if (const auto session = known.lock()) session->close();
    }
    drop(lab_, owner_);
  }

 private:
  const Owner owner_;
  std::shared_ptr<Lab> lab_;
  std::vector<std::weak_ptr<SessionHandle>> sessions_;
};

class CommandHandle {
 public:
  explicit CommandHandle(std::shared_ptr<session::CommandCore> core) : core_(std::move(core)) {}
  CommandHandle(CommandHandle&&) = default;
  /// Destroys the handle without releasing the GIL. This is safe, because no session is closed
  /// here: the session keeps its own reference to each command that has not ended, and a command
  /// that has ended owns nothing that must be closed.
  ~CommandHandle() {
    if (core_ != nullptr && owner_.inherited()) drop(core_, owner_);
  }

  session::CommandCore& core() const { return *core_; }
  const std::shared_ptr<session::CommandCore>& shared() const { return core_; }
  /// Returns true in a forked child, if the parent has issued the command.
  bool inherited() const { return owner_.inherited(); }
  /// Returns the command, for a caller that reads its state, cancels it or waits for it. Throws in
  /// a forked child: the session may be used by threads that the child does not have.
  session::CommandCore& awaited() const {
    owner_.demand("this command");
    return *core_;
  }

 private:
  Owner owner_;
  std::shared_ptr<session::CommandCore> core_;
};

class StreamHandle {
 public:
  explicit StreamHandle(std::shared_ptr<session::StreamCore> core)
      : core_(std::move(core)), position_(core_->after().value_or(0)) {}
  StreamHandle(StreamHandle&&) = default;
  ~StreamHandle() { drop(core_, owner_); }

  /// Returns the stream; null after `close`. Throws in a forked child.
  std::shared_ptr<session::StreamCore> get() const {
    owner_.demand("this stream");
    return core_;
  }
  session::ReadPosition& position() { return position_; }
  /// Returns the counts of the samples so far; after `close`, the counts at the time of `close`.
  /// Throws in a forked child.
  qos::StreamCounts counts() const {
    const auto open = get();
    return open ? open->counts() : last_counts_;
  }
  /// Ends the subscription. A thread that waits for a sample is woken, and finds the stream closed
  /// once `drop` has released the GIL.
  void close() {
    if (core_ != nullptr && !owner_.inherited()) {
      last_counts_ = core_->counts();
      core_->stop_waiting();
    }
    drop(core_, owner_);
  }

 private:
  Owner owner_;
  std::shared_ptr<session::StreamCore> core_;
  session::ReadPosition position_;
  qos::StreamCounts last_counts_;
};

/// A sample that Python reads in place. It needs no thread of the parent, so a forked child may
/// read it, too.
struct LentHandle {
  session::RawLent sample;
  std::span<std::byte> buffer() const {
    return {const_cast<std::byte*>(sample.bytes.data()), sample.bytes.size()};
  }
  static constexpr bool writable = false;
};

class WriterHandle {
 public:
  explicit WriterHandle(std::shared_ptr<session::WriterCore> core) : core_(std::move(core)) {}
  WriterHandle(WriterHandle&&) = default;
  ~WriterHandle() { drop(core_, owner_); }

  /// Returns the writer; null after `close`. Throws in a forked child.
  std::shared_ptr<session::WriterCore> get() const {
    owner_.demand("this writer");
    return core_;
  }
  void close() { drop(core_, owner_); }

 private:
  Owner owner_;
  std::shared_ptr<session::WriterCore> core_;
};

class WatchHandle {
 public:
  explicit WatchHandle(std::shared_ptr<ObjectWatch> watch) : watch_(std::move(watch)) {}
  WatchHandle(WatchHandle&&) = default;
  ~WatchHandle() { drop(watch_, owner_); }

  /// Returns the watch; null after `close`. Throws in a forked child.
  std::shared_ptr<ObjectWatch> get() const {
    owner_.demand("this ObjectWatch");
    return watch_;
  }
  void close() { drop(watch_, owner_); }

 private:
  Owner owner_;
  std::shared_ptr<ObjectWatch> watch_;
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
  /// Returns whether the lease was acquired less than 100 ms ago and no command was issued under
  /// it.
  bool fresh() const { return lease_ != nullptr && !owner_.inherited() && lease_->fresh(); }
  /// Returns whether the status is certainly lost; see Lease::lost.
  bool lost() const { return lease_ != nullptr && !owner_.inherited() && lease_->lost(); }
  /// Releases the lease. A second call has no effect.
  void release() {
    if (owner_.inherited()) return drop(lease_, owner_);
    if (lease_) without_gil([lease = std::exchange(lease_, nullptr)] { lease->release(); });
  }
  void release_now() {
    if (owner_.inherited()) return;
    if (lease_) without_gil([lease = std::exchange(lease_, nullptr)] { lease->release_now(); });
  }

 private:
  Owner owner_;
  int status_;
  std::uint64_t epoch_;
  std::shared_ptr<Lease> lease_;
};

}  // namespace gecos::python
