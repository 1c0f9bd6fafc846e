#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/function_ref.hpp"
#include "gecos/object.hpp"
#include "gecos/stream.hpp"

namespace gecos::session {

class ClientConnection;

/// The client side of a subscription to a stream.
class ClientStream final : public StreamCore {
 public:
  /// `newest`: the number of the newest sample when the server accepted the subscription.
  /// `earlier`: the stream of another session that this stream continues; null for a new
  /// subscription.
  ClientStream(std::shared_ptr<ClientConnection> session, const StreamDescription& stream,
               std::unique_ptr<media::StreamReader> reader, std::uint64_t newest,
               const ClientStream* earlier);
  ~ClientStream() override;

  bool latest(RawSample& into) override;
  tl::expected<void, StreamEnd> next(RawSample& into, TimePoint deadline) override;
  bool lend_latest(RawLent& into) override;
  tl::expected<void, StreamEnd> lend_next(RawLent& into, TimePoint deadline) override;
  std::vector<RawSample> history() override;
  void stop_waiting() override;
  bool lost() const override;
  std::string loss_text() const override;
  bool revoked() const override;
  std::optional<std::uint64_t> after() const override { return after_; }
  qos::StreamCounts counts() const override { return reception_->counts(); }
  bool alive() const override { return !lost() && reception_->writer_alive(); }
  std::string title() const override { return title_; }

  /// Returns the number of the newest sample when the server accepted the subscription. The reader
  /// gets all later samples.
  std::uint64_t opened_at() const { return opened_at_; }

 private:
  /// Waits until `read` returns true; `read` has then stored a sample in `into`.
  template <class Raw>
  tl::expected<void, StreamEnd> next(Raw& into, TimePoint deadline, FunctionRef<bool()> read);
  bool await_sample(FunctionRef<bool()> read, TimePoint deadline);
  template <class Raw>
  void date(Raw& sample, TimePoint now);
  template <class Raw>
  bool admit(qos::Reception::Way way, Raw& sample, TimePoint now);
  bool came_after_loss(std::uint64_t sequence);
  void end_with(std::uint64_t sequence);
  StreamEnd end() const;

  const std::shared_ptr<ClientConnection> session_;
  const FunctionCode code_;
  const std::string title_;
  const std::unique_ptr<media::StreamReader> reader_;
  const std::uint64_t opened_at_;
  const std::optional<std::uint64_t> after_;
  /// Judges and counts the samples. A stream that continues another stream shares this object with
  /// it, so that the counts go on.
  const std::shared_ptr<qos::Reception> reception_;
  std::atomic<bool> waits_{true};  // orders no other memory
  /// The number of the last sample of the stream, known when this stream has first found its
  /// session lost. A server that was silent may go on writing into the memory that this stream
  /// reads.
  static constexpr std::uint64_t goes_on = std::numeric_limits<std::uint64_t>::max();
  std::atomic<std::uint64_t> ends_with_{goes_on};  // orders no other memory
};

}  // namespace gecos::session
