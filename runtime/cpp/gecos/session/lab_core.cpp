#include "gecos/session/lab_core.hpp"

#include <cstdlib>
#include <utility>

#include "gecos/session/linked_session.hpp"
#include "gecos/session/registry.hpp"
#include "gecos/session/renewal.hpp"

namespace gecos::session {

LabCore::LabCore(std::shared_ptr<Runtime> runtime)
    : runtime_(std::move(runtime)), renewal_(std::make_shared<Renewal>(*this)) {}

LabCore::~LabCore() { renewal_->end(); }

bool LabCore::keep(const std::shared_ptr<LinkedSession>& session) {
  const std::lock_guard lock(keeping_);
  if (closed_) return false;
  std::erase_if(kept_, [](const auto& known) { return known.expired(); });
  kept_.push_back(session);
  return true;
}

bool LabCore::closed() const {
  const std::lock_guard lock(keeping_);
  return closed_;
}

void LabCore::close(Duration patience) {
  const TimePoint give_up = deadline_after(patience);
  std::vector<std::weak_ptr<LinkedSession>> kept;
  {
    const std::lock_guard lock(keeping_);
    closed_ = true;
    kept.swap(kept_);
  }
  for (const auto& known : kept) {
    if (const auto session = known.lock()) {
      const Duration left = give_up - std::chrono::steady_clock::now();
      session->close(std::max(left, 2 * runtime_->options().heartbeat));  // who is stuck takes no other's share
    }
  }
  renewal_->end();
}

std::vector<std::string> LabCore::broker_addresses() {
  std::string named = runtime_->options().broker;
  if (named.empty()) {
    const char* variable = std::getenv("GECOS_BROKER");
    if (variable != nullptr) named = variable;
  }
  std::vector<std::string> addresses;
  const auto add_well_known = [&](media::Kind kind) {
    if (const auto opened = runtime_->medium(kind)) {
      addresses.push_back((*opened)->well_known_address(broker_name));
    }
  };
  if (const auto kind = media::kind_from(named)) {  // "lcm": its well-known place
    add_well_known(*kind);
  } else if (!named.empty()) {
    addresses.push_back(named);
  } else {
    add_well_known(media::Kind::Inproc);
    add_well_known(media::Kind::Shm);
  }
  return addresses;
}

tl::expected<std::shared_ptr<LinkedSession>, std::string> LabCore::broker(TimePoint deadline) {
  std::unique_lock lock(mutex_);
  if (!looked_.wait_until(lock, deadline, [this] { return !looking_; })) {
    return tl::unexpected(std::string("no broker was found in time: another thread of this program still asks one"));
  }
  looking_ = true;
  lock.unlock();
  struct Looking {
    ~Looking() {
      const std::lock_guard again(lab.mutex_);
      lab.looking_ = false;
      lab.looked_.notify_one();
    }
    LabCore& lab;
  } const looking{*this};
  return look_for_broker(deadline);
}

tl::expected<std::shared_ptr<LinkedSession>, std::string> LabCore::look_for_broker(TimePoint deadline) {
  if (broker_ && !broker_->lost()) return broker_;
  broker_.reset();
  std::string tried;
  for (const auto& address : broker_addresses()) {
    auto session = runtime_->connect(address, broker_interface(), deadline);
    if (session) return broker_ = std::move(*session);
    tried += (tried.empty() ? "" : "; ") + session.error();
  }
  return tl::unexpected("no broker answers; start `gecos broker`, or say where it is in GECOS_BROKER" +
                        (tried.empty() ? std::string() : " (tried " + tried + ")"));
}

}  // namespace gecos::session
