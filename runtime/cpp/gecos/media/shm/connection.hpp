#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <optional>
#include <string>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/fork_watch.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/media/buffers/ring.hpp"
#include "gecos/media/buffers/stream_ring.hpp"
#include "gecos/media/quiet.hpp"
#include "gecos/media/shm/bulk.hpp"
#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/control_queue.hpp"
#include "gecos/media/shm/memory.hpp"
#include "gecos/media/shm/peer_end.hpp"
#include "gecos/media/shm/shared_streams.hpp"
#include "gecos/media/shm/shm.hpp"

namespace gecos::media::shm {

/// One end of a connection over shared memory. The two ends differ only in one message: the client
/// sends Hello, and the server sends Welcome. This class has more methods and members than other
/// classes, because it implements the whole of Connection. The ring, large packets and streams have
/// separate classes.
class ShmConnection final : public Connection, public QuietSender {
 public:
  enum class Role : std::uint8_t { Client, Server };

  /// Makes the connection of a client over a connected socket, and sends the Hello message. The
  /// server may answer at any later time.
  static tl::expected<std::unique_ptr<Connection>, MediumError> greet(Descriptor socket, Peer peer,
                                                                      Descriptor death);
  /// Makes the connection of a server and answers the message `hello`. On failure, returns an error
  /// text.
  static tl::expected<std::unique_ptr<Connection>, std::string> welcome(Descriptor socket,
                                                                        Peer peer, Descriptor death,
                                                                        ReceivedControl& hello);
  ~ShmConnection() override;

  const Capabilities& capabilities() const override { return shm_capabilities; }
  const Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override;
  tl::expected<std::uint64_t, SendProblem> send_quietly(ByteView head, ByteView body) override;
  std::optional<ByteView> receive() override;
  Duration age() override { return reader_ ? reader_->age() : Duration::zero(); }
  std::optional<std::uint64_t> taken_by_peer() override;
  bool prepare_to_sleep() override;
  void woke() override;
  std::span<const int> descriptors() const override { return descriptors_; }
  void write_word(std::size_t index, std::uint64_t value) override;
  std::uint64_t peer_word(std::size_t index) override;
  Whereabouts peer_whereabouts() override;
  void beat() override;
  std::uint64_t beats_seen() override;
  Loss loss() override;
  std::string loss_text() const override;
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override;
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override;
  void unshare(std::uint32_t id) override;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id, const StreamBounds& most) override;
  std::string why_no_stream(std::uint32_t id) override;

  ShmConnection(Role role, std::shared_ptr<PeerEnd> other, Peer peer, Descriptor death,
                SealedMemory own);

 private:
  void wake_reader();
  std::optional<std::string> know_peer(ReceivedControl& from);
  void read_control();
  void read_control_to_the_end();
  void take_control(ReceivedControl& control) GECOS_REQUIRES(control_mutex_);
  void note_loss(Loss loss, std::string text) GECOS_REQUIRES(control_mutex_);
  void abandon() noexcept;

  const Role role_;
  const Peer peer_;
  SealedMemory own_memory_;
  const RingMemory own_;
  EventFd event_;
  Descriptor death_;
  const std::shared_ptr<PeerEnd> other_;
  RingWriter writer_;
  ShmBulk bulk_;
  std::optional<RingReader> reader_;  // set before PeerEnd::known() returns true
  StreamWatches watches_;
  const std::array<int, 3> descriptors_;
  std::atomic<Loss> loss_{Loss::None};  // read by any thread; loss_text_ needs the mutex

  mutable Mutex control_mutex_;  ///< held also while messages are read from the socket
  std::string loss_text_ GECOS_GUARDED_BY(control_mutex_);
  SharedStreams streams_ GECOS_GUARDED_BY(control_mutex_);
  ControlQueue unsent_ GECOS_GUARDED_BY(control_mutex_);
  const ForkWatch fork_watch_;
};

}  // namespace gecos::media::shm
