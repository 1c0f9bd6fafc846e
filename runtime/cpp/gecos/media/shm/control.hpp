#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

/// The messages on the Unix socket of a connection. They carry file descriptors and announce rare
/// events. Packets go through the rings, not through the socket.
namespace gecos::media::shm {

enum class ControlType : std::uint32_t {
  Hello = 1,  ///< client: sends the descriptors of its memory and its eventfd
  Welcome,    ///< server: sends the descriptors of its memory and its eventfd
  Notify,     ///< wakes the peer while its eventfd is unknown or not trusted
  Share,      ///< memory of the stream `id`: `depth` samples of at most `largest` bytes
  Unshare,    ///< the stream `id` is no longer shared
  Bye,        ///< closes the connection; `text` may say why
  Area,       ///< memory for large packets, area number `largest`; the previous area is freed
  AreaEnd,    ///< the area number `largest` is freed
  Refuse,     ///< server: does not admit the client; `text` says why
};

/// A message on the socket. The struct is sent as it is in memory, because both ends run on one
/// kernel.
struct ControlMessage {
  static constexpr std::uint32_t this_version = 0x67630003;
  std::uint32_t version =
      this_version;  ///< rises with every change of this struct, RingMemory or StreamMemory
  ControlType type = ControlType::Notify;
  std::uint32_t id = 0;
  std::uint32_t reserved = 0;
  std::uint64_t largest = 0;
  std::uint64_t depth = 0;
  std::array<char, 512> text{};  ///< ends with NUL

  void set_text(std::string_view words);
  std::string words() const;
};

enum class ControlRead : std::uint8_t {
  Message,
  Nothing,
  Ended,
  Garbage,
  NoDescriptors,  ///< the message has descriptors, but this process cannot open more
};

struct ReceivedControl {
  ControlMessage message;
  std::array<Descriptor, 2> descriptors;  ///< in the order sent; CLOEXEC
};

/// Sends a message and descriptors over `socket`. Never blocks. Returns false when the buffer of
/// the socket is full, or when the peer has closed its socket.
bool send_control(int socket, const ControlMessage& message, std::span<const int> descriptors = {});
/// Receives the next message from `socket`. Never blocks. Returns Garbage for a message that has
/// another format or version, or too many descriptors.
ControlRead receive_control(int socket, ReceivedControl& into);

/// Returns the peer of a connected socket, as the kernel reports it. Fails for a peer in another
/// user namespace or process namespace, because the kernel cannot report the ids of this peer here.
tl::expected<Peer, std::string> peer_of(int socket);
/// Returns a descriptor that becomes readable when the process at the other end dies. Fails when
/// that process has died already. Returns an empty Descriptor when the kernel does not support such
/// descriptors.
tl::expected<Descriptor, std::string> death_of_peer(int socket, std::int32_t pid);
/// Returns whether `descriptor` is an eventfd. Must be called before a write to a descriptor of the
/// peer, because a write to another kind of file may run code of the peer.
bool is_event_fd(int descriptor);

}  // namespace gecos::media::shm
