#include "gecos/session/client/status_use.hpp"

#include <algorithm>
#include <utility>

#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl

namespace gecos::session {
namespace {

bool has_ended(const std::shared_ptr<CommandCore>& command) {
  return project(command->progress().detail) != State::Running;
}

bool is_granted(const std::shared_ptr<CommandCore>& request) {
  return request->progress().detail == Detail::Done;
}

}  // namespace

bool StatusUse::concerns(FunctionCode operation) {
  return operation == GecosObjectInterface::acquire.code ||
         operation == GecosObjectInterface::release.code;
}

void StatusUse::issued(FunctionCode operation, std::shared_ptr<CommandCore> command) {
  --begun_;
  const bool asks = operation == GecosObjectInterface::acquire.code;
  (asks ? requests_ : releases_).push_back(std::move(command));
  in_use();  // called only because it forgets the requests and releases that have ended
}

bool StatusUse::in_use() {
  const auto open = std::partition(releases_.begin(), releases_.end(), has_ended);
  for (auto ended = releases_.begin(); ended != open; ++ended) {
    const auto released = std::ranges::find_if(requests_, is_granted);
    if (released != requests_.end()) requests_.erase(released);
  }
  releases_.erase(releases_.begin(), open);
  std::erase_if(requests_, [](const auto& request) {  // forgets the refused requests
    return has_ended(request) && !is_granted(request);
  });
  return begun_ != 0 || !requests_.empty();
}

}  // namespace gecos::session
