#include "gecos/loan.hpp"

#include <utility>

#include "gecos/servant.hpp"

namespace gecos {

Loan& Loan::operator=(Loan&& other) noexcept {
  if (this == &other) return *this;
  give_back();
  publisher_ = std::exchange(other.publisher_, nullptr);
  stream_ = other.stream_;
  memory_ = std::exchange(other.memory_, {});
  octets_ = std::exchange(other.octets_, {});
  return *this;
}

std::span<std::uint8_t> Loan::octets() const {
  return {reinterpret_cast<std::uint8_t*>(octets_.data()), octets_.size()};
}

bool Loan::publish(std::int64_t stamp_ns) {
  if (publisher_ == nullptr) return false;
  bool published = false;
  std::exchange(publisher_, nullptr)->with([&](session::Publisher& publisher) {
    published = publisher.publish_lent(*stream_, memory_, stamp_ns);
  });
  octets_ = {};
  memory_ = {};
  return published;
}

void Loan::give_back() {
  if (publisher_ == nullptr) return;
  std::exchange(publisher_, nullptr)->with([&](session::Publisher& publisher) {
    publisher.give_back(*stream_, memory_);
  });
}

}  // namespace gecos
