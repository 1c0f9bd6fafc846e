#include "gecos/session/server/object_streams.hpp"

#include <algorithm>
#include <exception>

#include "gecos/base/log.hpp"

namespace gecos::session {
namespace {

constexpr std::size_t unbounded_sample = 64 * 1024;
constexpr std::size_t usual_depth = 16;

}  // namespace

ObjectStreams::ObjectStreams(std::string object, const InterfaceDescription& interface)
    : object_(std::move(object)), streams_(interface.all_streams()), outlets_(streams_.size()) {}

void ObjectStreams::offer(std::shared_ptr<media::Acceptor> acceptor) {
  const MutexLock lock(mutex_);
  const media::Kind kind = acceptor->offer().kind;
  acceptors_[kind] = std::move(acceptor);
}

void ObjectStreams::close() {
  const MutexLock lock(mutex_);
  for (Outlet& outlet : outlets_) outlet.writers.clear();
  acceptors_.clear();
}

tl::expected<std::uint32_t, std::string> ObjectStreams::share(const StreamDescription& stream,
                                                              media::Link& link) {
  const MutexLock lock(mutex_);
  const auto place = std::ranges::lower_bound(streams_, stream.code, {}, &StreamDescription::code);
  const auto index = static_cast<std::size_t>(place - streams_.begin());
  Outlet& outlet = outlets_.at(index);
  auto& writers = outlet.writers;
  auto found = writers.find(link.offer().kind);
  if (found == writers.end()) {
    const std::size_t largest = stream.largest != 0 ? stream.largest : unbounded_sample;
    const std::size_t depth = stream.quality.depth != 0 ? stream.quality.depth : usual_depth;
    try {
      found =
          writers
              .emplace(
                  link.offer().kind,
                  acceptors_.at(link.offer().kind)->make_stream(largest + measured_bytes, depth))
              .first;
    } catch (const std::exception& failed) {  // no memory or no descriptor is left
      return tl::unexpected(
          "stream '" + std::string(stream.name) + "' of " + object_ + " cannot be opened over " +
          std::string(media::to_string(link.offer().kind)) + ": " + failed.what());
    }
    if (outlet.published) {
      static_cast<void>(found->second->publish(outlet.latest, outlet.latest_stamp_ns));
    }
  }
  const auto id = static_cast<std::uint32_t>(index + 1);
  if (!link.share(id, *found->second)) {
    return tl::unexpected("stream '" + std::string(stream.name) + "' of " + object_ +
                          " cannot be shared over " +
                          std::string(media::to_string(link.offer().kind)) +
                          ": the link is lost or has no room for another stream");
  }
  return id;
}

void ObjectStreams::publish(const StreamDescription& stream, ByteView sample,
                            const SampleTime& time) {
  const MutexLock lock(mutex_);
  const auto place = std::ranges::lower_bound(streams_, stream.code, {}, &StreamDescription::code);
  if (place == streams_.end() || (*place)->code != stream.code) return;
  Outlet& outlet = outlets_[static_cast<std::size_t>(place - streams_.begin())];
  outlet.latest.assign(sample.begin(), sample.end());
  append_measured(outlet.latest, time.measured);
  outlet.latest_stamp_ns = time.stamp_ns;
  outlet.published = true;
  for (const auto& [kind, writer] : outlet.writers) {
    if (writer->publish(outlet.latest, time.stamp_ns) || outlet.complained) continue;
    outlet.complained = true;
    log_error("session", object_ + ": a sample of '" + std::string(stream.name) + "' takes " +
                             std::to_string(sample.size()) + " bytes, more than " +
                             std::string(media::to_string(kind)) +
                             " carries for this stream; it is dropped");
  }
}

}  // namespace gecos::session
