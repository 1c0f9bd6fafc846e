#pragma once

#include <array>
#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "gecos/media/descriptor.hpp"
#include "gecos/media/forked.hpp"
#include "gecos/media/lcm/inbox.hpp"
#include "gecos/media/lcm/port.hpp"
#include "gecos/media/lcm/stream.hpp"

namespace gecos::media {

const Offer& lcm_offer();

/// What both ends have in common: sending, and reading what the inbox holds.
class LcmLink : public Link {
 public:
  const Offer& offer() const override { return lcm_offer(); }
  const Peer& peer() const override { return peer_; }
  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override;
  std::optional<ByteView> receive() override;
  std::optional<std::uint64_t> taken_by_peer() override { return std::nullopt; }
  void beat() override;
  std::uint64_t beats_seen() override;
  Loss loss() override;
  std::string loss_text() const override;

 protected:
  LcmLink(std::shared_ptr<LcmInbox> inbox, std::unique_ptr<LcmPort> out, std::string out_channel,
          std::uint64_t client, std::uint16_t reply_port, Peer peer);

  /// Takes what has arrived, into the inbox and from there what is no packet.
  virtual void pump() = 0;
  /// Which server a datagram of ours is for, or from.
  virtual std::uint64_t server() const = 0;
  void say(DatagramKind kind, std::uint64_t number = 0, ByteView body = {});
  bool inherited() const { return inherited_.load(std::memory_order_relaxed); }

  const std::shared_ptr<LcmInbox> inbox_;

 private:
  const std::unique_ptr<LcmPort> out_;
  const std::string out_channel_;
  const std::uint64_t client_;
  const std::uint16_t reply_port_;
  const Peer peer_;
  std::uint64_t sent_ = 0;
  Bytes outgoing_;
  Bytes current_;
  std::atomic<bool> inherited_{false};  // this is a forked child
  const ForkWatch fork_watch_;
};

class LcmClientLink final : public LcmLink {
 public:
  static tl::expected<std::unique_ptr<Link>, MediumError> connect(const LcmOptions& options,
                                                                  const LcmAddress& address);
  ~LcmClientLink() override;

  bool arm() override;
  void disarm() override;
  std::span<const int> descriptors() const override { return descriptors_; }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override;
  void unshare(std::uint32_t id) override;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id) override;

  LcmClientLink(const LcmOptions& options, std::shared_ptr<LcmInbox> inbox,
                std::unique_ptr<LcmPort> in, std::unique_ptr<LcmPort> out,
                const LcmAddress& address, std::uint64_t client, std::uint16_t reply_port);

 private:
  struct Arrived {
    SharedStream where;
    bool opened = false;
  };
  void pump() override;
  std::uint64_t server() const override { return inbox_->server(); }
  bool new_samples();

  const LcmOptions options_;
  const std::unique_ptr<LcmPort> in_;
  const Descriptor streams_;  // an epoll of the ports of streams, which come later
  const std::array<int, 3> descriptors_;
  /// Since somebody looked for a stream one was told of, maybe by a look for something else: whoever
  /// is about to sleep looks once more. Publishes nothing but itself.
  std::atomic<bool> heard_of_streams_{false};
  std::mutex mutex_;          // guards what follows
  std::map<std::uint32_t, Arrived> arrived_;
  std::vector<std::weak_ptr<LcmStreamInbox>> reading_;
};

/// What the acceptor of an object and its links share: the port where all clients' packets come in.
class LcmDoor {
 public:
  struct Guest {
    std::uint64_t client = 0;
    std::uint16_t reply_port = 0;
    std::shared_ptr<LcmInbox> inbox;
  };
  LcmDoor(LcmOptions options, std::unique_ptr<LcmPort> in, LcmAddress address);

  tl::expected<void, MediumError> open();
  /// Puts what has arrived into the inboxes of links and guests. True: there may be more.
  bool pump() { return in_->pump(); }
  bool next_guest(Guest& into);
  void forget(std::uint64_t client);

  int descriptor() const { return in_->descriptor(); }
  const LcmOptions& options() const { return options_; }
  const LcmAddress& address() const { return address_; }
  std::uint64_t server() const { return server_; }
  void close() { closed_.store(true); }

 private:
  void take(ByteView datagram);

  const LcmOptions options_;
  const std::unique_ptr<LcmPort> in_;
  const LcmAddress address_;
  const std::uint64_t server_ = draw_number();
  std::atomic<bool> closed_{false};  // the acceptor has gone: nobody comes in any more
  std::mutex mutex_;                 // guards what follows
  std::map<std::uint64_t, std::shared_ptr<LcmInbox>> inboxes_;
  std::deque<Guest> guests_;
  std::deque<std::uint64_t> gone_;   // whose late datagrams make no new link
};

class LcmServerLink final : public LcmLink {
 public:
  static tl::expected<std::unique_ptr<Link>, MediumError> welcome(std::shared_ptr<LcmDoor> door,
                                                                  const LcmDoor::Guest& guest);
  ~LcmServerLink() override;

  bool arm() override;
  void disarm() override;
  std::span<const int> descriptors() const override { return descriptors_; }
  void beat() override;
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override;
  void unshare(std::uint32_t id) override;
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id) override;

  LcmServerLink(std::shared_ptr<LcmDoor> door, const LcmDoor::Guest& guest,
                std::unique_ptr<LcmPort> out);

 private:
  struct Shared {
    std::weak_ptr<LcmStream> stream;
    bool opened = false;  // until then it is told again with every beat
  };
  void pump() override;
  std::uint64_t server() const override { return door_->server(); }
  void tell(std::uint32_t id, const LcmStream& stream);

  const std::shared_ptr<LcmDoor> door_;
  const std::uint64_t client_;
  const std::array<int, 1> descriptors_;
  std::mutex mutex_;  // guards what follows
  std::map<std::uint32_t, Shared> shared_;
};

}  // namespace gecos::media
