#include "gecos/media/shm/connection.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "gecos/base/system_error.hpp"

namespace gecos::media::shm {
namespace {

constexpr std::size_t ring_bytes = RingMemory::bytes(usual_slot_count);
/// Returns how many streams an end may share and receive. A server has many clients, and each
/// stream that it reads needs a mapping; therefore a server accepts fewer streams from a client
/// than a client accepts from its server.
constexpr SharedStreams::Limits limits_of(ShmConnection::Role role) {
  constexpr std::size_t of_server = 1024;
  constexpr std::size_t of_client = 64;
  if (role == ShmConnection::Role::Server) return {.shared = of_server, .received = of_client};
  return {.shared = of_client, .received = of_server};
}
constexpr int most_messages_at_once = 64;  // so that a flood of messages cannot block the reader

/// Makes a connection. Returns the system's error text when no descriptor is left for the eventfd
/// of the connection.
tl::expected<std::unique_ptr<ShmConnection>, std::string> make_connection(
    ShmConnection::Role role, std::shared_ptr<PeerEnd> other, Peer peer, Descriptor death,
    SealedMemory own) {
  try {
    return std::make_unique<ShmConnection>(role, std::move(other), std::move(peer),
                                           std::move(death), std::move(own));
  } catch (const std::system_error& failed) {
    return tl::unexpected<std::string>(failed.what());
  }
}

constexpr const char* inherited_text =
    "this connection belongs to the process that forked this one: make a new connection";

}  // namespace

ShmConnection::ShmConnection(Role role, std::shared_ptr<PeerEnd> other, Peer peer, Descriptor death,
                             SealedMemory own)
    : role_(role),
      peer_(std::move(peer)),
      own_memory_(std::move(own)),
      own_(RingMemory::at(own_memory_.mapping.data(), usual_slot_count)),
      death_(std::move(death)),
      other_(std::move(other)),
      writer_(own_),
      bulk_(other_->socket(), writer_, [this] { read_control_to_the_end(); }),
      descriptors_{event_.descriptor(), other_->socket(), death_.get()},
      streams_(limits_of(role)),
      unsent_(other_->socket()),
      fork_watch_(this,
                  [](void* owner) noexcept { static_cast<ShmConnection*>(owner)->abandon(); }) {
  use_barriers(*own_.control);
}

tl::expected<std::unique_ptr<Connection>, MediumError> ShmConnection::greet(Descriptor socket,
                                                                            Peer peer,
                                                                            Descriptor death) {
  auto own = make_sealed("gecos client", ring_bytes);
  if (!own) return tl::unexpected(std::move(own.error()));
  auto made = make_connection(Role::Client, std::make_shared<PeerEnd>(std::move(socket)),
                              std::move(peer), std::move(death), std::move(*own));
  if (!made) return tl::unexpected(MediumError{"shm: " + made.error()});
  auto connection = std::move(*made);
  const std::array given{connection->own_memory_.memfd.get(), connection->event_.descriptor()};
  // If the server has refused the client, it may have closed the socket already. loss() then reads
  // the reason.
  if (!send_control(connection->other_->socket(), {.type = ControlType::Hello}, given) &&
      connection->loss() == Loss::None) {
    return tl::unexpected(MediumError{"shm: the server closed the connection at once"});
  }
  connection->own_memory_.memfd.reset();
  return connection;
}

tl::expected<std::unique_ptr<Connection>, std::string> ShmConnection::welcome(
    Descriptor socket, Peer peer, Descriptor death, ReceivedControl& hello) {
  const auto refuse = [](int to, std::string why) {
    ControlMessage bye{.type = ControlType::Bye};
    bye.set_text("the server has no room for another client: " + why);
    send_control(to, bye);
    return tl::unexpected(std::move(why));
  };
  auto own = make_sealed("gecos server", ring_bytes);
  if (!own) return refuse(socket.get(), std::move(own.error().text));
  auto end = std::make_shared<PeerEnd>(std::move(socket));
  auto made =
      make_connection(Role::Server, end, std::move(peer), std::move(death), std::move(*own));
  if (!made) return refuse(end->socket(), std::move(made.error()));
  auto connection = std::move(*made);
  if (auto problem = connection->know_peer(hello)) return tl::unexpected(std::move(*problem));
  const std::array given{connection->own_memory_.memfd.get(), connection->event_.descriptor()};
  if (!send_control(connection->other_->socket(), {.type = ControlType::Welcome}, given)) {
    return tl::unexpected<std::string>("the client closed the connection at once");
  }
  connection->own_memory_.memfd.reset();
  return connection;
}

ShmConnection::~ShmConnection() {
  // The destructor does not lock the mutex: no other thread uses a connection that is destroyed,
  // and in a forked child the mutex may stay locked for ever.
  streams_.forget(*other_);
  if (loss_.load() == Loss::None) {
    send_control(other_->socket(), ControlMessage{.type = ControlType::Bye});
  }
  other_->hang_up();
}

tl::expected<std::uint64_t, SendProblem> ShmConnection::send(ByteView head, ByteView body) {
  if (loss_.load(std::memory_order_relaxed) != Loss::None) {
    return tl::unexpected(SendProblem::Lost);
  }
  const bool large = head.size() + body.size() > largest_ring_packet;
  auto number = large ? bulk_.out.write(head, body) : writer_.write(head, body);
  if (number) wake_reader();
  return number;
}

tl::expected<std::uint64_t, SendProblem> ShmConnection::send_quietly(ByteView head, ByteView body) {
  if (head.size() + body.size() > largest_ring_packet) return send(head, body);
  if (loss_.load(std::memory_order_relaxed) != Loss::None) {
    return tl::unexpected(SendProblem::Lost);
  }
  auto number = writer_.write(head, body);
  if (number && writer_.half_full()) wake_reader();
  return number;
}

void ShmConnection::wake_reader() {
  // Before a server has sent its Welcome message, the server may sleep but cannot publish that it
  // sleeps. Therefore the client always wakes the server.
  if (other_->known() && !writer_.reader_sleeps()) return;
  note_ring(*own_.control);
  other_->wake();
}

std::optional<ByteView> ShmConnection::receive() {
  note_core(*own_.control);
  if (!other_->known()) {
    read_control();
    if (!other_->known()) return std::nullopt;
  }
  auto packet = reader_->read();
  if (!packet && reader_->broken()) {
    const MutexLock lock(control_mutex_);
    note_loss(Loss::Broken, "the peer wrote invalid data into its ring");
  }
  return packet;
}

std::optional<std::uint64_t> ShmConnection::taken_by_peer() {
  // A server sends its Welcome message before it reads a packet. Therefore a server that died
  // without this message has read no packet.
  if (!other_->known()) read_control();
  return writer_.taken();
}

bool ShmConnection::prepare_to_sleep() {
  bulk_.in.rest();
  const bool announced = announce_sleep(*own_.control);
  const bool packet = other_->known() && reader_->ready();
  if (announced && !packet && !watches_.anything_new() &&
      loss_.load(std::memory_order_seq_cst) == Loss::None) {
    return true;
  }
  own_.control->asleep.store(0, std::memory_order_relaxed);
  return false;
}

void ShmConnection::woke() {
  own_.control->asleep.store(0, std::memory_order_relaxed);
  // If the eventfd did not end the sleep, a message on the socket or the death of the peer may have
  // ended it.
  if (!event_.drain()) read_control();
}

void ShmConnection::write_word(std::size_t index, std::uint64_t value) {
  own_.control->words.at(index).store(value, std::memory_order_seq_cst);
}

std::uint64_t ShmConnection::peer_word(std::size_t index) {
  if (!other_->known()) return 0;  // a peer that has not answered has written no word
  return other_->ring().control->words.at(index).load(std::memory_order_seq_cst);
}

Whereabouts ShmConnection::peer_whereabouts() {
  if (!other_->known()) return {};
  return whereabouts(*other_->ring().control);
}

void ShmConnection::beat() {
  own_.control->beats.fetch_add(1, std::memory_order_relaxed);
  if (loss_.load(std::memory_order_relaxed) != Loss::None) return;
  bulk_.out.beat();
  const MutexLock lock(control_mutex_);
  streams_.follow_moves(unsent_);
  unsent_.flush();
}

std::uint64_t ShmConnection::beats_seen() {
  if (!other_->known()) return 0;
  return other_->ring().control->beats.load(std::memory_order_relaxed);
}

Loss ShmConnection::loss() {
  read_control();
  return loss_.load(std::memory_order_relaxed);
}

std::string ShmConnection::loss_text() const {
  if (loss_.load(std::memory_order_relaxed) == Loss::None) return {};
  const MutexLock lock(control_mutex_);
  return loss_text_.empty() ? inherited_text : loss_text_;
}

std::unique_ptr<StreamWriter> ShmConnection::make_stream(std::size_t largest, std::size_t depth) {
  return make_shared_stream(largest, depth);
}

tl::expected<void, SendProblem> ShmConnection::share(std::uint32_t id, StreamWriter& stream) {
  if (loss_.load(std::memory_order_relaxed) != Loss::None) {
    return tl::unexpected(SendProblem::Lost);
  }
  auto& writer = dynamic_cast<SharedStreamWriter&>(stream);
  const MutexLock lock(control_mutex_);
  return streams_.share(id, writer, other_, unsent_);
}

void ShmConnection::unshare(std::uint32_t id) {
  if (loss_.load(std::memory_order_relaxed) != Loss::None) return;
  const MutexLock lock(control_mutex_);
  streams_.unshare(id, *other_, unsent_);
}

std::unique_ptr<StreamReader> ShmConnection::open_stream(std::uint32_t id,
                                                         const StreamBounds& most) {
  read_control();
  if (loss_.load(std::memory_order_relaxed) != Loss::None) return nullptr;
  const MutexLock lock(control_mutex_);
  return streams_.open(id, most, watches_);
}

std::string ShmConnection::why_no_stream(std::uint32_t id) {
  const MutexLock lock(control_mutex_);
  return streams_.why_not_open(id);
}

/// Takes the memory and the eventfd that the peer has sent. Returns an error text when they are
/// invalid; otherwise nullopt.
std::optional<std::string> ShmConnection::know_peer(ReceivedControl& from) {
  auto& [memfd, event] = from.descriptors;
  if (!memfd || !event) return "the peer did not send its memory and its eventfd";
  auto mapping = map_received(memfd.get(), ring_bytes);
  if (!mapping) return std::move(mapping.error().text);
  const bool trusted = peer_.uid == ::geteuid() && is_event_fd(event.get());
  const RingMemory ring = RingMemory::at(mapping->data(), usual_slot_count);
  reader_.emplace(*own_.control, ring, &bulk_.in);
  writer_.set_reader(ring.control);
  other_->know(std::move(*mapping), trusted ? std::move(event) : Descriptor());
  return std::nullopt;
}

void ShmConnection::read_control() {
  if (loss_.load(std::memory_order_acquire) != Loss::None) return;
  std::array<pollfd, 2> watched{pollfd{other_->socket(), POLLIN, 0},
                                pollfd{death_.get(), POLLIN, 0}};
  if (::poll(watched.data(), watched.size(), 0) <= 0) return;
  const MutexLock lock(control_mutex_);
  ReceivedControl control;
  ControlRead read = ControlRead::Message;
  for (int i = 0; i < most_messages_at_once && loss_.load() == Loss::None; ++i) {
    read = receive_control(other_->socket(), control);
    if (read == ControlRead::Nothing) break;
    if (read == ControlRead::Message) {
      take_control(control);
    } else if (read == ControlRead::Ended) {
      note_loss(Loss::Died, peer_.description + " closed its socket without a message");
    } else if (read == ControlRead::NoDescriptors) {
      const std::string why =
          "no file descriptor is left to receive the descriptors of the peer: " +
          system_text(EMFILE);
      if (control.message.type == ControlType::Share &&
          streams_.not_received(control.message.id, why)) {
        event_.notify();  // a thread that waits for this stream may be asleep
      } else {
        note_loss(Loss::Broken, why);
      }
    } else {
      note_loss(Loss::Broken, "the peer sent a message of another format or version");
    }
  }
  // The death of the peer counts only when all its messages have been read. A peer that sent Bye
  // before its end has closed the connection, and has not died.
  if (watched[1].revents != 0 && read == ControlRead::Nothing) {
    note_loss(Loss::Died, peer_.description + " has ended");
  }
}

void ShmConnection::read_control_to_the_end() {
  read_control();
  const MutexLock another_thread_has_taken_up_what_it_read(control_mutex_);
}

void ShmConnection::take_control(ReceivedControl& control) {
  const ControlMessage& message = control.message;
  switch (message.type) {
    case ControlType::Notify:
      // If loss() has read this message, the thread that sleeps on the socket does not see the
      // message. Therefore that thread is woken by its eventfd.
      if (own_.control->asleep.load(std::memory_order_seq_cst) != 0) event_.notify();
      return;
    case ControlType::Bye: {
      const std::string why = message.words();
      note_loss(Loss::Closed, why.empty() ? "the other end closed the connection" : why);
      return;
    }
    case ControlType::Refuse:
      if (role_ != Role::Client || other_->known()) break;
      note_loss(Loss::Refused, message.words());
      return;
    case ControlType::Welcome:
      if (role_ != Role::Client || other_->known()) break;
      if (auto problem = know_peer(control)) {
        note_loss(Loss::Broken, std::move(*problem));
      } else {
        event_.notify();  // wakes a thread that fell asleep before it could read the ring
      }
      return;
    case ControlType::Share:
      if (auto problem = streams_.received(control)) {
        note_loss(Loss::Broken, std::move(*problem));
      } else {
        event_.notify();  // a thread that waits for this stream may be asleep
      }
      return;
    case ControlType::Unshare:
      streams_.withdrawn(message.id);
      return;
    case ControlType::Area:
    case ControlType::AreaEnd: {
      auto taken = bulk_.take(control);
      if (!taken) note_loss(Loss::Broken, std::move(taken.error()));
      return;
    }
    case ControlType::Hello:
      break;
  }
  note_loss(Loss::Broken, "the peer sent a message that is not allowed in this state");
}

void ShmConnection::note_loss(Loss loss, std::string text) {
  if (loss_.load(std::memory_order_relaxed) != Loss::None) return;
  loss_text_ = std::move(text);
  loss_.store(loss, std::memory_order_seq_cst);
  event_.notify();  // for another thread, which the message that was read here no longer wakes
}

void ShmConnection::abandon() noexcept {
  loss_.store(Loss::Broken);
  event_.close();
  death_.reset();
  other_->forget();
  bulk_.out.forget();
  bulk_.in.forget();
  own_memory_.memfd.reset();
  own_memory_.mapping.forget();
}

}  // namespace gecos::media::shm
