#include "gecos/session/process/handler_here.hpp"

#include <utility>

namespace gecos::session {
namespace {

thread_local HandlerHere* dispatched_here = nullptr;
thread_local std::weak_ptr<HandlerHere> pulled_here;

std::shared_ptr<HandlerHere> handler_here() {
  return dispatched_here != nullptr ? dispatched_here->shared() : pulled_here.lock();
}

}  // namespace

RunsHere::RunsHere(HandlerHere& call) : before_(std::exchange(dispatched_here, &call)) {}
RunsHere::~RunsHere() { dispatched_here = before_; }

void runs_here(std::weak_ptr<HandlerHere> call) { pulled_here = std::move(call); }

WaitsHere::WaitsHere(const CommandCore& command) : handler_(handler_here()) {
  if (handler_ != nullptr) handler_->waits(command);
}

WaitsHere::~WaitsHere() {
  if (handler_ != nullptr) handler_->goes_on();
}

}  // namespace gecos::session
