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

/// The contract of a medium: opaque packets between two endpoints, and what can be promised of
/// them.
///
/// Nothing above this file knows how a medium works; nothing below it knows what a packet means.
/// One conformance suite (tests/cpp/media) runs on every medium.
///
/// Threads: of one link receive(), prepare_to_sleep() and woke() belong to one thread at a time,
/// and send(), make_stream(), share() and unshare() to one at a time (the two may differ); the user
/// of the link must ensure that. Any thread may call all other functions of a link at any time;
/// maintenance may call beat() while another thread is in send(). An acceptor belongs to one thread
/// at a time; its links need not be used by the same one.
///
/// A forked child sees links and acceptors of its parent as dead (Broken); it makes its own.
namespace gecos::media {

/// How far a medium leads.
enum class Reach : std::uint8_t {
  Process,  ///< within one process
  Host,     ///< between programs that share a runtime directory of one host
  Network,  ///< between hosts
};

/// What a medium promises for a link, before anything is measured. Code must check these members
/// instead of the medium's name.
struct Offer {
  std::string_view name = "inproc";  ///< begins its addresses; of static storage
  Reach reach = Reach::Process;
  bool ordered = true;
  bool reliable = true;  ///< nothing is lost or repeated while both ends live
  bool intact = true;  ///< packets arrive undamaged; else the medium must be wrapped (checked.hpp)
  bool real_time = true;           ///< no shared queue, no loss: fit for HARD_REALTIME
  bool reports_death = true;       ///< the kernel says when the peer has died
  bool authenticated = true;       ///< the peer's user is proved
  bool overheard = false;          ///< others receive what is sent: it must be sealed
  bool connectionless = false;     ///< only silence shows that a server is absent, and the acceptor
                                   ///< receives for its links
  bool shared_words = false;       ///< write_word() and peer_word() work
  std::size_t largest_packet = 0;  ///< bytes
  std::size_t piece = 0;  ///< bytes of a packet in a piece; 0: largest_packet less a piece's header
};

/// The peer at the other end, as far as the medium itself knows it.
struct Peer {
  std::optional<std::uint32_t> uid;  ///< reported by the kernel; nullopt when it cannot
  std::optional<std::int32_t> pid;
  std::string
      description;  ///< for people: "uid 1000, pid 4711", "key 3fa9c1d2, 239.255.76.67:20017"
};

enum class SendProblem : std::uint8_t {
  Full,      ///< no room until the peer has taken packets; nothing was sent, try again
  TooLarge,  ///< never fits; nothing was sent
  Lost,      ///< the link is gone; nothing was sent
};

enum class Loss : std::uint8_t {
  None,    ///< as far as the medium knows the peer is there
  Closed,  ///< the peer closed the link in order
  Died,  ///< the kernel reported that the peer's process ended or closed its socket without a word
  Broken,  ///< the peer broke the rules of the medium (text in Link::loss_text)
};

/// One sample of a stream as stored in the medium.
struct StreamSample {
  std::uint64_t sequence = 0;  ///< 1 for the first of this stream, then rising by one
  std::int64_t stamp_ns = 0;   ///< when it was measured, Unix time in ns, by the writer's clock
  Bytes bytes;
};

/// A sample that is read in place.
struct LentSample {
  std::uint64_t sequence = 0;
  std::int64_t stamp_ns = 0;
  ByteView bytes;
};

/// Writes one stream; every reader that it is shared with sees every sample. One thread writes at a
/// time. Never waits for a reader: a slow reader loses old samples.
class StreamWriter {
 public:
  virtual ~StreamWriter() = default;
  /// Publishes a copy and wakes the readers that sleep. Fails with TooLarge only.
  virtual tl::expected<void, SendProblem> publish(ByteView sample, std::int64_t stamp_ns) = 0;
  /// Lends memory for the next sample, of which `size` bytes count; their values are undefined. The
  /// sample is written in place: nothing is copied where the memory is shared. A loan that is not
  /// published ends with the next call of lend() or publish(). Fails with TooLarge only.
  virtual tl::expected<std::span<std::byte>, SendProblem> lend(std::size_t size) = 0;
  /// Publishes what was written into the loan, and wakes the readers that sleep. @pre a loan
  virtual void publish_lent(std::int64_t stamp_ns) = 0;
};

/// Reads one stream. One thread at a time.
class StreamReader {
 public:
  virtual ~StreamReader() = default;
  /// The newest sample, when there is one that is newer than `after`. Reuses `into`'s memory.
  virtual bool latest(std::uint64_t after, StreamSample& into) = 0;
  /// The oldest sample kept that is newer than `after`; the gap in sequence says how many were
  /// lost. The first sample is the one that was the newest when the stream was opened.
  virtual bool next(std::uint64_t after, StreamSample& into) = 0;
  /// As latest(), without a copy. The bytes stay readable while the reader lives and until its next
  /// call of lend_latest(). In shared memory the writer never waits, and writes over them after as
  /// many samples as the stream keeps: what was read counts only if intact() says so afterwards.
  /// The peer may be hostile: check what was computed, never read a length twice.
  virtual std::optional<LentSample> lend_latest(std::uint64_t after) = 0;
  /// Whether the bytes of `sample` are still those that were lent.
  virtual bool intact(const LentSample& sample) const = 0;
};

inline constexpr std::size_t shared_word_count = 4;

/// One end of a connection between a client and a server.
class Link {
 public:
  virtual ~Link() = default;  ///< closes in order: the peer sees Closed

