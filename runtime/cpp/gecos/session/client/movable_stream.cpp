#include "gecos/session/client/movable_stream.hpp"

#include <algorithm>
#include <iterator>
#include <utility>

namespace gecos::session {

std::shared_ptr<ClientStream> MovableStream::core() const {
  const MutexLock lock(mutex_);
  return core_;
}

void MovableStream::go_on_in(std::shared_ptr<ClientStream> core) {
  {
    const MutexLock lock(mutex_);
    core_.swap(core);
    if (stopped_) core_->stop_waiting();
  }
  core->stop_waiting();
}

void MovableStream::stop_waiting() {
  const MutexLock lock(mutex_);
  stopped_ = true;
  core_->stop_waiting();
}

/// Makes `core` the stream from which the reader reads. The previous stream is destroyed on the
/// maintenance thread, because that stream may be the last user of its session, and the end of a
/// session takes a while.
void MovableStream::read_from(std::shared_ptr<ClientStream> core) {
  if (core == read_) return;
  read_.swap(core);
  runtime_.maintenance().post([left = std::move(core)] {});
}

bool MovableStream::latest(RawSample& into) {
  read_from(core());
  return read_->latest(into);
}

bool MovableStream::lend_latest(RawLent& into) {
  read_from(core());
  return read_->lend_latest(into);
}

std::vector<RawSample> MovableStream::history() {
  const auto newest = core();
  auto kept = read_->history();
  if (read_ == newest) return kept;
  // The reader has not changed to the new medium yet. Each of the two media may keep samples that
  // the other one does not have.
  auto newer = newest->history();
  if (!newer.empty()) {
    std::erase_if(kept, [first = newer.front().sequence](const RawSample& sample) {
      return sample.sequence >= first;
    });
  }
  std::ranges::move(newer, std::back_inserter(kept));
  return kept;
}

tl::expected<void, StreamEnd> MovableStream::next(RawSample& into, TimePoint deadline) {
  return next_of(into.sequence, [&] { return read_->next(into, deadline); });
}

tl::expected<void, StreamEnd> MovableStream::lend_next(RawLent& into, TimePoint deadline) {
  return next_of(into.sequence, [&] { return read_->lend_next(into, deadline); });
}

/// Reads the next sample with `read`, which waits for it, and changes to the stream over the new
/// medium when the session has moved. `sequence`: the number of the sample that was read last.
tl::expected<void, StreamEnd> MovableStream::next_of(
    const std::uint64_t& sequence, FunctionRef<tl::expected<void, StreamEnd>()> read) {
  for (;;) {
    const auto newest = core();
    // Before the reader changes to the new medium, it takes the samples that have arrived over the
    // old medium, because the new medium may not have them.
    if (read_ != newest && sequence >= newest->opened_at()) read_from(newest);
    const auto got = read();
    if (got || read_ == core()) return got;
    read_from(core());
  }
}

}  // namespace gecos::session
