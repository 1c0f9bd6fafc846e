#include "gecos/session/server/user_callbacks.hpp"

#include <exception>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/process/maintenance.hpp"

namespace gecos::session {

UserCallbacks::UserCallbacks(Maintenance& maintenance, std::string object)
    : maintenance_(maintenance), object_(std::move(object)) {}

void UserCallbacks::run(const std::function<void()>& what) const {
  try {
    what();
  } catch (const std::exception& error) {
    log_error("session", object_ + ": on_stop or gecos_session_ended threw: " + error.what());
  } catch (...) {
    log_error(
        "session",
        object_ + ": on_stop or gecos_session_ended threw something that is no std::exception");
  }
}

void UserCallbacks::post(std::function<void()> what) {
  maintenance_.post([this, gate = gate_, what = std::move(what)] {
    const MutexLock lock(gate->mutex);
    if (!gate->ended) run(what);
  });
}

void UserCallbacks::end() {
  const MutexLock lock(gate_->mutex);
  gate_->ended = true;
}

}  // namespace gecos::session
