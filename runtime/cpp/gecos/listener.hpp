#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "gecos/stream.hpp"

/// Gives the samples of a stream to a function of the program.
namespace gecos {

namespace session {

/// The thread of a Listener, without the type of its samples.
class ListenerThread {
 public:
  /// The functions that the thread calls.
  struct Calls {
    std::function<tl::expected<void, StreamEnd>()> read;  ///< waits for the next sample
    std::function<void()> give;  ///< gives the sample that was read last to the program
    std::function<void(StreamEnd, const std::string&)> end;  ///< may be empty
  };
  /// Starts the thread. `stream`: the stream that `calls.read` reads. Throws std::system_error when
  /// no thread can be started.
  ListenerThread(const std::shared_ptr<StreamCore>& stream, Calls calls);
  ~ListenerThread();
  ListenerThread(ListenerThread&&) noexcept = default;
  ListenerThread& operator=(ListenerThread&& other) noexcept;

  /// See Listener::close.
  void close();

 private:
  struct Shared;
  void leave();

  std::shared_ptr<Shared> shared_;  ///< null if the ListenerThread was moved from
};

}  // namespace session

/// Calls a function for each sample of a stream, in order, until the Listener is closed or
/// destroyed, or until the stream ends. Example:
///
///     auto listening = gecos::listen(*robot.tool(gecos::stream),
///                                    [](const gecos::Sample<Frame>& sample) { … });
///
/// The functions run on a thread that only this Listener uses, so they may block, issue commands
/// and wait for them, and close their Lab. A slow function misses old samples, and Sample::lost
/// says how many; it delays neither the server nor another reader. The functions share their data
/// with the other threads of the program, so they must lock what others use.
///
/// The thread is none of the real-time threads: a program with a control loop reads the stream
/// itself, with Stream::latest().
template <class T>
class Listener {
 public:
  using OnSample = std::function<void(const Sample<T>&)>;
  /// `loss_text` is a text for people that says why the stream is lost, as Stream::loss_text().
  using OnEnd = std::function<void(StreamEnd end, const std::string& loss_text)>;

  /// Begins with the next unread sample of `samples`, a stream which no other thread may read from
  /// now on. `on_sample`: gets each sample. Samples that next() of a stream does not return are
  /// left out; a missed deadline (StreamEnd::Late) is not reported. `on_end`: is called once when
  /// the stream ends, with StreamEnd::Lost or Revoked, and then nothing more is called. It is not
  /// called after close(). Without `on_end`, the log reports the end, except when the program
  /// closed the Lab. If one of the functions throws, the log reports the exception, and the
  /// Listener goes on. Throws std::system_error when no thread can be started.
  Listener(Stream<T> samples, OnSample on_sample, OnEnd on_end = {})
      : Listener(std::make_shared<Reading>(Reading{std::move(samples), {}}), std::move(on_sample),
                 std::move(on_end)) {}

  /// Ends the subscription. Waits for no sample, but until a function that is running has returned.
  /// Afterwards the functions are neither running nor called again, and are destroyed. If one of
  /// the functions calls close(), or destroys the Listener, it is the last call: the subscription
  /// ends when the function returns. A function may call close() while another thread does;
  /// two other threads must not call it at the same time.
  void close() { thread_.close(); }

 private:
  struct Reading {
    Stream<T> stream;
    Sample<T> sample;  ///< the sample that was read last
  };
  Listener(const std::shared_ptr<Reading>& reading, OnSample on_sample, OnEnd on_end)
      : thread_(reading->stream.core_,
                {.read = [reading] { return read_next(*reading); },
                 .give = [reading, give = std::move(on_sample)] { give(reading->sample); },
                 .end = std::move(on_end)}) {}

  static tl::expected<void, StreamEnd> read_next(Reading& reading) {
    auto next = reading.stream.next(Duration::max());
    if (!next) return tl::unexpected(next.error());
    reading.sample = *std::move(next);
    return {};
  }

  session::ListenerThread thread_;
};

/// Calls `on_sample` for each sample of `samples`, and `on_end` when the stream ends, as long as
/// the returned Listener exists. See Listener.
template <class T>
[[nodiscard]] Listener<T> listen(Stream<T> samples, typename Listener<T>::OnSample on_sample,
                                 typename Listener<T>::OnEnd on_end = {}) {
  return Listener<T>(std::move(samples), std::move(on_sample), std::move(on_end));
}

}  // namespace gecos
