#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>

#include "gecos/description.hpp"

/// Samples whose @bulk sequence a servant writes directly into the memory that the readers read.
namespace gecos {

namespace session {

class PublisherSlot;

/// Memory for one encoded sample, which the medium of the readers lends.
struct LentMemory {
  std::span<std::byte> bytes{};
  std::shared_ptr<void> owner{};  ///< keeps `bytes` valid
};

}  // namespace session

/// The next sample of a stream, in the memory that the readers of the stream read. A generated
/// function such as `lend_picture` makes the loan and writes all members but the octets of the
/// @bulk sequence; the servant writes the octets and calls publish(). If a loan ends without
/// publish(), no sample is published.
///
/// While a stream has a loan, nothing else can be published on this stream. Like publishing, a loan
/// is used by one thread at a time. It must end before its servant; it may outlive the server.
class Loan {
 public:
  /// No memory is lent.
  Loan() = default;
  /// For the runtime.
  Loan(const session::PublisherSlot& publisher, const StreamDescription& outward,
       session::LentMemory memory, std::span<std::byte> octets)
      : publisher_(&publisher), stream_(&outward), memory_(std::move(memory)), octets_(octets) {}
  Loan(Loan&& other) noexcept { *this = std::move(other); }
  Loan& operator=(Loan&& other) noexcept;
  ~Loan() { give_back(); }

  /// Returns whether this loan has memory. It has none after publish(), if no server serves the
  /// servant, and if the sample was refused, in which case the log has the reason.
  explicit operator bool() const { return publisher_ != nullptr; }
  /// Returns the octets of the @bulk sequence, which are not initialized. They may be written until
  /// publish(), and must not be used afterwards.
  std::span<std::uint8_t> octets() const;
  /// For bindings of other languages: returns an owner that keeps the memory valid after the end of
  /// the loan.
  std::shared_ptr<void> owner() const { return memory_.owner; }
  /// Publishes the sample and ends the loan. Returns false if the server has closed the stream, or
  /// no longer serves the servant. `stamp_ns`: the Unix time in ns at which the sample was
  /// measured.
  bool publish(std::int64_t stamp_ns = measured_now);

 private:
  void give_back();

  const session::PublisherSlot* publisher_ = nullptr;
  const StreamDescription* stream_ = nullptr;
  session::LentMemory memory_;
  std::span<std::byte> octets_;
};

}  // namespace gecos
