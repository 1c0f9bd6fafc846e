#include <utility>

#include "gecos/line.hpp"

namespace gecos {

LineState line_state(const Object& proxy) { return session_of(proxy)->line(); }

LineWatch::LineWatch(const Object& proxy)
    : session_(session_of(proxy)), changes_(session_->line().changes) {}

std::optional<LineState> LineWatch::next(Duration patience) {
  LineState state = session_->await_line_change(changes_, deadline_after(patience));
  if (state.changes == changes_) return std::nullopt;
  changes_ = state.changes;
  return state;
}

}  // namespace gecos
