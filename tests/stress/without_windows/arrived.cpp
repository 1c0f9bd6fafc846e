// In place of ReceiveWindow::arrived: a call that arrives again is a new one.
#include "gecos/session/protocol/receive_window.hpp"

namespace gecos::session {

ReceiveWindow::Verdict ReceiveWindow::arrived(std::uint64_t counter) {
  if (counter > cumulative_ack_) cumulative_ack_ = counter;
  return Verdict::New;
}

}  // namespace gecos::session
