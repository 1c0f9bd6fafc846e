#include "gecos/media/sealed/initiator.hpp"

#include <unistd.h>

#include <algorithm>
#include <utility>

#include "gecos/base/user_and_host.hpp"

namespace gecos::media {
namespace {

using namespace std::chrono_literals;

/// Returns the time until the next repetition of a message: 20, 40, 80, and then always 160 ms.
Duration repeated_after(int said) { return 20ms * (1 << std::min(said - 1, 3)); }

}  // namespace

HandshakeInitiator::HandshakeInitiator(std::shared_ptr<const SealedKeys> keys,
                                       const SealedOptions& options, SealedAddress address,
                                       std::shared_ptr<SealedSender> sender,
                                       std::shared_ptr<ReceiveQueue> queue)
    : keys_(std::move(keys)),
      options_(options),
      address_(std::move(address)),
      sender_(std::move(sender)),
      queue_(std::move(queue)) {
  begin(options_.now());
}

void HandshakeInitiator::begin(TimePoint now) {
  began_ = next_ = now;
  said_ = 0;
  handshake_.reset();
  if (address_.key) begin_with(*address_.key);
}

void HandshakeInitiator::begin_with(const crypto::PublicKey& key) {
  const auto header = sender_->header(DatagramKind::First);
  auto begun = crypto::HandshakeInitiator::begin(keys_->own, key,
                                                 handshake_context(address_, header), ByteView{});
  if (begun) handshake_.emplace(std::move(*begun));  // fails for a key that no honest program has
}

void HandshakeInitiator::advance() {
  if (over_.load(std::memory_order_relaxed)) return;
  const TimePoint now = options_.now();
  const MutexLock lock(mutex_);
  if (open_ && queue_->heard()) {
    over_.store(true, std::memory_order_relaxed);
    return;
  }
  if (!open_ && now - began_ >= begins_anew_after) begin(now);
  if (now >= next_) speak(now);
}

void HandshakeInitiator::speak(TimePoint now) {
  if (open_) {
    Bytes memory;
    sender_->send({InnerKind::Beat, 0, options_.now_ns()}, {}, {}, memory);
  } else if (handshake_) {
    sender_->send_bare(DatagramKind::First, handshake_->first());
  } else if (!address_.key) {
    sender_->send_bare(DatagramKind::Ask, {});
  }
  next_ = now + repeated_after(++said_);
}

void HandshakeInitiator::take(const DatagramHeader& header, ByteView frame) {
  if (over_.load(std::memory_order_relaxed)) return;
  const TimePoint now = options_.now();
  const MutexLock lock(mutex_);
  if (open_) return;
  if (header.kind == DatagramKind::Key) take_key(frame, now);
  if (header.kind == DatagramKind::Second) take_second(frame, now);
}

void HandshakeInitiator::take_key(ByteView frame, TimePoint now) {
  if (address_.key || handshake_ || frame.size() != crypto::key_bytes) return;
  const auto key = crypto::PublicKey::of(frame);
  if (not_admitted_ && key == not_admitted_->key) return;
  if (auto admitted = keys_->directory.admission(key); !admitted) {
    not_admitted_ = {key, std::move(admitted.error().text)};  // another server may still answer
    return;
  }
  begin_with(key);
  said_ = 0;
  if (handshake_) speak(now);
}

void HandshakeInitiator::take_second(ByteView frame, TimePoint now) {
  if (!handshake_) return;
  auto finished = handshake_->finish(frame, now, options_.rekey);
  if (!finished) return;
  queue_->open(finished->channel.in);
  sender_->open(std::move(finished->channel.out));
  handshake_.reset();
  open_ = true;
  said_ = 0;
  speak(now);  // the server accepts a client only after a sealed packet from that client
}

std::string HandshakeInitiator::trouble() const {
  {
    const MutexLock lock(mutex_);
    if (open_) return queue_->heard() ? "" : "the server accepted us, but has sent no packet since";
    if (!handshake_ && not_admitted_)
      return "this program does not admit the key of the server that answered: " +
             not_admitted_->why;
  }
  return "no server answers, or the server does not admit our key " +
         keys_->own.public_key().short_name() + "; if the key is the problem, give a copy of " +
         keys_->directory.path() + "/" + keys_->own.public_key().to_string() +
         ".public to the user who runs the server; that user runs `gecos keys add FILE " +
         user_name(::geteuid()) + "@" + host_name() + "` with the copy" +
         options_.network->advice();
}

}  // namespace gecos::media
