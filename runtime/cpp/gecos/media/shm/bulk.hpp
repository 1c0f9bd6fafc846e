#pragma once

#include <functional>
#include <memory>
#include <string>

#include "gecos/media/parts/bulk.hpp"
#include "gecos/media/shm/control.hpp"

namespace gecos::media::shm {

/// The areas of one link: each in sealed memory of its own, whose descriptor is sent over the
/// socket before the first packet in it is announced.
class ShmBulk final : private AreaMaker {
 public:
  /// `look` reads the socket, and waits for what another thread is reading from it.
  ShmBulk(int socket, RingWriter& ring, std::function<void()> look)
      : out(ring, *this), in(std::move(look)), socket_(socket) {}

  /// Area or AreaEnd of the peer. Fails with what is wrong with it.
  tl::expected<void, std::string> take(ReceivedControl& control);

  BulkWriter out;
  BulkReader in;

 private:
  std::shared_ptr<Mapping> make_area(std::uint64_t number) override;
  bool release(std::uint64_t number) override;

  const int socket_;
  bool warned_ = false;
};

}  // namespace gecos::media::shm
