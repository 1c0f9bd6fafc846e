#pragma once

#include <functional>
#include <memory>
#include <string>

#include "gecos/media/buffers/bulk.hpp"
#include "gecos/media/shm/control.hpp"

namespace gecos::media::shm {

/// The memory areas for the large packets of one connection. Each area is a sealed memfd. Its
/// descriptor is sent over the socket before the first packet in the area is announced.
class ShmBulk final : private AreaMaker {
 public:
  /// `look` must read the messages on the socket. If another thread is reading the messages, `look`
  /// must wait until that thread has finished.
  ShmBulk(int socket, RingWriter& ring, std::function<void()> look)
      : out(ring, *this), in(std::move(look)), socket_(socket) {}

  /// Processes a message of the peer whose type is Area or AreaEnd. Returns an error text when the
  /// message is invalid.
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
