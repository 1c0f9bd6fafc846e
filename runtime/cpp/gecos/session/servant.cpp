#include "gecos/session/servant.hpp"

#include <chrono>

namespace gecos {

IncomingCall& IncomingCall::operator=(IncomingCall&& other) noexcept {
  IncomingCall dropped(std::move(*this));
  core_ = std::move(other.core_);
  return *this;
}

IncomingCall::~IncomingCall() {
  if (!core_) return;
  fail({Detail::Fault,
        "the handler of '" + std::string(operation().name) + "' gave no answer",
        {},
        {}});
}

void IncomingCall::finish(std::size_t size, FunctionRef<void(wire::Encoder&)> encode) {
  constexpr std::size_t usual = 512;
  std::byte buffer[usual];
  Bytes large;
  std::span<std::byte> result(buffer, std::min(size, usual));
  if (size > usual) {
    large.resize(size);
    result = large;
  }
  wire::Encoder to(result);
  encode(to);
  finish(ByteView(result.data(), to.written()));
}

std::int64_t unix_now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::system_clock::now().time_since_epoch())
      .count();
}

}  // namespace gecos
