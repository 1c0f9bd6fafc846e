#include "gecos/access/proof.hpp"

#include <cstring>
#include <utility>

namespace gecos::access {

Proof& Proof::operator=(const Proof& other) {
  if (this == &other) return *this;
  wipe();
  bytes_ = other.bytes_;
  return *this;
}

Proof& Proof::operator=(Proof&& other) noexcept {
  if (this == &other) return *this;
  wipe();
  bytes_ = std::exchange(other.bytes_, {});
  return *this;
}

Proof::~Proof() { wipe(); }

void Proof::wipe() {
  // The pointer is `volatile`, because the compiler may otherwise remove writes to memory that is
  // freed next.
  volatile std::byte* const byte = bytes_.data();
  for (std::size_t i = 0; i < bytes_.size(); ++i) byte[i] = std::byte{0};
}

bool Proof::proves_the_same_as(const Proof& other) const {
  if (bytes_.size() != other.bytes_.size()) return false;
  auto difference = std::byte{0};
  for (std::size_t i = 0; i < bytes_.size(); ++i) difference |= bytes_[i] ^ other.bytes_[i];
  return difference == std::byte{0};
}

Proof plain_proof(std::string_view password) {
  Bytes bytes(password.size());
  if (!password.empty()) std::memcpy(bytes.data(), password.data(), password.size());
  return Proof(std::move(bytes));
}

}  // namespace gecos::access
