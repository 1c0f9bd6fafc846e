#pragma once

#include <array>
#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "gecos/base/descriptor.hpp"
#include "gecos/base/fork_watch.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/sealed/initiator.hpp"
#include "gecos/media/sealed/inward.hpp"
#include "gecos/media/sealed/network.hpp"
#include "gecos/media/sealed/receive_queue.hpp"
#include "gecos/media/sealed/responder.hpp"
#include "gecos/media/sealed/sender.hpp"
#include "gecos/media/sealed/stream.hpp"

namespace gecos::media {

/// Returns the description of a client that has proved its key: the key and, from the key
/// directory, the user and host to whom the key belongs.
Peer peer_of(const HandshakeResponder::PendingPeer& pending, const HandshakeResponder& responder);

/// The part of a connection that clients and servers have in common: sends packets, and takes
/// received packets from the queue.
class SealedConnection : public Connection {
 public:
  const Capabilities& capabilities() const override { return options_.network->capabilities(); }
  const Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override;
  std::optional<ByteView> receive() override;
  Duration age() override { return options_.now() - current_.sent; }
  std::optional<Duration> clock_difference() override { return queue_->clock_difference(); }
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  void beat() override;
  std::uint64_t beats_seen() override;
  std::uint64_t beats_read() override { return queue_->beats_read(); }
  Loss loss() override;
  std::string loss_text() const override;

 protected:
  SealedConnection(std::shared_ptr<ReceiveQueue> queue, std::shared_ptr<SealedSender> sender,
                   const SealedOptions& options, Peer peer);

  /// Moves the datagrams that have arrived into the queue, and handles messages that are not
  /// packets.
  virtual void pump() = 0;
  void say(InnerKind kind, std::uint64_t number = 0, ByteView body = {});
  const std::shared_ptr<SealedSender>& sender() const { return sender_; }
  bool inherited() const { return inherited_.load(std::memory_order_relaxed); }

  const std::shared_ptr<ReceiveQueue> queue_;
  const SealedOptions options_;

 private:
  const std::shared_ptr<SealedSender> sender_;
  const Peer peer_;
  std::uint64_t sent_ = 0;
  Bytes outgoing_;
  ReceiveQueue::Packet current_;
  std::atomic<bool> inherited_{false};  // true in a forked child
  const ForkWatch fork_watch_;
};

class SealedClient final : public SealedConnection {
 public:
  static tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      const SealedOptions& options, std::shared_ptr<const SealedKeys> keys,
      const SealedAddress& address);
  ~SealedClient() override;

  void beat() override;
  std::string loss_text() const override;
  bool prepare_to_sleep() override;
  void woke() override;
  std::span<const int> descriptors() const override { return descriptors_; }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override;
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override;
  void unshare(std::uint32_t id) override;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id, const StreamBounds& most) override;
  std::string why_no_stream(std::uint32_t id) override;

  SealedClient(const SealedOptions& options, std::shared_ptr<ReceiveQueue> queue,
               std::shared_ptr<SealedSender> sender, std::shared_ptr<DatagramPort> in,
               std::uint64_t subscription, std::shared_ptr<HandshakeInitiator> initiator,
               const SealedAddress& address);

 private:
  struct Arrived {
    SharedStream where;
    std::uint64_t number = 0;  ///< of the announcement, which the answer repeats
    bool opened = false;
    std::string problem{};  ///< why the last attempt to open the stream failed
  };
  struct Inward {
    std::weak_ptr<InwardStream> stream;
    bool opened = false;  ///< while false, the stream is announced again with every heartbeat
  };
  struct Reading {
    std::uint32_t id = 0;
    std::weak_ptr<SampleQueue> queue;
    int port = -1;  ///< the descriptor of the port of the stream, which streams_ watches
  };
  void pump() override;
  bool new_samples();
  void forget_closed_readers() GECOS_REQUIRES(mutex_);
  void take_share(const SharedStream& where, std::uint64_t number);
  void take_key(const SharedStream& where) GECOS_REQUIRES(mutex_);
  void take_opened(std::uint32_t id);
  void tell(std::uint32_t id, InwardStream& stream);

  const std::shared_ptr<DatagramPort> in_;
  const std::uint64_t subscription_;  // at in_
  const std::shared_ptr<HandshakeInitiator> initiator_;
  const Descriptor streams_;  // an epoll of the ports of streams; these ports open later
  const std::array<int, 3> descriptors_;
  /// Whether the peer has announced a stream since the last call of open_stream(). A thread must
  /// check this flag before it sleeps, because another thread may have read the announcement. This
  /// atomic orders no other memory.
  std::atomic<bool> heard_of_streams_{false};
  Mutex mutex_;
  std::map<std::uint32_t, Arrived> arrived_ GECOS_GUARDED_BY(mutex_);
  std::vector<Reading> reading_ GECOS_GUARDED_BY(mutex_);
  /// The streams that this connection made. They end with the connection.
  std::vector<std::weak_ptr<InwardStream>> made_ GECOS_GUARDED_BY(mutex_);
  std::map<std::uint32_t, Inward> inward_ GECOS_GUARDED_BY(mutex_);
};

class SealedServer final : public SealedConnection {
 public:
  static tl::expected<std::unique_ptr<Connection>, MediumError> welcome(
      std::shared_ptr<HandshakeResponder> responder, HandshakeResponder::PendingPeer pending);
  ~SealedServer() override;

  bool prepare_to_sleep() override;
  void woke() override;
  std::span<const int> descriptors() const override { return descriptors_; }
  void beat() override;
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override;
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override;
  void unshare(std::uint32_t id) override;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id, const StreamBounds& most) override;
  std::function<std::string()> later_refusal() override;

  SealedServer(std::shared_ptr<HandshakeResponder> responder,
               const HandshakeResponder::PendingPeer& pending,
               std::shared_ptr<SealedSender> sender);

 private:
  struct Shared {
    std::weak_ptr<SealedStream> stream;
    bool opened = false;  // while false, the stream is announced again with every heartbeat
    std::uint32_t generation = 0;  // of the keys that were announced last
  };
  /// An inward stream, over which the client sends samples.
  struct Inward {
    InwardShare where;
    bool opened = false;
  };
  void pump() override;
  void take_opened(std::uint64_t number);
  void take_share(const InwardShare& where);
  void tell(std::uint32_t id, Shared& shared, const SealedStream& stream) GECOS_REQUIRES(mutex_);

  const std::shared_ptr<HandshakeResponder> responder_;
  const std::uint64_t client_;
  const crypto::PublicKey key_;
  const std::array<int, 1> descriptors_;
  Mutex mutex_;
  std::map<std::uint32_t, Shared> shared_ GECOS_GUARDED_BY(mutex_);
  std::map<std::uint32_t, Inward> inward_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::media
