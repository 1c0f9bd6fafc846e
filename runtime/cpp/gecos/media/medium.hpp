#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/media/core.hpp"

/// The interface of a medium. A medium moves opaque packets between two endpoints and states its
/// guarantees for them (Capabilities).
///
/// Code that uses this interface must not depend on how a medium works; code that implements it
/// must not depend on what a packet means. One conformance suite (tests/cpp/media) runs on every
/// medium.
///
/// Threads: for one connection, at most one thread at a time may call receive(), prepare_to_sleep()
/// and woke(), and at most one, possibly another, may call send(), make_stream(), share() and
/// unshare(); the user of the connection must ensure that. Any thread may call all other functions
/// of a connection at any time: the maintenance thread may call beat() while another thread is in
/// send(). At most one thread at a time may use an acceptor; other threads may use its connections.
///
/// In a forked child, the connections and acceptors of its parent are dead (Loss::Broken): the
/// child must make its own.
namespace gecos::media {

/// The distance that a medium spans.
enum class Reach : std::uint8_t {
  Process,  ///< within one process
  Host,     ///< between programs that share a runtime directory of one host
  Network,  ///< between hosts
};

/// What a medium guarantees for each of its connections. Code must check these members instead of
/// the medium's name.
struct Capabilities {
  std::string_view name = "inproc";  ///< prefix of the medium's addresses; of static storage
  Reach reach = Reach::Process;
  bool ordered = true;
  bool reliable = true;  ///< no packet is lost or repeated while both ends live
  bool intact = true;  ///< packets arrive undamaged; else the medium must be wrapped (checked.hpp)
  bool real_time = true;           ///< no shared queue, no loss: fit for HARD_REALTIME
  bool reports_death = true;       ///< the kernel reports the death of the peer
  bool authenticated = true;       ///< the identity of the peer's user is proved
  bool overheard = false;          ///< other programs receive the packets: they must be sealed
  bool connectionless = false;     ///< only silence shows that no server is running; the acceptor
                                   ///< receives the packets for its connections
  bool shared_words = false;       ///< write_word() and peer_word() work
  std::size_t largest_packet = 0;  ///< in bytes
  std::size_t piece = 0;           ///< bytes of content in a piece; 0: as many as fit in a packet
};

/// What the medium knows about the program at the other end.
struct Peer {
  std::optional<std::uint32_t> uid;  ///< as reported by the kernel; nullopt when unknown
  std::optional<std::int32_t> pid;
  std::string
      description;  ///< for messages: "uid 1000, pid 4711", "key 3fa9c1d2, 239.255.76.67:20017"
};

enum class SendProblem : std::uint8_t {
  Full,      ///< no room until the peer reads packets; nothing was sent, try again
  TooLarge,  ///< the packet never fits; nothing was sent
  Lost,      ///< the connection is lost; nothing was sent
};

enum class Loss : std::uint8_t {
  None,    ///< the connection is not lost, as far as the medium knows
  Closed,  ///< the peer closed the connection by a message
  Died,    ///< the peer's process ended, or closed its socket without a message
  Broken,  ///< the peer violated the protocol of the medium (see Connection::loss_text)
};

/// One sample of a stream as stored in the medium.
struct StreamSample {
  std::uint64_t sequence = 0;  ///< 1 for the first sample of the stream, then rising by one
  std::int64_t stamp_ns = 0;   ///< time of measurement: Unix time in ns, by the writer's clock
  Bytes bytes;
};

/// A sample that is read in place.
struct LentSample {
  std::uint64_t sequence = 0;
  std::int64_t stamp_ns = 0;
  ByteView bytes;
};

/// Writes one stream for all readers that it is shared with. At most one thread at a time may
/// write. The writer never waits for a reader: a slow reader loses old samples.
class StreamWriter {
 public:
  virtual ~StreamWriter() = default;
  /// Publishes a copy of `sample` and wakes sleeping readers. Fails with TooLarge only.
  virtual tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) = 0;
  /// Lends `size` bytes of memory, with undefined values, in which the caller writes the next
  /// sample; shared memory thus needs no copy. A loan that is not published ends with the next call
  /// of lend() or publish(). Fails with TooLarge only.
  virtual tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) = 0;
  /// Publishes the sample that was written into the lent memory, and wakes sleeping readers. @pre
  /// lend() was called.
  virtual void publish_lent(std::int64_t stamp_ns) = 0;
};

