#include "gecos/session/protocol/receive_window.hpp"

#include <algorithm>
#include <utility>

namespace gecos::session {

ReceiveWindow::Verdict ReceiveWindow::arrived(std::uint64_t counter) {
  if (counter <= cumulative_ack_) return Verdict::Seen;
  if (counter - cumulative_ack_ > width) return Verdict::Beyond;
  if (later_[counter % width]) return Verdict::Seen;
  later_[counter % width] = true;
  advance();
  return Verdict::New;
}

void ReceiveWindow::abandoned(std::uint64_t counter) {
  if (counter <= cumulative_ack_) return;
  const std::uint64_t steps = std::min<std::uint64_t>(counter - cumulative_ack_, width);
  for (std::uint64_t step = 1; step <= steps; ++step)
    later_[(cumulative_ack_ + step) % width] = false;
  cumulative_ack_ = counter;
  advance();
}

void ReceiveWindow::advance() {
  while (later_[(cumulative_ack_ + 1) % width]) {
    ++cumulative_ack_;
    later_[cumulative_ack_ % width] = false;
  }
}

bool ReceiveWindow::seen(std::uint64_t counter) const {
  if (counter <= cumulative_ack_) return true;
  return counter - cumulative_ack_ <= width && later_[counter % width];
}

void ReplyCache::keep(std::uint64_t counter, Bytes packet) {
  if (counter <= acknowledged_) return;
  bytes_ += packet.size();
  kept_.push_back({counter, std::move(packet)});
  crowd_out();
}

/// Drops the oldest replies until the number and the size of the kept replies are within their
/// limits. Never drops the newest reply.
void ReplyCache::crowd_out() {
  while (kept_.size() > 1 && (kept_.size() > most_replies || bytes_ > room_)) {
    bytes_ -= kept_.front().packet.size();
    kept_.pop_front();
  }
}

void ReplyCache::shrink() {
  room_ = most_bytes_of_lost;
  crowd_out();
}

void ReplyCache::acknowledged(std::uint64_t counter) {
  if (counter <= acknowledged_) return;
  acknowledged_ = counter;
  const auto gone = std::remove_if(kept_.begin(), kept_.end(), [&](const Kept& kept) {
    if (kept.counter > counter) return false;
    bytes_ -= kept.packet.size();
    return true;
  });
  kept_.erase(gone, kept_.end());
}

const Bytes* ReplyCache::find(std::uint64_t counter) const {
  for (const auto& kept : kept_) {
    if (kept.counter == counter) return &kept.packet;
  }
  return nullptr;
}

}  // namespace gecos::session
