#include "gecos/media/shm/peer_end.hpp"

#include <sys/socket.h>

#include <utility>

#include "gecos/base/event_fd.hpp"
#include "gecos/media/shm/control.hpp"

namespace gecos::media::shm {

void PeerEnd::know(Mapping mapping, Descriptor event) {
  mapping_ = std::move(mapping);
  event_ = std::move(event);
  known_.store(true, std::memory_order_release);
}

void PeerEnd::wake() {
  if (known() && event_) {
    notify_event_fd(event_.get());
  } else {
    // Sending fails when the socket is full. The messages that fill the socket then wake the peer.
    send_control(socket_.get(), ControlMessage{.type = ControlType::Notify});
  }
}

void PeerEnd::wake_if_asleep() {
  if (known() && ring().control->asleep.load(std::memory_order_seq_cst) != 0) wake();
}

void PeerEnd::hang_up() { ::shutdown(socket_.get(), SHUT_RDWR); }

void PeerEnd::forget() {
  socket_.reset();
  event_.reset();
  mapping_.forget();
}

}  // namespace gecos::media::shm
