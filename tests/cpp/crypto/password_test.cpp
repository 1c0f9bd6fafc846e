#include "gecos/crypto/password.hpp"

#include <gtest/gtest.h>

#include <string>
#include <string_view>

namespace gecos::crypto {
namespace {

constexpr std::string_view password = "two hands";

Salt counted_salt() {
  Salt salt;
  for (std::size_t i = 0; i < salt.bytes().size(); ++i) salt.bytes()[i] = std::byte(i);
  return salt;
}

std::string hex_digits(ByteView bytes) {
  std::string text;
  for (const std::byte byte : bytes) {
    text += "0123456789abcdef"[std::to_integer<unsigned>(byte) >> 4];
    text += "0123456789abcdef"[std::to_integer<unsigned>(byte) & 15];
  }
  return text;
}

TEST(Password, HasTheKeyThatAnotherImplementationOfArgon2idDerives) {
  // argon2-cffi: hash_secret_raw(b"two hands", bytes(range(16)), 2, 19 * 1024, 1, 32, Type.ID)
  EXPECT_EQ(hex_digits(password_key(std::as_bytes(std::span(password)), counted_salt())),
            "c1845b1d28a937792c7fc3ad7ff9dc49a1634f0a210d1ab098293b5e12202ba0");
}

TEST(Password, HasAnotherKeyUnderAnotherSalt) {
  EXPECT_NE(password_key(std::as_bytes(std::span(password)), draw_salt()),
            password_key(std::as_bytes(std::span(password)), draw_salt()));
}

}  // namespace
}  // namespace gecos::crypto
