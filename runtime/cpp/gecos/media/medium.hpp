#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "gecos/base/bytes.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/result.hpp"
#include "gecos/media/core.hpp"

/// The interface of a medium. A medium moves packets between two endpoints without reading their
/// contents. Its Capabilities state what it guarantees for the packets.
///
/// Code that uses this interface must not depend on how a medium works. Code that implements this
/// interface must not depend on what a packet means. One conformance suite (tests/cpp/media) tests
/// all media.
///
/// Threads: on one connection, at most one thread at a time may call receive(), prepare_to_sleep()
/// and woke(). At most one thread at a time, which may be another thread, may call send(),
/// make_stream(), share() and unshare(). The user of the connection must ensure both. Any thread
/// may call all other functions of a connection at any time; for example, the maintenance thread
/// may call beat() while another thread is in send(). At most one thread at a time may use an
/// acceptor; at the same time, other threads may use its connections.
///
/// A forked child cannot use the connections and acceptors of its parent (they are Loss::Broken).
/// The child must make new ones.
namespace gecos::media {

/// The programs that a medium can connect.
enum class Reach : std::uint8_t {
  Process,  ///< within one process
  Host,     ///< between programs that share a runtime directory of one host
  Network,  ///< between hosts
};

/// What a medium guarantees for each of its connections. Code must check these members and must not
/// check the medium's name.
struct Capabilities {
  std::string_view name = "inproc";  ///< prefix of the medium's addresses; has static storage
  Reach reach = Reach::Process;
  bool ordered = true;
  bool reliable = true;  ///< no packet is lost or repeated while both ends live
  bool intact = true;  ///< packets arrive undamaged; else the medium must be wrapped (checked.hpp)
  bool real_time = true;      ///< no shared queue and no loss: suitable for HARD_REALTIME
  bool reports_death = true;  ///< the kernel reports the death of the peer
  bool authenticated = true;  ///< the identity of the peer's user is proved
  bool overheard = false;     ///< other programs can receive packets: packets must be sealed
  /// True for a connectionless medium, on which a connection consists only of the packets that its
  /// ends exchange. On this medium, a client learns only from silence that no server is running,
  /// and an acceptor receives the packets for its connections.
  bool connectionless = false;
  bool shared_words = false;       ///< write_word() and peer_word() work
  std::size_t largest_packet = 0;  ///< in bytes
  std::size_t piece = 0;           ///< bytes of content in a piece; 0: as many as fit in a packet
};

/// Data that the medium has about the program at the other end of a connection.
struct Peer {
  std::optional<std::uint32_t> uid;  ///< as reported by the kernel; nullopt when unknown
  std::optional<std::int32_t> pid;
  std::string
      description;  ///< for messages: "uid 1000, pid 4711", "key 3fa9c1d2, 239.255.76.67:20017"
  /// The user and host to whom the proved key of the peer belongs. Both names are empty when the
  /// peer has proved no key, and when the key has no owner. A key without an owner counts as a key
  /// of this program's user.
  std::string user{};
  std::string host{};
  /// The key that the peer has proved, as 64 hexadecimal digits. The text is empty when the peer
  /// has proved no key, and for the key of this program's user.
  std::string key{};
};

enum class SendProblem : std::uint8_t {
  Full,      ///< no room until the peer reads packets; nothing was sent, try again
  TooLarge,  ///< the packet never fits; nothing was sent
  Lost,      ///< the connection is lost; nothing was sent
};

enum class Loss : std::uint8_t {
  None,     ///< the connection is not lost, as far as the medium knows
  Closed,   ///< the peer closed the connection by a message
  Refused,  ///< the server does not admit this client; loss_text() says why
  Died,     ///< the peer's process ended, or closed its socket without a message
  Broken,   ///< the peer violated the protocol of the medium (see Connection::loss_text)
};

/// One sample of a stream as the medium stores it.
struct StreamSample {
  std::uint64_t sequence = 0;  ///< 1 for the first sample of the stream, then rising by one
  std::int64_t stamp_ns = 0;   ///< time of measurement: Unix time in ns, by the writer's clock
  Bytes bytes;
};

/// A sample that a reader reads in place, without a copy. The bytes stay readable as long as the
/// LentSample or a copy of it exists, even after the end of the reader and of the connection.
///
/// In shared memory, the writer overwrites the bytes after `depth` further samples. Therefore the
/// reader must call intact() after reading the bytes, and must discard what it has read if intact()
/// returns false. The peer may be hostile: the reader must validate the values, and must not read a
/// length twice.
struct LentSample {
  std::uint64_t sequence = 0;
  std::int64_t stamp_ns = 0;
  ByteView bytes{};
  std::shared_ptr<const void> owner{};  ///< keeps `bytes` readable
  /// The version of the slot of a ring (buffers/stream_ring.hpp), which equals `2 * sequence` as
  /// long as the bytes are intact. Null if nobody can overwrite the bytes.
  const std::atomic<std::uint64_t>* version = nullptr;

