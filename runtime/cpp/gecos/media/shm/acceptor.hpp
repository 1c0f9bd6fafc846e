#pragma once

#include <array>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "gecos/base/event_fd.hpp"
#include "gecos/base/fork_watch.hpp"
#include "gecos/media/shm/control.hpp"
#include "gecos/media/shm/shm.hpp"

namespace gecos::media::shm {

/// An acceptor that listens at a Unix socket in the runtime directory. When it opens, it removes
/// the sockets of dead servers from that directory.
class ShmAcceptor final : public Acceptor {
 public:
  static tl::expected<std::unique_ptr<Acceptor>, MediumError> open(const ShmOptions& options,
                                                                   std::string_view name,
                                                                   bool well_known);
  ~ShmAcceptor() override;

  const Capabilities& capabilities() const override;
  const std::string& address() const override { return address_; }
  void admit_by(AdmitPeer admit) override { admit_ = std::move(admit); }
  std::unique_ptr<Connection> accept() override;
  bool short_of_descriptors() const override { return short_of_descriptors_; }
  std::span<const int> descriptors() const override { return descriptors_; }
  std::unique_ptr<StreamWriter> make_stream(std::size_t largest, std::size_t depth) override;

  ShmAcceptor(std::string path, Descriptor listener);

 private:
  /// A client that has connected and has not yet sent its Hello message.
  struct PendingPeer {
    Descriptor socket;
    Peer peer;
    Descriptor death;
  };
  bool let_in();
  std::string why_not(const Peer& peer) const;
  bool turn_away();
  void log_turned_away() const;
  std::unique_ptr<Connection> hear(std::size_t pending);
  void drop(std::size_t pending);
  void abandon() noexcept;

  const std::string path_;
  const std::string address_;
  AdmitPeer admit_;
  Descriptor listener_;
  Descriptor epoll_;
  EventFd more_;      // notified by accept() if more clients may wait than one call accepts
  Descriptor spare_;  // closed for a moment to refuse a client when no other descriptor is left
  bool short_of_descriptors_ = false;
  std::vector<PendingPeer> pending_;
  const std::array<int, 1> descriptors_;
  bool inherited_ = false;
  const ForkWatch fork_watch_;
};

/// Returns the path of the well-known socket with the name `name`.
std::string well_known_path(const std::string& directory, std::string_view name);
/// Returns a socket that is connected to `path`. On failure, returns an empty Descriptor and sets
/// errno.
Descriptor connect_to(const std::string& path);

}  // namespace gecos::media::shm
