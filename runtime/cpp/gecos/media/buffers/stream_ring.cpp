#include "gecos/media/buffers/stream_ring.hpp"

#include <algorithm>
#include <cassert>
#include <cstring>
#include <utility>

namespace gecos::media {
namespace {

using Word = std::atomic<std::uint64_t>;
static_assert(sizeof(Word) == 8 && Word::is_always_lock_free);

// A slot consists of a version, a time stamp, a size, and the sample in whole words. The version is
// 2 * sequence, or 2 * sequence - 1 while the writer writes the sample. All of them are atomic
// words, which are stored with release and loaded with acquire. So a reader that has loaded any
// word of a newer sample also sees the changed version when it checks the version again. On x86
// this costs nothing.
constexpr std::size_t sample_at = 3;
constexpr int most_tries = 8;

void write_words(Word* to, ByteView from) {
  const std::size_t whole = from.size() / 8;
  for (std::size_t i = 0; i < whole; ++i) {
    std::uint64_t word = 0;
    std::memcpy(&word, from.data() + 8 * i, 8);
    to[i].store(word, std::memory_order_release);
  }
  if (const std::size_t rest = from.size() % 8; rest != 0) {
    std::uint64_t word = 0;
    std::memcpy(&word, from.data() + 8 * whole, rest);
    to[whole].store(word, std::memory_order_release);
  }
}

void read_words(const Word* from, Bytes& into) {
  const std::size_t whole = into.size() / 8;
  for (std::size_t i = 0; i < whole; ++i) {
    const std::uint64_t word = from[i].load(std::memory_order_acquire);
    std::memcpy(into.data() + 8 * i, &word, 8);
  }
  if (const std::size_t rest = into.size() % 8; rest != 0) {
    const std::uint64_t word = from[whole].load(std::memory_order_acquire);
    std::memcpy(into.data() + 8 * whole, &word, rest);
  }
}

bool read_sample(const StreamMemory& memory, std::uint64_t sequence, StreamSample& into) {
  const Word* const slot = memory.slot(sequence);
  const std::uint64_t complete = 2 * sequence;
  if (slot[0].load(std::memory_order_acquire) != complete) return false;
  const auto stamp = static_cast<std::int64_t>(slot[1].load(std::memory_order_acquire));
  const std::uint64_t size = slot[2].load(std::memory_order_acquire);
  if (size > memory.largest) return false;  // a torn read, or a malicious peer
  into.bytes.resize(size);
  read_words(slot + sample_at, into.bytes);
  if (slot[0].load(std::memory_order_acquire) != complete) return false;
  into.sequence = sequence;
  into.stamp_ns = stamp;
  return true;
}

/// Returns the number of the oldest sample that is stored when `newest` is the newest one.
std::uint64_t oldest_of(const StreamMemory& memory, std::uint64_t newest) {
  return newest > memory.depth ? newest - memory.depth + 1 : 1;
}

}  // namespace

std::atomic<std::uint64_t>& StreamMemory::newest() const { return *reinterpret_cast<Word*>(base); }

std::atomic<std::uint64_t>* StreamMemory::slot(std::uint64_t sequence) const {
  return reinterpret_cast<Word*>(base + 64 + sequence % (depth + 1) * slot_bytes(largest));
}

void SleeperList::add(std::weak_ptr<Sleeper> sleeper) {
  const MutexLock lock(mutex_);
  sleepers_.push_back(std::move(sleeper));
  publish_change();
}

void SleeperList::remove(const Sleeper* sleeper) {
  const MutexLock lock(mutex_);
  std::erase_if(sleepers_, [&](const auto& held) { return held.lock().get() == sleeper; });
  publish_change();
}

void SleeperList::publish_change() {
  std::erase_if(sleepers_, [](const auto& held) { return held.expired(); });
  next_ = sleepers_;
  changed_.store(true);
}

void SleeperList::wake() {
  if (changed_.load()) {
    const MutexLock lock(mutex_);
    changed_.store(false);
    woken_.swap(next_);
  }
  for (const auto& held : woken_) {
    if (const auto alive = held.lock()) alive->wake_if_asleep();
  }
}

StreamRingWriter::StreamRingWriter(StreamMemory memory, std::shared_ptr<void> owner)
    : memory_(memory), owner_(std::move(owner)) {}

void StreamRingWriter::move_to(StreamMemory memory, std::shared_ptr<void> owner) {
  // No lock is needed here: only the borrower of a lent slot may write to the old memory meanwhile,
  // and nobody reads the new memory yet. The lent slot keeps its version 0 in the new memory, so
  // that it counts as empty.
  for (std::uint64_t sequence = oldest_of(memory_, newest_); sequence <= newest_; ++sequence) {
    const Word* const from = memory_.slot(sequence);
    const std::uint64_t size = from[2].load(std::memory_order_relaxed);
    std::memcpy(static_cast<void*>(memory.slot(sequence)), from, 8 * sample_at + size);
  }
  memory.newest().store(memory_.newest().load(std::memory_order_relaxed),
                        std::memory_order_relaxed);
  if (!lent_.empty() && lent_owner_ == nullptr) lent_owner_ = owner_;
  memory_ = memory;
  owner_ = std::move(owner);
}

tl::expected<void, SendProblem> StreamRingWriter::publish(ByteView sample, std::int64_t stamp_ns) {
  if (sample.size() > memory_.largest) return tl::unexpected(SendProblem::TooLarge);
  take_lent_back();
  const std::uint64_t sequence = ++newest_;
  Word* const slot = memory_.slot(sequence);
  slot[0].store(2 * sequence - 1,
                std::memory_order_relaxed);  // ordered by the release stores below
  slot[1].store(static_cast<std::uint64_t>(stamp_ns), std::memory_order_release);
  slot[2].store(sample.size(), std::memory_order_release);
  write_words(slot + sample_at, sample);
  complete(sequence);
  return {};
}

void StreamRingWriter::complete(std::uint64_t sequence) {
  memory_.slot(sequence)[0].store(2 * sequence, std::memory_order_release);
  memory_.newest().store(sequence, std::memory_order_seq_cst);  // publishes the sample to readers
  sleepers_->wake();
}

tl::expected<std::span<std::byte>, SendProblem> StreamRingWriter::lend(std::size_t size) {
  if (size > memory_.largest) return tl::unexpected(SendProblem::TooLarge);
  const std::uint64_t sequence = newest_ + 1;
  Word* const slot = memory_.slot(sequence);
  slot[0].store(2 * sequence - 1, std::memory_order_relaxed);
  // The fence ensures that a reader of this slot's previous sample sees the new version before it
  // sees any byte that the caller writes into the lent memory.
  std::atomic_thread_fence(std::memory_order_release);
  take_lent_back();
  lent_ = std::span(reinterpret_cast<std::byte*>(slot + sample_at), size);
  return lent_;
}

void StreamRingWriter::publish_lent(std::int64_t stamp_ns) {
  if (lent_owner_ != nullptr) {  // the stream has moved to other memory since lend()
    const std::shared_ptr<void> left = lent_owner_;
    const std::span<std::byte> written = lent_;
    std::memcpy(lend(written.size())->data(), written.data(), written.size());
  }
  const std::uint64_t sequence = ++newest_;
  Word* const slot = memory_.slot(sequence);
  slot[1].store(static_cast<std::uint64_t>(stamp_ns), std::memory_order_release);
  slot[2].store(lent_.size(), std::memory_order_release);
  take_lent_back();
  complete(sequence);
}

void StreamRingWriter::take_lent_back() {
  lent_ = {};
  lent_owner_ = nullptr;
}

ByteView StreamRingWriter::newest_sample() const {
  const Word* const slot = memory_.slot(newest_);
  return {reinterpret_cast<const std::byte*>(slot + sample_at),
          slot[2].load(std::memory_order_relaxed)};
}

StreamWatch::StreamWatch(StreamMemory memory, std::shared_ptr<void> owner)
    : past([&] {
        const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
        return newest == 0 ? 0 : newest - 1;
      }()),
      place_(std::make_shared<const Place>(Place{memory, std::move(owner)})) {}

void StreamWatch::move_to(StreamMemory memory, std::shared_ptr<void> owner) {
  auto place = std::make_shared<const Place>(Place{memory, std::move(owner)});
  const MutexLock lock(mutex_);
  place_.swap(place);
  moved_.store(true, std::memory_order_release);
}

std::shared_ptr<const StreamWatch::Place> StreamWatch::place() {
  const MutexLock lock(mutex_);
  moved_.store(false, std::memory_order_relaxed);
  return place_;
}

std::uint64_t StreamWatch::newest() {
  const MutexLock lock(mutex_);
  return place_->memory.newest().load(std::memory_order_seq_cst);
}

/// Returns the memory to which the writer writes now. Until the next call, the reader keeps this
/// memory alive, so that the bytes of a lent sample stay readable.
const StreamMemory& StreamRingReader::memory_now() {
  if (watch_->moved()) place_ = watch_->place();
  return place_->memory;
}

bool StreamRingReader::latest(std::uint64_t after, StreamSample& into) {
  const StreamMemory& memory = memory_now();
  for (int tries = 0; tries < most_tries; ++tries) {
    const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
    watch_->seen.store(newest, std::memory_order_relaxed);
    if (newest <= after) return false;
    if (read_sample(memory, newest, into)) return true;
  }
  return false;
}

bool StreamRingReader::next(std::uint64_t after, StreamSample& into) {
  if (after == 0) after = watch_->past;
  const StreamMemory& memory = memory_now();
  for (int tries = 0; tries < most_tries; ++tries) {
    const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
    watch_->seen.store(newest, std::memory_order_relaxed);
    if (newest <= after) return false;
    if (read_sample(memory, std::max(after + 1, oldest_of(memory, newest)), into)) return true;
  }
  return latest(after,
                into);  // the writer is too fast: it overwrites the newest sample last
}

std::optional<LentSample> StreamRingReader::lend(std::uint64_t sequence) const {
  const Word* const slot = place_->memory.slot(sequence);
  LentSample sample{.sequence = sequence, .version = slot};
  sample.stamp_ns = static_cast<std::int64_t>(slot[1].load(std::memory_order_acquire));
  const std::uint64_t size = slot[2].load(std::memory_order_acquire);
  // A size that is too large comes from a torn read, or from a malicious peer.
  if (size > place_->memory.largest || !sample.intact()) return std::nullopt;
  sample.bytes = ByteView(reinterpret_cast<const std::byte*>(slot + sample_at), size);
  sample.owner = place_;
  return sample;
}

std::optional<LentSample> StreamRingReader::lend_latest(std::uint64_t after) {
  const StreamMemory& memory = memory_now();
  for (int tries = 0; tries < most_tries; ++tries) {
    const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
    watch_->seen.store(newest, std::memory_order_relaxed);
    if (newest <= after) return std::nullopt;
    if (auto sample = lend(newest)) return sample;
  }
  return std::nullopt;
}

std::optional<LentSample> StreamRingReader::lend_next(std::uint64_t after) {
  if (after == 0) after = watch_->past;
  const StreamMemory& memory = memory_now();
  for (int tries = 0; tries < most_tries; ++tries) {
    const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
    watch_->seen.store(newest, std::memory_order_relaxed);
    if (newest <= after) return std::nullopt;
    if (auto sample = lend(std::max(after + 1, oldest_of(memory, newest)))) return sample;
  }
  return lend_latest(after);  // the writer is too fast: it overwrites the newest sample last
}

std::vector<StreamSample> StreamRingReader::stored() {
  const StreamMemory& memory = memory_now();
  const std::uint64_t newest = memory.newest().load(std::memory_order_acquire);
  std::vector<StreamSample> samples;
  // `newest` may have any value if the peer is malicious, so the loop counts up to the depth.
  for (std::uint64_t left = std::min<std::uint64_t>(newest, memory.depth); left > 0; --left) {
    StreamSample sample;
    if (read_sample(memory, newest - left + 1, sample)) samples.push_back(std::move(sample));
  }
  return samples;
}

std::unique_ptr<StreamReader> StreamWatches::open(StreamMemory memory,
                                                  std::shared_ptr<void> owner) {
  return std::make_unique<StreamRingReader>(watch(memory, std::move(owner)));
}

std::shared_ptr<StreamWatch> StreamWatches::watch(StreamMemory memory,
                                                  std::shared_ptr<void> owner) {
  auto watch = std::make_shared<StreamWatch>(memory, std::move(owner));
  const MutexLock lock(mutex_);
  watches_.push_back(watch);
  any_.store(true, std::memory_order_relaxed);
  return watch;
}

bool StreamWatches::anything_new() {
  if (!any_.load(std::memory_order_relaxed)) return false;
  bool found = false;
  const MutexLock lock(mutex_);
  std::erase_if(watches_, [&](const auto& held) {
    const auto watch = held.lock();
    if (watch == nullptr) return true;
    const std::uint64_t newest = watch->newest();
    found = watch->seen.exchange(newest, std::memory_order_relaxed) != newest || found;
    return false;
  });
  any_.store(!watches_.empty(), std::memory_order_relaxed);
  return found;
}

}  // namespace gecos::media
