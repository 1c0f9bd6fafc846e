#include "gecos/session/server/key_review.hpp"

#include <functional>
#include <utility>

#include "gecos/base/mutex.hpp"

namespace gecos::session {

/// The data that the thread of a KeyReview uses. The data outlive the KeyReview if the file system
/// does not answer, so they do not own the sessions.
struct KeyReview::Shared {
  struct Look {
    std::weak_ptr<ServerSession> session;
    std::function<std::string()> refusal;
  };
  void work();

  Mutex mutex;
  std::vector<Look> looks GECOS_GUARDED_BY(mutex);
  std::vector<Revoked> revoked GECOS_GUARDED_BY(mutex);
};

void KeyReview::Shared::work() {
  std::vector<Look> now;
  {
    const MutexLock lock(mutex);
    now.swap(looks);
  }
  for (Look& look : now) {
    std::string why = look.refusal();
    if (why.empty()) continue;
    const MutexLock lock(mutex);
    revoked.push_back({std::move(look.session), std::move(why)});
  }
}

KeyReview::KeyReview()
    : shared_(std::make_shared<Shared>()),
      thread_("gecos-keys", [shared = shared_] { shared->work(); }) {}

void KeyReview::begin(const std::vector<std::shared_ptr<ServerSession>>& sessions) {
  std::vector<Shared::Look> looks;
  for (const auto& session : sessions) {
    if (auto refusal = session->connection().later_refusal()) {
      looks.push_back({session, std::move(refusal)});
    }
  }
  if (looks.empty()) return;
  {
    const MutexLock lock(shared_->mutex);
    shared_->looks = std::move(looks);
  }
  thread_.ask();
}

std::vector<KeyReview::Revoked> KeyReview::take() {
  const MutexLock lock(shared_->mutex);
  return std::exchange(shared_->revoked, {});
}

}  // namespace gecos::session
