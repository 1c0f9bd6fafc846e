#include "gecos/media/shm/control_queue.hpp"

#include <span>
#include <utility>

namespace gecos::media::shm {

bool ControlQueue::send(Unsent unsent) {
  flush();
  if (unsent_.size() >= most_unsent) return false;
  unsent_.push_back(std::move(unsent));
  flush();
  return true;
}

void ControlQueue::flush() {
  while (!unsent_.empty()) {
    const Unsent& first = unsent_.front();
    const int memfd = first.memory == nullptr ? -1 : first.memory->memfd.get();
    const std::span<const int> given(&memfd, memfd >= 0 ? 1 : 0);
    if (!send_control(socket_, first.message, given)) return;
    unsent_.pop_front();
  }
}

}  // namespace gecos::media::shm
