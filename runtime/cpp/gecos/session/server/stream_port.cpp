#include "gecos/session/server/stream_port.hpp"

#include <algorithm>
#include <exception>

#include "gecos/base/log.hpp"
#include "gecos/session/protocol/open_message.hpp"

namespace gecos::session {
namespace {

constexpr std::size_t unbounded_sample = 64 * 1024;
constexpr std::size_t usual_depth = 16;

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
  const std::size_t largest = stream_.largest != 0 ? stream_.largest : unbounded_sample;
  const std::size_t depth = stream_.quality.depth != 0 ? stream_.quality.depth : usual_depth;
  try {
    auto made = acceptor.make_stream(largest + measured_bytes, depth);
    // The number of the newest sample is the same over all media. A session that moves to another
    // medium goes on reading after the number that it has read last.
    if (const std::uint64_t newest = newest_number(); newest != 0) {
      made->number_after(kept_ ? newest - 1 : newest);
    }
    if (kept_) static_cast<void>(made->publish(latest_, latest_stamp_ns_));
    return writers_.emplace(medium, std::move(made)).first->second.get();
  } catch (const std::exception& failed) {  // no memory or no descriptor is left
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
  latest_.assign(sample.begin(), sample.end());
  append_measured(latest_, time.measured);
  latest_stamp_ns_ = time.stamp_ns;
  kept_ = !stream_.event;
  ++samples_;
  bytes_ += sample.size();
  for (const auto& [medium, writer] : writers_) {
    if (!writer->publish(latest_, time.stamp_ns)) drop(sample.size(), medium);
  }
  if (!open_channels_.empty()) send_in_clear(sample);
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
  if (*opened) open_channels_.insert_or_assign(acceptor.capabilities().name, std::move(*opened));
}

/// Sends while the mutex is held, as the writers of the media do, so that the samples of several
/// publishing threads leave in the order of their numbers. The send is one UDP datagram (or its
/// fragments) without an answer: it waits only while the send buffer of the socket is full, until
/// the network card of this host has sent a part of it. No reader can make it wait.
void StreamPort::send_in_clear(ByteView sample) {
  write_open_message(open_message_, stream_.open_fingerprint.value_or(0), sample);
  for (const auto& [medium, channel] : open_channels_) {
    if (channel->publish(open_message_)) continue;
    if (!writers_.contains(medium)) drop(sample.size(), medium);  // else it is counted already
  }
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
  } catch (const std::exception& failed) {  // no memory or no descriptor is left
    log_error("session", named() +
                             " cannot be moved to memory that an excluded client cannot read: " +
                             failed.what() + "; the stream is closed over " + std::string(medium));
    writers_.erase(found);
  }
}

void StreamPort::close() {
  const MutexLock lock(mutex_);
  writers_.clear();
  open_channels_.clear();
}

}  // namespace gecos::session