  /// Returns true when the writer has not yet begun to overwrite the bytes. Any thread may call
  /// this function.
  bool intact() const;
};

/// Writes one stream for all readers with which the stream is shared. At most one thread at a time
/// may write. The writer never waits for a reader. A slow reader loses old samples.
class StreamWriter {
 public:
  virtual ~StreamWriter() = default;
  /// Returns the size of the largest sample in bytes, which is at most the size for which the
  /// stream was made.
  virtual std::size_t largest() const = 0;
  /// Publishes a copy of `sample` and wakes sleeping readers. The only possible error is TooLarge.
  virtual tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) = 0;
  /// Lends the caller `size` bytes of uninitialized memory for the next sample, so that shared
  /// memory needs no copy. If the caller does not publish the lent memory, the next call of lend()
  /// or publish() takes it back. The only possible error is TooLarge.
  virtual tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) = 0;
  /// Publishes the sample in the lent memory, and wakes sleeping readers. @pre lend() was called.
  virtual void publish_lent(std::int64_t stamp_ns) = 0;
  /// Returns an owner that keeps lent memory valid after the end of the writer. Returns null if the
  /// readers do not read the lent memory itself, because lending then saves no copy.
  virtual std::shared_ptr<void> lent_owner() const { return nullptr; }
  /// Returns the newest sample, in the memory where its readers find it. The bytes are valid until
  /// the next call of another function of the writer. @pre lent_owner() is not null, and newest()
  /// is not 0
  virtual ByteView newest_sample() const { return {}; }
  /// Returns the sequence number of the newest sample; 0 before the first sample.
  virtual std::uint64_t newest() const = 0;
  /// Makes the numbers of the samples go on after `newest`, so that a stream has the same numbers
  /// over all media. @pre the stream has no sample yet and is not shared
  virtual void number_after(std::uint64_t newest) = 0;
  /// Makes all later samples unreadable for peers with whom the stream is no longer shared. The
  /// other peers continue to read, with the same sequence numbers; they may lose samples until the
  /// next heartbeat. Throws a std::exception when no memory or no descriptor is left. Does nothing
  /// if the readers and the writer are in one process.
  virtual void move_on() {}
};

/// Publishes messages in clear on a channel of the network: anybody who receives them can read
/// them, and nothing proves who sent them. Messages may be lost. Any thread may use an OpenChannel.
class OpenChannel {
 public:
  virtual ~OpenChannel() = default;
  /// Sends `message` once, to everybody who listens to the channel. The only possible error is
  /// TooLarge.
  virtual tl::expected<void, SendProblem> publish(ByteView message) = 0;
};

/// Reads one stream. Only one thread at a time may use a reader.
class StreamReader {
 public:
  virtual ~StreamReader() = default;
  /// Copies the newest sample to `into`, whose memory is used again. Returns false when no sample
  /// has a sequence number larger than `after`.
  virtual bool latest(std::uint64_t after, StreamSample& into) = 0;
  /// Copies the oldest stored sample whose sequence number is larger than `after` to `into`.
  /// Returns false when there is none. A gap in the sequence numbers shows how many samples were
  /// lost. With `after` 0, begins with the sample that was the newest when the reader opened the
  /// stream.
  virtual bool next(std::uint64_t after, StreamSample& into) = 0;
  /// Returns the newest sample like latest(), but without a copy.
  virtual std::optional<LentSample> lend_latest(std::uint64_t after) = 0;
  /// Returns the oldest stored sample after `after` like next(), but without a copy.
  virtual std::optional<LentSample> lend_next(std::uint64_t after) = 0;
  /// Returns copies of all stored samples, oldest first, at most as many as the depth of the
  /// stream. Memory that the writer shares may also store samples that are older than the reader.
  /// A sample that the writer overwrites meanwhile is left out.
  virtual std::vector<StreamSample> stored() = 0;
};

/// The bounds of a stream that a reader opens. A peer may share a stream that is larger. Each bound
/// is for media on which the peer could otherwise choose how much memory the reader's end takes.
struct StreamBounds {
  /// Size in bytes of a sample. A stream that may have larger samples is not opened.
  std::size_t largest = std::numeric_limits<std::size_t>::max();
  /// The number of samples that this end keeps for the reader, if the medium keeps them here.
  std::size_t depth = std::numeric_limits<std::size_t>::max();
};

