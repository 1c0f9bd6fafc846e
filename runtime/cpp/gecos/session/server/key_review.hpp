#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/file_thread.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Checks whether the media of a server still admit its clients. For lcm, this means to read the
/// files with the clients' keys. A separate thread does this, so that a file system that does not
/// answer delays nothing else. `begin` and `take` never wait for files.
class KeyReview {
 public:
  /// A client that is not admitted any more, and the reason.
  struct Revoked {
    std::weak_ptr<ServerSession> session;
    std::string why;
  };

  KeyReview();

  /// Starts a check of the clients of these sessions. If a check is already running, the next check
  /// covers the sessions of the newest call.
  void begin(const std::vector<std::shared_ptr<ServerSession>>& sessions);
  /// Removes and returns the clients that a check found to be no longer admitted.
  std::vector<Revoked> take();

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  FileThread thread_;
};

}  // namespace gecos::session
