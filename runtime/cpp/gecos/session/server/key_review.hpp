#pragma once

#include <memory>
#include <string>
#include <vector>

#include "gecos/base/file_thread.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {

/// Looks whether the media of a server still admit its clients. On lcm this reads the files of
/// their keys, so it happens on a thread of its own: a file system that does not answer delays
/// nothing else. `begin` and `take` never wait for files.
class KeyReview {
 public:
  /// A client that is not admitted any more, and why.
  struct Revoked {
    std::weak_ptr<ServerSession> session;
    std::string why;
  };

  KeyReview();

  /// Begins to look at the clients of these sessions. While an earlier look goes on, only the
  /// sessions of the last call are looked at next.
  void begin(const std::vector<std::shared_ptr<ServerSession>>& sessions);
  /// Removes and returns the clients that were found not to be admitted any more.
  std::vector<Revoked> take();

 private:
  struct Shared;
  const std::shared_ptr<Shared> shared_;
  FileThread thread_;
};

}  // namespace gecos::session
