#include "gecos/session/server/object_streams.hpp"

#include <algorithm>

namespace gecos::session {

ObjectStreams::ObjectStreams(std::string object, const InterfaceDescription& interface)
    : object_(std::move(object)) {
  for (const StreamDescription* stream : interface.all_streams()) {
    ports_.push_back(std::make_unique<StreamPort>(object_, *stream));
  }
}

void ObjectStreams::offer(std::shared_ptr<media::Acceptor> acceptor) {
  for (const auto& port : ports_) port->publish_in_clear(*acceptor);
  const MutexLock lock(mutex_);
  const std::string_view name = acceptor->capabilities().name;
  acceptors_[name] = std::move(acceptor);
}

bool ObjectStreams::allow_in_clear(bool allowed) {
  bool changed = false;
  for (const auto& port : ports_) changed |= port->allow_in_clear(allowed);
  return changed;
}

void ObjectStreams::close() {
  for (const auto& port : ports_) port->close();
  const MutexLock lock(mutex_);
  acceptors_.clear();
}

std::size_t ObjectStreams::index_of(const StreamDescription& stream) const {
  const auto code = [](const auto& port) { return port->stream().code; };
  const auto place = std::ranges::lower_bound(ports_, stream.code, {}, code);
  const bool known = place != ports_.end() && code(*place) == stream.code;
  return known ? static_cast<std::size_t>(place - ports_.begin()) : ports_.size();
}

tl::expected<Subscription, std::string> ObjectStreams::share(const StreamDescription& stream,
                                                             media::Connection& connection) {
  std::shared_ptr<media::Acceptor> acceptor;
  {
    const MutexLock lock(mutex_);
    const auto found = acceptors_.find(connection.capabilities().name);
    if (found == acceptors_.end()) return tl::unexpected(object_ + " is no longer served");
    acceptor = found->second;
  }
  const std::size_t index = index_of(stream);
  const auto id = static_cast<std::uint32_t>(index + 1);
  return ports_.at(index)->share(id, connection, *acceptor).map([&](std::uint64_t newest) {
    return Subscription{id, newest};
  });
}

void ObjectStreams::exclude(media::Connection& connection) {
  for (std::size_t index = 0; index < ports_.size(); ++index) {
    connection.unshare(static_cast<std::uint32_t>(index + 1));
    ports_[index]->move_on(connection.capabilities().name);
  }
}

std::vector<StreamStats> ObjectStreams::stats() const {
  std::vector<StreamStats> all;
  for (const auto& port : ports_) all.push_back(port->stats());
  return all;
}

void ObjectStreams::publish(const StreamDescription& stream, ByteView sample,
                            const SampleTime& time) {
  if (const std::size_t index = index_of(stream); index < ports_.size()) {
    ports_[index]->publish(sample, time);
  }
}

tl::expected<LentMemory, std::string> ObjectStreams::lend(const StreamDescription& stream,
                                                          std::size_t size) {
  const std::size_t index = index_of(stream);
  if (index == ports_.size()) {
    return tl::unexpected(object_ + " has no stream '" + std::string(stream.name) + "'");
  }
  return ports_[index]->lend(size);
}

bool ObjectStreams::publish_lent(const StreamDescription& stream, const LentMemory& memory,
                                 const SampleTime& time) {
  const std::size_t index = index_of(stream);
  return index < ports_.size() && ports_[index]->publish_lent(memory, time);
}

void ObjectStreams::give_back(const StreamDescription& stream, const LentMemory& memory) {
  if (const std::size_t index = index_of(stream); index < ports_.size()) {
    ports_[index]->give_back(memory);
  }
}

}  // namespace gecos::session