  virtual const Offer& offer() const = 0;
  virtual const Peer& peer() const = 0;

  /// Sends head and body as one packet; both are copied before it returns. Never blocks. Returns
  /// the packet's number on this link: 1 for the first, rising by one.
  virtual tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) = 0;

  /// The next packet, when one is there. The bytes are a private copy and stay valid until the next
  /// call, or prepare_to_sleep(). Never blocks, costs no system call on shm and inproc when nothing
  /// is there.
  virtual std::optional<ByteView> receive() = 0;

  /// How long ago the packet that receive() returned last was sent, even when this process was
  /// stopped meanwhile. Zero when the medium cannot know; taken_by_peer() then tells which packets
  /// were taken.
  virtual Duration age() { return Duration::zero(); }

  /// How much later our CLOCK_BOOTTIME reads than the peer's, plus the shortest transit time of a
  /// packet of the peer so far: the smallest difference seen. nullopt when both ends read one
  /// clock.
  virtual std::optional<Duration> clock_difference() { return std::nullopt; }

  /// Number of our packets that the peer has taken; stays readable after the peer's death. nullopt
  /// when the medium cannot know.
  virtual std::optional<std::uint64_t> taken_by_peer() = 0;

  /// Announces that this end is about to sleep on `descriptors()`. Returns false when a packet is
  /// there already or the link is lost: do not sleep. In both cases call `woke()` afterwards.
  virtual bool prepare_to_sleep() = 0;
  virtual void woke() = 0;
  /// Readable when a packet or sample may be there or the link was lost. Valid for the link's life;
  /// may be polled level- or edge-triggered; woke() makes them unreadable again. With
  /// edge-triggered polling, call loss() on every event received while not prepared to sleep; no
  /// second event may follow. A lost link may stay readable. Where the medium is connectionless,
  /// packets of links that an acceptor made come through the acceptor's descriptors: poll those as
  /// well, and call accept() when they are readable.
  virtual std::span<const int> descriptors() const = 0;

  /// Words that this end writes and the peer reads in place, zero at first. No packet carries them,
  /// and neither end needs to run for the other to write or read: a suspended process finds them
  /// when it continues. Sequentially consistent; any thread. @pre offer().shared_words and `index`
  /// < shared_word_count
  virtual void write_word(std::size_t index, std::uint64_t value);
  /// A word of the peer, which may hold any value: trust it only where a wrong value harms the peer
  /// alone.
  virtual std::uint64_t peer_word(std::size_t index);

