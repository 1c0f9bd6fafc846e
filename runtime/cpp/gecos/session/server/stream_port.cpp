#include "gecos/session/server/stream_port.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/sample_bounds.hpp"

namespace gecos::session {
namespace {

constexpr const char* still_lent =
    "the memory of the next sample is lent already; publish that loan or end it first";

/// The memory in bytes that the samples of a stream may take if the interface does not declare its
/// `depth`.
constexpr std::size_t usual_memory = std::size_t{256} << 20;

std::size_t depth_of(const StreamDescription& stream) {
  if (stream.quality.depth != 0) return stream.quality.depth;
  return std::clamp<std::size_t>(usual_memory / (stream.largest + 1), 1, usual_depth);
}

std::size_t largest_of(const StreamDescription& stream) {
  return stream.largest != 0 ? stream.largest : unbounded_sample;
}

}  // namespace

std::string StreamPort::named() const {
  return "stream '" + std::string(stream_.name) + "' of " + object_;
}

tl::expected<std::uint64_t, std::string> StreamPort::share(std::uint32_t id,
                                                           media::Connection& connection,
                                                           media::Acceptor& acceptor) {
  const MutexLock lock(mutex_);
  const auto writer = writer_for(acceptor);
  if (!writer) return tl::unexpected(writer.error());
  if (!connection.share(id, **writer)) {
    return tl::unexpected(named() + " cannot be shared over " +
                          std::string(connection.capabilities().name) +
                          ": the connection is lost or has no room for another stream");
  }
  return (*writer)->newest();
}

tl::expected<media::StreamWriter*, std::string> StreamPort::writer_for(media::Acceptor& acceptor) {
  const std::string_view medium = acceptor.capabilities().name;
  if (const auto found = writers_.find(medium); found != writers_.end()) return found->second.get();
  const std::size_t largest = largest_of(stream_);
  try {
    auto made = acceptor.make_stream(largest + measured_bytes, depth_of(stream_));
    if (stream_.bulk && stream_.largest != 0 && made->largest() < largest + measured_bytes) {
      return tl::unexpected(named() + " has samples of up to " + std::to_string(largest) +
                            " bytes, and " + std::string(medium) + " carries at most " +
                            std::to_string(made->largest() - measured_bytes) +
                            "; read it on the host of its server, or reduce the bound of its "
                            "@bulk sequence");
    }
    // The number of the newest sample is the same over all media. A session that moves to another
    // medium continues after the number of the sample that it has read last.
    if (const std::uint64_t newest = newest_number(); newest != 0) {
      made->number_after(kept_ ? newest - 1 : newest);
    }
    if (kept_) static_cast<void>(made->publish(latest(), latest_stamp_ns_));
    return writers_.emplace(medium, std::move(made)).first->second.get();
  } catch (const std::exception& failed) {  // also if no memory or no descriptor is left
    return tl::unexpected(named() + " cannot be opened over " + std::string(medium) + ": " +
                          failed.what());
  }
}

std::uint64_t StreamPort::newest_number() const {
  std::uint64_t newest = 0;
  for (const auto& [medium, writer] : writers_) newest = std::max(newest, writer->newest());
  return newest;
}

void StreamPort::publish(ByteView sample, const SampleTime& time) {
  const MutexLock lock(mutex_);
  if (lent_.first != nullptr) {  // the lent memory is that of the next sample
    ++dropped_;
    if (std::exchange(complained_, true)) return;
    log_error("session", "a sample of the " + named() + " is not published: " + still_lent);
    return;
  }
  latest_.assign(sample.begin(), sample.end());
  append_measured(latest_, time.measured);
  latest_in_ = nullptr;
  latest_stamp_ns_ = time.stamp_ns;
  count(sample.size());
  distribute(nullptr);
}

void StreamPort::count(std::size_t size) {
  kept_ = !stream_.event;
  ++samples_;
  bytes_ += size;
}

ByteView StreamPort::latest() const {
  return latest_in_ != nullptr ? latest_in_->newest_sample() : ByteView(latest_);
}

void StreamPort::distribute(const media::StreamWriter* written) {
  const ByteView all = latest();
  const ByteView sample = all.first(all.size() - measured_bytes);
  for (const auto& [medium, writer] : writers_) {
    if (writer.get() == written) continue;
    if (!writer->publish(all, latest_stamp_ns_)) drop(sample.size(), medium);
  }
  clear_.send(sample, [&](std::string_view medium) {
    mutex_.assert_held();
    // If the medium has a writer, the loop above has counted the dropped sample.
    if (!writers_.contains(medium)) drop(sample.size(), medium);
  });
}

tl::expected<LentMemory, std::string> StreamPort::lend(std::size_t size) {
  const MutexLock lock(mutex_);
  if (closed_) return LentMemory{};
  if (lent_.first != nullptr) return tl::unexpected(std::string(still_lent));
  if (const std::size_t largest = largest_of(stream_); size > largest) {
    ++dropped_;
    return tl::unexpected(
        "the sample takes " + std::to_string(size) + " bytes, at most " + std::to_string(largest) +
        " fit; " +
        (stream_.largest == 0 ? "declare bounds for its sequences and strings" : "shorten it"));
  }
  // Most readers of large samples use shm, so shm comes before inproc.
  for (auto held = writers_.rbegin(); held != writers_.rend(); ++held) {
    media::StreamWriter& writer = *held->second;
    auto owner = writer.lent_owner();
    if (owner == nullptr) continue;
    const auto whole = writer.lend(size + measured_bytes);
    if (!whole) continue;
    lent_.first = whole->data();
    lent_.whole = *whole;
    lent_.writer = &writer;
    return LentMemory{whole->first(size), std::move(owner)};
  }
  // A program in another language may still hold the memory of an earlier loan. Such memory must
  // not be lent again.
  if (lent_.own.use_count() != 1) lent_.own = std::make_shared<Bytes>();
  // The last use of the memory by its borrower must be visible before the memory is reused.
  std::atomic_thread_fence(std::memory_order_acquire);
  lent_.own->resize(size + measured_bytes);
  lent_.first = lent_.own->data();
  lent_.whole = *lent_.own;
  return LentMemory{lent_.whole.first(size), lent_.own};
}

void StreamPort::end_loan() {
  lent_.first = nullptr;
  lent_.whole = {};
  lent_.writer = nullptr;
}

bool StreamPort::publish_lent(const LentMemory& memory, const SampleTime& time) {
  const MutexLock lock(mutex_);
  if (lent_.first == nullptr || lent_.first != memory.bytes.data()) return false;
  write_measured(lent_.whole.last<measured_bytes>(), time.measured);
  latest_in_ = lent_.writer;
  latest_stamp_ns_ = time.stamp_ns;
  if (latest_in_ != nullptr) {
    latest_in_->publish_lent(time.stamp_ns);
  } else {
    latest_.assign(lent_.whole.begin(), lent_.whole.end());
  }
  end_loan();
  count(memory.bytes.size());
  distribute(latest_in_);
  return true;
}

void StreamPort::give_back(const LentMemory& memory) {
  const MutexLock lock(mutex_);
  if (lent_.first == memory.bytes.data()) end_loan();
}

/// Must be called when the writer `ended` is about to be destroyed.
void StreamPort::forget(const media::StreamWriter* ended) {
  if (lent_.writer == ended) end_loan();
  if (latest_in_ == ended) {
    latest_in_ = nullptr;
    kept_ = false;
  }
}

void StreamPort::publish_in_clear(media::Acceptor& acceptor) {
  if (!stream_.open_fingerprint) return;
  const std::string channel = object_ + "." + std::string(stream_.name);
  auto opened = acceptor.open_channel(channel);
  if (!opened) {
    log_warning("session", named() + " is not published in clear over " +
                               std::string(acceptor.capabilities().name) + ": " +
                               opened.error().text);
    return;
  }
  const MutexLock lock(mutex_);
  if (*opened) clear_.add(acceptor.capabilities().name, std::move(*opened));
}

bool StreamPort::allow_in_clear(bool allowed) {
  if (!stream_.open_fingerprint) return false;
  const MutexLock lock(mutex_);
  return clear_.allow(allowed);
}

void StreamPort::drop(std::size_t size, std::string_view medium) {
  ++dropped_;
  if (complained_) return;
  complained_ = !stream_.event;
  log_error("session", object_ + ": a sample of '" + std::string(stream_.name) + "' takes " +
                           std::to_string(size) + " bytes, more than " + std::string(medium) +
                           " can send for this stream; the sample is dropped");
}

StreamStats StreamPort::stats() {
  const MutexLock lock(mutex_);
  return {std::string(stream_.name), samples_, bytes_, dropped_, 0};
}

void StreamPort::move_on(std::string_view medium) {
  const MutexLock lock(mutex_);
  const auto found = writers_.find(medium);
  if (found == writers_.end()) return;
  try {
    found->second->move_on();
  } catch (const std::exception& failed) {  // also if no memory or no descriptor is left
    log_error("session", named() + " is closed over " + std::string(medium) +
                             ": a client was excluded, and the stream cannot be moved to memory "
                             "that this client cannot read: " +
                             failed.what());
    forget(found->second.get());
    writers_.erase(found);
  }
}

void StreamPort::close() {
  const MutexLock lock(mutex_);
  closed_ = true;
  end_loan();
  latest_in_ = nullptr;
  kept_ = false;
  writers_.clear();
  clear_.end();
}

}  // namespace gecos::session
