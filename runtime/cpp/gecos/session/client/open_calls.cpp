#include "gecos/session/client/open_calls.hpp"

#include <algorithm>

namespace gecos::session {

std::uint64_t OpenCalls::finished_up_to() const {
  const auto open = table_.lowest();
  return open != 0 ? open - 1 : next_counter_ - 1;
}

OpenCalls::List OpenCalls::take_repeatable() {
  List taken;
  for (auto& [counter, command] : table_.all()) {
    if (!command->again || command->retry.cancel) continue;
    table_.take(counter);
    taken.emplace_back(counter, std::move(command));
  }
  return taken;
}

bool OpenCalls::has_repeatable() const {
  return std::ranges::any_of(table_.all(),
                             [](const auto& call) { return call.second->again != nullptr; });
}

bool OpenCalls::everything_arrived() const {
  return std::ranges::all_of(table_.all(),
                             [](const auto& call) { return call.second->retry.arrived; });
}

}  // namespace gecos::session
