#pragma once

#include <string_view>
#include <utility>

#include "gecos/base/bytes.hpp"

namespace gecos::access {

/// A proof that a client knows a password: two proofs from the same password are equal.
///
/// No function prints or logs a proof. Proofs are compared in constant time. The destructor wipes a
/// proof from memory.
class Proof {
 public:
  Proof() = default;  ///< the proof of a client without a password
  explicit Proof(Bytes bytes) : bytes_(std::move(bytes)) {}
  Proof(const Proof&) = default;
  Proof(Proof&&) noexcept = default;
  Proof& operator=(const Proof& other);
  Proof& operator=(Proof&& other) noexcept;
  ~Proof();

  bool empty() const { return bytes_.empty(); }
  ByteView bytes() const { return bytes_; }
  bool proves_the_same_as(const Proof& other) const;

 private:
  void wipe();
  Bytes bytes_;
};

/// Returns a proof that consists of the password itself. Before a LeaseTable compares the proof,
/// the runtime replaces it by a proof that consists of a key derived from the password
/// (crypto/password.hpp).
Proof plain_proof(std::string_view password);

}  // namespace gecos::access