inline constexpr std::size_t shared_word_count = 4;

/// One end of a connection between a client and a server.
class Connection {
 public:
  virtual ~Connection() = default;  ///< closes the connection; the peer sees Loss::Closed

  virtual const Capabilities& capabilities() const = 0;
  virtual const Peer& peer() const = 0;

  /// Sends `head` and `body` as one packet. Copies both before it returns. Never blocks. Returns
  /// the number of the packet on this connection: 1 for the first packet, and one more for each
  /// further packet.
  virtual tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) = 0;

  /// Returns the next packet, or nullopt when no packet has arrived. The bytes are a private copy,
  /// which is valid until the next call of receive() or prepare_to_sleep(). Never blocks. On shm
  /// and inproc, a call that finds no packet makes no system call.
  virtual std::optional<ByteView> receive() = 0;

  /// Returns the time since the peer sent the packet that receive() returned last. This time
  /// includes pauses of this process. Returns zero when the medium cannot know the time;
  /// taken_by_peer() then tells which packets the peer has read.
  virtual Duration age() { return Duration::zero(); }

  /// Returns the time by CLOCK_BOOTTIME of this host minus the time by CLOCK_BOOTTIME of the peer's
  /// host, plus the shortest transit time of a packet. The medium measures this sum as the smallest
  /// difference between the arrival time and the send time of a packet in the last minutes. Returns
  /// nullopt when both ends read the same clock.
  virtual std::optional<Duration> clock_difference() { return std::nullopt; }

  /// Returns how many packets of this end the peer has read, even after the death of the peer.
  /// Returns nullopt when the medium cannot know.
  virtual std::optional<std::uint64_t> taken_by_peer() = 0;

  /// Announces that this end is about to sleep on `descriptors()`. Returns false when a packet has
  /// arrived, the connection is lost, or the announcement has failed; the caller must then not
  /// sleep, but poll again. The caller must call `woke()` afterwards, whatever the result.
  virtual bool prepare_to_sleep() = 0;
  virtual void woke() = 0;
  /// Returns the file descriptors that become readable when a packet or sample may have arrived, or
  /// when the connection was lost. The descriptors are valid for the life of the connection, and
  /// can be polled level-triggered or edge-triggered. woke() makes them unreadable again. With
  /// edge-triggered polling, call loss() on every event that comes while the connection is not
  /// prepared to sleep, because there may be no second event. The descriptors of a lost connection
  /// may stay readable. On a connectionless medium, the packets for an acceptor's connections
  /// arrive through the acceptor's descriptors. Poll these descriptors, too, and call accept() when
  /// they are readable.
  virtual std::span<const int> descriptors() const = 0;

  /// Writes a word of shared memory that the peer reads in place. The word is zero at first. Sends
  /// no packet, and the peer need not run: a peer that is suspended finds the value when it
  /// continues. The write is sequentially consistent. Any thread may call this function. @pre
  /// capabilities().shared_words is true, and `index` < shared_word_count
  virtual void write_word(std::size_t index, std::uint64_t value);
  /// Reads a word that the peer writes by write_word(). A hostile peer may write any value.
  /// Therefore use the word only where a wrong value harms only the peer.
  virtual std::uint64_t peer_word(std::size_t index);

  /// Returns on which CPU core the peer runs and whether the peer sleeps, as the peer has written
  /// into shared memory. The core is unknown_core when the medium shares no memory. Any thread may
  /// call this function.
  virtual Whereabouts peer_whereabouts();

  /// Sends a heartbeat. The maintenance thread calls this function every 100 ms. On shm and inproc,
  /// a heartbeat does not wake the peer.
  virtual void beat() = 0;
  /// Returns the number of received heartbeats; on lcm, packets count as heartbeats. The session
  /// uses this number to detect a silent peer: it measures the time in which the number does not
  /// rise.
  virtual std::uint64_t beats_seen() = 0;
  /// Returns the number of received heartbeats that have no unread packet before them. A packet
  /// counts as read at the first call of receive() after the call that returned the packet. On a
  /// medium that does not order heartbeats with packets, the result equals beats_seen(). Any thread
  /// may call this function.
  virtual std::uint64_t beats_read() { return beats_seen(); }

  /// Asks the kernel whether the connection is lost. On shm this is a system call: call this
  /// function at each tick and after a wake-up without a packet, but not for every packet. Packets
  /// that the peer sent before the loss can still be received. After this function has returned a
  /// loss, its result never changes.
  virtual Loss loss() = 0;
  /// Returns a text that says why the connection is lost; on lcm also why no peer answers.
  virtual std::string loss_text() const = 0;

  /// Returns a function that checks whether the medium would still admit this peer. The function
  /// returns the reason why not, for example that the key of the peer was removed, or an empty text
  /// while the medium would admit the peer. It reads files, so a call may take long. Any thread may
  /// call it, also after the end of the connection. later_refusal() returns null if the medium
  /// admits the peer for ever. Any thread may call later_refusal().
  virtual std::function<std::string()> later_refusal() { return nullptr; }

  /// Makes a stream for this peer alone, for example for samples from a client to its server. Use
  /// Acceptor::make_stream for many readers. `largest` is the largest size of a sample in bytes;
  /// `depth` is the number of samples that are kept. Throws a std::exception when no memory or no
  /// descriptor is left.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
  /// Lets the peer read `stream` under the number `id`. The session chooses `id`; each end numbers
  /// the streams that it shares. @pre this connection or its acceptor made `stream`.
  virtual tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) = 0;
  /// Ends the peer's access to the stream `id`.
  virtual void unshare(std::uint32_t id) = 0;
  /// Opens the stream that the peer shared under the number `id`. Returns null when the
  /// announcement of the stream has not arrived yet, or when the stream cannot be opened (see
  /// why_no_stream).
  virtual std::unique_ptr<StreamReader> open_stream(std::uint32_t id, const StreamBounds& most) = 0;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id) { return open_stream(id, {}); }
  /// Returns a text that says why the stream that the peer shared under the number `id` cannot be
  /// opened here. The text is empty while the announcement of the stream may still arrive.
  virtual std::string why_no_stream(std::uint32_t id);
};