/// Reads one stream. One thread at a time.
class StreamReader {
 public:
  virtual ~StreamReader() = default;
  /// Copies the newest sample to `into`, reusing its memory. Returns false when no sample has a
  /// larger sequence number than `after`.
  virtual bool latest(std::uint64_t after, StreamSample& into) = 0;
  /// Copies the oldest stored sample with a larger sequence number than `after`; a gap in the
  /// sequence numbers shows how many samples were lost. The first sample returned is the one that
  /// was the newest when the stream was opened.
  virtual bool next(std::uint64_t after, StreamSample& into) = 0;
  /// As latest(), without a copy. The bytes stay readable until the next call of lend_latest() or
  /// the end of the reader. In shared memory the writer overwrites them after `depth` further
  /// samples: discard what was read unless intact() returns true afterwards. The peer may be
  /// hostile: validate the values, and never read a length twice.
  virtual std::optional<LentSample> lend_latest(std::uint64_t after) = 0;
  /// Whether the writer has not yet overwritten the bytes of `sample`.
  virtual bool intact(const LentSample& sample) const = 0;
};

inline constexpr std::size_t shared_word_count = 4;

/// One end of a connection between a client and a server.
class Connection {
 public:
  virtual ~Connection() = default;  ///< closes the connection in order: the peer sees Loss::Closed

  virtual const Capabilities& capabilities() const = 0;
  virtual const Peer& peer() const = 0;

  /// Sends head and body as one packet; both are copied before the function returns. Never blocks.
  /// Returns the packet's number on this connection: 1 for the first, rising by one.
  virtual tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) = 0;

  /// Returns the next packet, or nullopt when none has arrived. The bytes are a private copy, valid
  /// until the next call of receive() or prepare_to_sleep(). Never blocks; on shm and inproc a call
  /// that finds no packet costs no system call.
  virtual std::optional<ByteView> receive() = 0;

  /// Time since the peer sent the packet that receive() returned last, including time in which this
  /// process was stopped. Zero when the medium cannot know it; taken_by_peer() then tells which
  /// packets were read.
  virtual Duration age() { return Duration::zero(); }

  /// Our CLOCK_BOOTTIME minus the peer's CLOCK_BOOTTIME, plus the shortest transit time of a
  /// packet: the smallest difference between arrival and send time in the last minutes. nullopt
  /// when both ends read the same clock.
  virtual std::optional<Duration> clock_difference() { return std::nullopt; }

  /// Number of our packets that the peer has read; available also after the peer's death. nullopt
  /// when the medium cannot know.
  virtual std::optional<std::uint64_t> taken_by_peer() = 0;

  /// Announces that this end is about to sleep on `descriptors()`. Returns false when a packet has
  /// arrived or the connection is lost: do not sleep. Call `woke()` afterwards, whatever the
  /// result.
  virtual bool prepare_to_sleep() = 0;
  virtual void woke() = 0;
  /// File descriptors that become readable when a packet or sample may have arrived or the
  /// connection was lost. They are valid for the life of the connection; poll them level- or
  /// edge-triggered. woke() makes them unreadable again. With edge-triggered polling, call loss()
  /// on every event that comes while the connection is not prepared to sleep, because a second
  /// event may never come. The descriptors of a lost connection may stay readable. On a
  /// connectionless medium, packets for connections that an acceptor made arrive through the
  /// acceptor's descriptors: poll those as well, and call accept() when they are readable.
  virtual std::span<const int> descriptors() const = 0;

  /// Writes a word of shared memory, zero at first, that the peer reads in place. No packet is
  /// sent, and the peer need not run: a suspended process finds the value when it continues.
  /// Sequentially consistent; any thread. @pre capabilities().shared_words and `index` <
  /// shared_word_count
  virtual void write_word(std::size_t index, std::uint64_t value);
  /// Reads a word that the peer writes. A hostile peer may write any value: trust the word only
  /// where a wrong value harms the peer alone.
  virtual std::uint64_t peer_word(std::size_t index);

  /// On which core the peer runs and whether it sleeps, read from shared memory; unknown_core when
  /// no memory is shared. Any thread.
  virtual Whereabouts peer_whereabouts();

  /// Sends a heartbeat; the maintenance thread calls this every 100 ms. On shm and inproc a
  /// heartbeat does not wake the peer.
  virtual void beat() = 0;
  /// Number of heartbeats received; on lcm, packets count as heartbeats. The session detects
  /// silence, with its own clock, when this number does not rise.
  virtual std::uint64_t beats_seen() = 0;
  /// Number of received heartbeats that no unread packet precedes. A packet counts as read when
  /// receive() was called again after it had returned the packet. Equals beats_seen() on a medium
  /// that does not order heartbeats with packets. Any thread.
  virtual std::uint64_t beats_read() { return beats_seen(); }

  /// Asks the kernel whether the connection is lost. This is a system call on shm: call it on ticks
  /// and after a wake-up without a packet, not for every packet. Packets that the peer sent before
  /// the loss can still be received. Once a loss was found, the result never changes.
  virtual Loss loss() = 0;
  /// Why the connection is lost; on lcm also why no peer answers.
  virtual std::string loss_text() const = 0;

  /// Makes a stream for this peer alone: samples from a client to its server. Use
  /// Acceptor::make_stream for many readers. `largest`: bytes of a sample; `depth`: samples kept.
  /// Throws std::exception when no memory or no descriptor is left.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
  /// Lets the peer read `stream` under the number `id`. The session chooses `id`; each end numbers
  /// the streams that it shares. `stream` must have been made by this connection or by its
  /// acceptor.
  virtual tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) = 0;
  /// Ends the peer's access to the stream `id`.
  virtual void unshare(std::uint32_t id) = 0;
  /// Opens the stream that the peer shared under `id`; null before the announcement of the stream
  /// has arrived, or when the stream cannot be opened (why_no_stream).
  virtual std::unique_ptr<StreamReader> open_stream(std::uint32_t id) = 0;
  /// Why the stream that the peer shared under `id` cannot be opened here; empty while the
  /// announcement of the stream may still arrive.
  virtual std::string why_no_stream(std::uint32_t id);
};