  /// Where the peer runs, read in place. Unknown when no memory is shared. Any thread.
  virtual Whereabouts peer_whereabouts();

  /// Sends a heartbeat; maintenance calls it every 100 ms. On shm and inproc it does not wake the
  /// peer.
  virtual void beat() = 0;
  /// Number of heartbeats seen; on lcm, packets count as heartbeats. The session detects silence,
  /// with its own clock, when this number does not rise.
  virtual std::uint64_t beats_seen() = 0;
  /// Of these, the ones before which nothing is left unread: `receive` has returned all packets
  /// that arrived earlier, and was called again after the last of them. Any thread. Where
  /// heartbeats do not stand in one order with packets, all that were seen.
  virtual std::uint64_t beats_read() { return beats_seen(); }

  /// Whether the peer is still there, asked of the kernel: a system call on shm, so for ticks and
  /// for waking up with nothing received, not for every packet. What the peer had sent before can
  /// still be received. The first loss stays.
  virtual Loss loss() = 0;
  virtual std::string loss_text() const = 0;  ///< on lcm also why no peer was found yet

  /// A stream to this peer alone, for samples from a client to the server. An acceptor makes
  /// streams for many readers. `largest` in bytes, `depth` samples kept. Throws std::exception when
  /// no memory or no descriptor is left.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
  /// Lets the peer read `stream` under `id`, which the session chooses; each end numbers the
  /// streams that it shares. `stream` was made by this link or by its acceptor.
  virtual tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) = 0;
  /// Ends the peer's access to the stream `id`.
  virtual void unshare(std::uint32_t id) = 0;
  /// The stream that the peer shared under `id`; null while it has not arrived.
  virtual std::unique_ptr<StreamReader> open_stream(std::uint32_t id) = 0;
  /// Why a stream cannot be opened here although the peer shared it under `id`; empty while it may
  /// still arrive.
  virtual std::string why_no_stream(std::uint32_t id);
};

/// Server side of one object on one medium: makes a link for each client that connects.
class Acceptor {
 public:
  virtual ~Acceptor() = default;  ///< no client can connect afterwards; links stay open
  virtual const Offer& offer() const = 0;
  /// What a client passes to Medium::connect: "shm:/run/gecos/1f3a.sock".
  virtual const std::string& address() const = 0;
  /// The link of the next client that has connected, or null.
  virtual std::unique_ptr<Link> accept() = 0;
  /// A client is waiting but the process is out of file descriptors. Retry accept() later; no event
  /// will announce it.
  virtual bool short_of_descriptors() const { return false; }
  /// Readable when a client may have connected. (lcm: also when packets for its links are there.)
  virtual std::span<const int> descriptors() const = 0;
  /// A stream that links of this acceptor can share. `largest` in bytes, `depth` samples kept.
  virtual std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) = 0;
};

struct MediumError {
  std::string text;  ///< what failed, where, and what to do
};

/// A way to move packets: makes acceptors and links.
class Medium {
 public:
  virtual ~Medium() = default;
  virtual const Offer& offer() const = 0;
  /// Opens a place for clients of one object. `name` is only for diagnostics; addresses are unique
  /// anyway, unless `well_known` requests the one well-known place of this host (the broker's).
  virtual tl::expected<std::unique_ptr<Acceptor>, MediumError> listen(std::string_view name,
                                                                      bool well_known) = 0;
  /// Connects to an address returned by `Acceptor::address`.
  virtual tl::expected<std::unique_ptr<Link>, MediumError> connect(std::string_view address) = 0;
  /// The address of the well-known place, whether or not a server is there.
  virtual std::string well_known_address(std::string_view name) const = 0;
};

}  // namespace gecos::media
