#include "gecos/session/server/clear_sender.hpp"

#include <utility>

#include "gecos/session/protocol/open_message.hpp"

namespace gecos::session {

void ClearSender::add(std::string_view medium, std::unique_ptr<media::OpenChannel> channel) {
  channels_.insert_or_assign(medium, std::move(channel));
}

bool ClearSender::allow(bool allowed) { return std::exchange(allowed_, allowed) != allowed; }

void ClearSender::send(ByteView sample, FunctionRef<void(std::string_view medium)> too_large) {
  if (!allowed_ || channels_.empty()) return;
  write_open_message(message_, fingerprint_, sample);
  for (const auto& [medium, channel] : channels_) {
    if (!channel->publish(message_)) too_large(medium);
  }
}

}  // namespace gecos::session