/// Server side of one object on one medium: makes a connection for each client that connects.
class Acceptor {
 public:
  /// No client can connect afterwards; existing connections stay open.
  virtual ~Acceptor() = default;
  virtual const Capabilities& capabilities() const = 0;
  /// The address that a client passes to Medium::connect, such as "shm:/run/gecos/1f3a.sock".
  virtual const std::string& address() const = 0;
  /// The connection of the next client that has connected, or null.
  virtual std::unique_ptr<Connection> accept() = 0;
  /// Whether a client is waiting but the process is out of file descriptors. Call accept() again
  /// later: no event announces that a descriptor is free again.
  virtual bool short_of_descriptors() const { return false; }
  /// File descriptors that become readable when a client may have connected; on lcm also when
  /// packets for the acceptor's connections may have arrived.
  virtual std::span<const int> descriptors() const = 0;
  /// Makes a stream that all connections of this acceptor can share. `largest`: bytes of a sample;
  /// `depth`: samples kept.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
};

struct MediumError {
  std::string text;  ///< what failed, where, and what to do
};

/// A way to move packets: makes acceptors and connections.
class Medium {
 public:
  virtual ~Medium() = default;
  virtual const Capabilities& capabilities() const = 0;
  /// Opens an address at which the clients of one object connect. The address is unique and `name`
  /// serves diagnostics only, unless `well_known` requests the well-known address of `name` on this
  /// host (the broker's).
  virtual tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                                      bool well_known) = 0;
  /// Connects to an address returned by `Acceptor::address`.
  virtual tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) = 0;
  /// The well-known address of `name`, whether or not a server listens there.
  virtual std::string well_known_address(std::string_view name) const = 0;
};

}  // namespace gecos::media
