#pragma once

#include <functional>
#include <memory>

#include "gecos/media/medium.hpp"

namespace gecos::media {

/// The base class of layers: a connection that uses an inner connection. Functions that a layer
/// does not override call the inner connection.
class ConnectionLayer : public Connection {
 public:
  ConnectionLayer(std::unique_ptr<Connection> inner, const Capabilities& capabilities)
      : inner_(std::move(inner)), capabilities_(capabilities) {}

  const Capabilities& capabilities() const override { return capabilities_; }
  const Peer& peer() const override { return inner_->peer(); }
  tl::expected<std::uint64_t, SendProblem> send(ByteView head, ByteView body) override {
    return inner_->send(head, body);
  }
  std::optional<ByteView> receive() override { return inner_->receive(); }
  Duration age() override { return inner_->age(); }
  std::optional<Duration> clock_difference() override { return inner_->clock_difference(); }
  std::optional<std::uint64_t> taken_by_peer() override { return inner_->taken_by_peer(); }
  bool prepare_to_sleep() override { return inner_->prepare_to_sleep(); }
  void woke() override { inner_->woke(); }
  std::span<const int> descriptors() const override { return inner_->descriptors(); }
  void write_word(std::size_t index, std::uint64_t value) override {
    inner_->write_word(index, value);
  }
  std::uint64_t peer_word(std::size_t index) override { return inner_->peer_word(index); }
  Whereabouts peer_whereabouts() override { return inner_->peer_whereabouts(); }
  void beat() override { inner_->beat(); }
  std::uint64_t beats_seen() override { return inner_->beats_seen(); }
  std::uint64_t beats_read() override { return inner_->beats_read(); }
  Loss loss() override { return inner_->loss(); }
  std::string loss_text() const override { return inner_->loss_text(); }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override {
    return inner_->make_stream(largest, depth);
  }
  tl::expected<void, SendProblem> share(std::uint32_t id, StreamWriter& stream) override {
    return inner_->share(id, stream);
  }
  void unshare(std::uint32_t id) override { inner_->unshare(id); }
  std::unique_ptr<StreamReader> open_stream(std::uint32_t id, const StreamBounds& most) override {
    return inner_->open_stream(id, most);
  }
  std::function<std::string()> later_refusal() override { return inner_->later_refusal(); }
  std::string why_no_stream(std::uint32_t id) override { return inner_->why_no_stream(id); }

 protected:
  Connection& inner() const { return *inner_; }

 private:
  const std::unique_ptr<Connection> inner_;
  const Capabilities capabilities_;
};

enum class Role : std::uint8_t { Client, Server };

/// A function that wraps a connection of the given role in a layer. The connection that it returns
/// must have the given Capabilities. Any thread may call the function.
using PutLayer = std::function<std::unique_ptr<Connection>(std::unique_ptr<Connection>,
                                                           const Capabilities&, Role)>;

/// Makes a medium that calls `put` to wrap every connection of `inner`. A stream that an acceptor
/// of the new medium makes is a stream of `inner`, without a layer.
std::unique_ptr<Medium> make_layer(std::unique_ptr<Medium> inner, const Capabilities& capabilities,
                                   PutLayer put);

}  // namespace gecos::media
