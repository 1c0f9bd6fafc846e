#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "gecos/base/descriptor.hpp"
#include "gecos/media/medium.hpp"

/// The messages on the socket of a connection: descriptors, and rare events. Calls go through
/// rings.
namespace gecos::media::shm {

enum class ControlType : std::uint32_t {
  Hello = 1,  ///< client: here are my memory and my eventfd
  Welcome,    ///< server: and here are mine
  Notify,     ///< look at the ring: instead of the eventfd, while it is unknown or not trusted
  Share,      ///< server: stream `id` of `depth` samples of at most `largest` bytes; its memory
  Unshare,    ///< server: stream `id` ends for you
  Bye,        ///< the link is closed in order; `text` says why when the peer was refused
  Area,       ///< memory for large packets, the `largest`-th of this side; the one before is over
  AreaEnd,    ///< nothing more comes through the `largest`-th
};

/// Both ends run on one kernel, so the struct is sent as it is in memory.
struct ControlMessage {
  static constexpr std::uint32_t this_version = 0x67630002;
  std::uint32_t version =
      this_version;  ///< rises with every change of this, of the ring, of the stream
  ControlType type = ControlType::Notify;
  std::uint32_t id = 0;
  std::uint32_t reserved = 0;
  std::uint64_t largest = 0;
  std::uint64_t depth = 0;
  std::array<char, 128> text{};  ///< ends with NUL

  void set_text(std::string_view words);
  std::string words() const;
};

enum class ControlRead : std::uint8_t {
  Message,
  Nothing,
  Ended,
  Garbage,
  NoDescriptors,  ///< it brought some, and this process may open no more
};

struct ReceivedControl {
  ControlMessage message;
  std::array<Descriptor, 2> descriptors;  ///< in the order sent; CLOEXEC
};

/// Never blocks. False: the socket's buffer is full or the peer has gone.
bool send_control(int socket, const ControlMessage& message, std::span<const int> descriptors = {});
/// Never blocks. Garbage: anything that is no message of ours, or brings too many descriptors.
ControlRead receive_control(int socket, ReceivedControl& into);

/// The peer of a connected socket, as the kernel reports it. Fails for a peer that the kernel
/// cannot name here: another user or process namespace.
tl::expected<Peer, std::string> peer_of(int socket);
/// A descriptor that becomes readable when the process at the other end dies. Fails when that
/// process has died already; empty when the kernel does not support it.
tl::expected<Descriptor, std::string> death_of_peer(int socket, std::int32_t pid);
/// True for an eventfd, which cannot be anything whose writing runs code of the peer.
bool is_event_fd(int descriptor);

}  // namespace gecos::media::shm
