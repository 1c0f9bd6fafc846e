#pragma once

/// Proxies and streams for programs that run longer than the servers that they use.
#include <chrono>
#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>

#include "gecos/base/mutex.hpp"
#include "gecos/lab.hpp"

namespace gecos {

struct ReconnectOptions {
  CreateOptions create{};                                   ///< options of each attempt to connect
  Duration between_tries = std::chrono::milliseconds(500);  ///< pause after a failed attempt
  /// The time without a new sample after which a stream is opened again, through a new proxy.
  Duration silence = std::chrono::seconds(1);
};

/// A proxy that is created at its first use, and created again after its server was lost. A
/// Reconnecting may be constructed before its object is online. Thread-safe; `lab` must outlive
/// this object.
template <class Proxy>
class Reconnecting {
 public:
  Reconnecting(Lab& lab, std::string name, ReconnectOptions options = {})
      : lab_(lab), name_(std::move(name)), options_(std::move(options)) {}

  const std::string& name() const { return name_; }

  /// Returns the proxy. If there is no proxy, creates one: this takes at most `create.patience`,
  /// and other threads that call `get` wait meanwhile. After a failed attempt, makes no new attempt
  /// for the time `between_tries`, and returns the reason of the failure at once.
  tl::expected<Proxy, std::string> get() {
    const MutexLock lock(mutex_);
    if (proxy_) return *proxy_;
    if (std::chrono::steady_clock::now() < next_try_) return tl::unexpected(problem_);
    auto created = lab_.create<Proxy>(name_, options_.create);
    if (created) return proxy_.emplace(std::move(*created));
    problem_ = created.error().to_string();
    next_try_ = std::chrono::steady_clock::now() + options_.between_tries;
    return tl::unexpected(problem_);
  }

  /// Calls `call` with the proxy and returns its result. The function `call` issues a command
  /// through the proxy, waits until the command has ended, and returns the result or the failure of
  /// the command. Drops the proxy when the server was lost, so that the next `get` creates a new
  /// one. When the command certainly did not start (CONNECTION_FAILED), repeats `call` once,
  /// through a new proxy.
  template <class Call>
  std::invoke_result_t<Call&, const Proxy&> call(Call call) {
    auto result = call_once(call);
    if (result || project(result.error().detail) != State::ConnectionFailed) return result;
    return call_once(call);
  }

  /// Drops the proxy `lost`, so that the next `get` creates a new one. Does nothing when another
  /// proxy has already replaced `lost`.
  void drop(const Proxy& lost) {
    const MutexLock lock(mutex_);
    if (proxy_ && session_of(*proxy_) == session_of(lost)) proxy_.reset();
  }

 private:
  template <class Call>
  std::invoke_result_t<Call&, const Proxy&> call_once(Call& call) {
    const auto proxy = get();
    if (!proxy) return tl::unexpected(Failure{Detail::NoServer, proxy.error(), {}, {}});
    auto result = call(*proxy);
    if (!result && lost(result.error().detail)) drop(*proxy);
    return result;
  }
  static bool lost(Detail detail) {
    return project(detail) == State::ConnectionFailed || detail == Detail::ServerCrashed ||
           detail == Detail::OutcomeUnknown;
  }

  Lab& lab_;
  const std::string name_;
  const ReconnectOptions options_;
  Mutex mutex_;  // held while connecting
  std::optional<Proxy> proxy_ GECOS_GUARDED_BY(mutex_);
  std::string problem_ GECOS_GUARDED_BY(mutex_);
  TimePoint next_try_ GECOS_GUARDED_BY(mutex_){};
};

/// A stream that is opened again, through a new proxy, when it is lost or silent. Only one thread
/// may call `tick`; any thread may read. `lab` must outlive this object.
template <class Proxy, class T>
class ReconnectingStream {
 public:
  /// The type of a function that opens the stream, for example `[](const Manipulator& arm) { return
  /// arm.flange(gecos::stream); }`.
  using Open = std::function<tl::expected<Stream<T>, Failure>(const Proxy&)>;

  ReconnectingStream(Lab& lab, std::string name, Open open, ReconnectOptions options = {})
      : lab_(lab),
        name_(std::move(name)),
        open_(std::move(open)),
        options_(std::move(options)),
        problem_("'" + name_ + "' sent no sample yet") {}

  const std::string& name() const { return name_; }

  /// Opens the stream when it is not open, is lost or is silent. Call this function periodically.
  /// It returns at once while samples arrive. Otherwise it opens the stream, which takes at most
  /// `create.patience` plus one second.
  void tick() {
    {
      const MutexLock lock(mutex_);
      if (std::chrono::steady_clock::now() < next_try_ || alive()) return;
      if (stream_) problem_ = "'" + name_ + "' no longer sends samples";
      stream_.reset();
      proxy_.reset();
    }
    auto created = lab_.create<Proxy>(name_, options_.create);
    auto fresh = opened(created);
    const MutexLock lock(mutex_);
    since_ = std::chrono::steady_clock::now();
    next_try_ = since_ + options_.between_tries;
    if (!fresh) {
      problem_ = std::move(fresh.error());
      return;
    }
    stream_ = std::move(*fresh);
    proxy_ = std::move(*created);
  }

  /// Returns the newest sample. Returns a reason instead when there is no sample or when the newest
  /// one is older than `silence`. Never waits.
  tl::expected<Sample<T>, std::string> latest() {
    const MutexLock lock(mutex_);
    if (!stream_) return tl::unexpected(problem_);
    auto sample = stream_->latest();
    if (sample && sample->age <= options_.silence) return *std::move(sample);
    if (!sample && !stream_->lost()) return tl::unexpected("'" + name_ + "' sent no sample yet");
    return tl::unexpected("'" + name_ + "' no longer sends samples");
  }

  /// Returns the proxy through which the stream was opened; nullopt while there is no stream.
  std::optional<Proxy> proxy() const {
    const MutexLock lock(mutex_);
    return proxy_;
  }

 private:
  tl::expected<Stream<T>, std::string> opened(const Checked<Proxy, CreateError>& created) const {
    if (!created) return tl::unexpected(created.error().to_string());
    auto opened = open_(*created);
    if (!opened) return tl::unexpected(opened.error().text);
    return *std::move(opened);
  }
  bool alive() GECOS_REQUIRES(mutex_) {
    if (!stream_) return false;
    if (stream_->is_event()) return !stream_->lost();  // silence between two events is no loss
    if (const auto sample = stream_->latest()) return sample->age <= options_.silence;
    return !stream_->lost() && std::chrono::steady_clock::now() - since_ < options_.silence;
  }

  Lab& lab_;
  const std::string name_;
  const Open open_;
  const ReconnectOptions options_;
  mutable Mutex mutex_;  // never held while connecting
  std::optional<Stream<T>> stream_ GECOS_GUARDED_BY(mutex_);
  std::optional<Proxy> proxy_ GECOS_GUARDED_BY(mutex_);
  std::string problem_ GECOS_GUARDED_BY(mutex_);
  TimePoint next_try_ GECOS_GUARDED_BY(mutex_){};
  /// The time at which the last attempt to open the stream ended.
  TimePoint since_ GECOS_GUARDED_BY(mutex_){};
};

}  // namespace gecos