/// A function that decides whether a client may connect. The parameter contains the data that the
/// kernel reports about the client, or the owner of the key that the client has proved. Returns why
/// the client is refused; an empty text admits the client. Must not throw.
using AdmitPeer = std::function<std::string(const Peer&)>;

struct MediumError {
  std::string text;  ///< what failed, where, and what to do
};

/// The server's side of one object on one medium. Makes a connection for each client that connects.
class Acceptor {
 public:
  /// Closes the acceptor. No client can connect afterwards, but existing connections stay open.
  virtual ~Acceptor() = default;
  virtual const Capabilities& capabilities() const = 0;
  /// Returns the address that a client passes to Medium::connect, for example
  /// "shm:/run/gecos/1f3a.sock".
  virtual const std::string& address() const = 0;
  /// Sets the function that decides about clients of other users; the kernel or a key names the
  /// user. A refused client gets no connection, but Loss::Refused with the reason. On shm, clients
  /// of root and of the server's own user are always admitted; if no function is set, all other
  /// clients are refused. On lcm, every admitted key may connect if no function is set. Call this
  /// before the first accept(). Does nothing on inproc.
  virtual void admit_by(AdmitPeer) {}
  /// Returns the connection to the next client that has connected, or null when there is none.
  virtual std::unique_ptr<Connection> accept() = 0;
  /// Returns whether a client is waiting but the process has no file descriptor left for a
  /// connection. Call accept() again later, because no event announces that a descriptor is free
  /// again.
  virtual bool short_of_descriptors() const { return false; }
  /// Returns the file descriptors that become readable when a client may have connected; on lcm
  /// also when packets for the acceptor's connections may have arrived.
  virtual std::span<const int> descriptors() const = 0;
  /// Makes a stream that all connections of this acceptor can share. `largest` is the largest size
  /// of a sample in bytes; `depth` is the number of samples that are kept.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
  /// Opens the channel `name` for messages in clear. Only the medium lcm has these channels; on any
  /// other medium, returns null.
  virtual tl::expected<std::unique_ptr<OpenChannel>, MediumError> open_channel(
      const std::string& name);
};

/// A medium: a way to move packets between programs. Makes acceptors and connections.
class Medium {
 public:
  virtual ~Medium() = default;
  virtual const Capabilities& capabilities() const = 0;
  /// Opens an address at which the clients of one object connect. If `well_known` is true, this is
  /// the well-known address of `name` on this host, as the broker needs. Otherwise the address is
  /// unique, and `name` serves only diagnostics.
  virtual tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                                      bool well_known) = 0;
  /// Connects to an address that `Acceptor::address` returned.
  virtual tl::expected<std::unique_ptr<Connection>, MediumError> connect(
      std::string_view address) = 0;
  /// Returns the well-known address of `name`, even when no server listens there.
  virtual std::string well_known_address(std::string_view name) const = 0;
  /// Returns further well-known addresses of `name`, which other users of this host have opened to
  /// all users. A client tries these addresses after the result of well_known_address().
  virtual std::vector<std::string> shared_addresses(std::string_view) const { return {}; }
};

}  // namespace gecos::media
