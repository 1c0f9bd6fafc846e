#include "gecos/media/shm/bulk.hpp"

#include <array>
#include <utility>

#include "gecos/base/log.hpp"
#include "gecos/media/shm/memory.hpp"

namespace gecos::media::shm {

tl::expected<void, std::string> ShmBulk::take(ReceivedControl& control) {
  const std::uint64_t number = control.message.largest;
  if (control.message.type == ControlType::AreaEnd) {
    in.end(number);
    return {};
  }
  Descriptor& memfd = control.descriptors[0];
  auto mapping = map_received(memfd.get(), area_bytes);
  if (mapping) {
    in.know(number, std::make_shared<const Mapping>(std::move(*mapping)));
  } else if (mapping.error().cause == NotMapped::Cause::NoRoom) {
    in.know_unmapped(number, std::move(memfd));
  } else {
    return tl::unexpected(std::move(mapping.error().text));
  }
  return {};
}

std::shared_ptr<Mapping> ShmBulk::make_area(std::uint64_t number) {
  auto sealed = make_sealed("gecos bulk", area_bytes);
  if (!sealed) {
    if (!std::exchange(warned_, true)) {
      log_warning("shm",
                  "no memory for a large packet, so the packet waits: " + sealed.error().text);
    }
    return nullptr;
  }
  const std::array given{sealed->memfd.get()};
  const ControlMessage message{.type = ControlType::Area, .largest = number};
  if (!send_control(socket_, message, given)) return nullptr;
  return std::make_shared<Mapping>(std::move(sealed->mapping));
}

bool ShmBulk::release(std::uint64_t number) {
  return send_control(socket_, {.type = ControlType::AreaEnd, .largest = number});
}

}  // namespace gecos::media::shm
