#include "gecos/media/shm/shared_streams.hpp"

#include <utility>

namespace gecos::media::shm {

tl::expected<void, SendProblem> SharedStreams::share(std::uint32_t id, SharedStreamWriter& writer,
                                                     const std::shared_ptr<PeerEnd>& reader,
                                                     ControlQueue& to) {
  if (!shared_.contains(id) && shared_.size() >= limits_.shared) {
    return tl::unexpected(SendProblem::Full);
  }
  ControlMessage message{.type = ControlType::Share, .id = id};
  message.largest = writer.memory().largest;
  message.depth = writer.memory().depth;
  auto [memory, moves] = writer.place()->now();
  if (!to.send({message, std::move(memory)})) return tl::unexpected(SendProblem::Full);
  const Shared before =
      std::exchange(shared_[id], {writer.sleepers(), writer.place(), message, moves});
  if (const auto list = before.sleepers.lock()) list->remove(reader.get());
  writer.sleepers()->add(reader);
  return {};
}

void SharedStreams::unshare(std::uint32_t id, PeerEnd& reader, ControlQueue& to) {
  const auto held = shared_.extract(id);
  if (held.empty()) return;
  if (const auto list = held.mapped().sleepers.lock()) list->remove(&reader);
  to.send({{.type = ControlType::Unshare, .id = id}, nullptr});
}

void SharedStreams::follow_moves(ControlQueue& to) {
  for (auto& [id, shared] : shared_) {
    const auto place = shared.place.lock();
    if (place == nullptr) continue;
    auto [memory, moves] = place->now();
    if (moves == shared.moves || !to.send({shared.announcement, std::move(memory)})) continue;
    shared.moves = moves;
  }
}

void SharedStreams::forget(PeerEnd& reader) {
  for (const auto& [id, shared] : shared_) {
    if (const auto list = shared.sleepers.lock()) list->remove(&reader);
  }
}

std::optional<std::string> SharedStreams::received(ReceivedControl& control) {
  const ControlMessage& message = control.message;
  constexpr std::size_t most = StreamMemory::most_bytes;
  const auto known = received_.find(message.id);
  const bool too_many = known == received_.end() && received_.size() >= limits_.received;
  if (too_many || message.depth == 0 || message.depth > most || message.largest > most ||
      message.depth + 1 > most / StreamMemory::slot_bytes(message.largest)) {
    return "the peer shared too many streams, or a stream of an invalid size";
  }
  if (known != received_.end() && known->second.is_read() &&
      (message.largest != known->second.memory.largest ||
       message.depth != known->second.memory.depth)) {
    return "the peer changed the size of a stream that is being read";
  }
  auto mapping = map_received(control.descriptors[0].get(),
                              StreamMemory::bytes(message.largest, message.depth));
  if (!mapping) {
    NotMapped& failed = mapping.error();
    if (failed.cause == NotMapped::Cause::NoRoom && not_received(message.id, failed.text)) {
      return std::nullopt;
    }
    return std::move(failed.text);
  }
  auto held = std::make_shared<Mapping>(std::move(*mapping));
  not_received_.erase(message.id);
  const StreamMemory memory{held->data(), message.largest, message.depth};
  std::vector<std::weak_ptr<StreamWatch>> readers;
  if (known != received_.end()) readers = std::move(known->second.readers);
  std::erase_if(readers, [&](const auto& one) {
    const auto watch = one.lock();
    if (watch != nullptr) watch->move_to(memory, held);
    return watch == nullptr;
  });
  received_[message.id] = {memory, std::move(held), std::move(readers)};
  return std::nullopt;
}

bool SharedStreams::not_received(std::uint32_t id, std::string why) {
  if (not_received_.size() >= limits_.received) return false;
  not_received_[id] = std::move(why);
  return true;
}

void SharedStreams::withdrawn(std::uint32_t id) {
  received_.erase(id);
  not_received_.erase(id);
}

std::unique_ptr<StreamReader> SharedStreams::open(std::uint32_t id, const StreamBounds& most,
                                                  StreamWatches& watches) {
  const auto found = received_.find(id);
  if (found == received_.end()) return nullptr;
  if (const std::size_t largest = found->second.memory.largest; largest > most.largest) {
    not_received(id, "its samples may have " + std::to_string(largest) + " bytes, and the reader " +
                         "accepts at most " + std::to_string(most.largest));
    return nullptr;
  }
  const auto watch = watches.watch(found->second.memory, found->second.mapping);
  auto& readers = found->second.readers;
  std::erase_if(readers, [](const auto& one) { return one.expired(); });
  readers.push_back(watch);
  return std::make_unique<StreamRingReader>(watch);
}

std::string SharedStreams::why_not_open(std::uint32_t id) const {
  const auto found = not_received_.find(id);
  return found == not_received_.end() ? std::string() : found->second;
}

}  // namespace gecos::media::shm
