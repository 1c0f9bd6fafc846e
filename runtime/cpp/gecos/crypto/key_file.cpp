#include "gecos/crypto/key_file.hpp"

#include <sodium.h>

#include <algorithm>
#include <array>

namespace gecos::crypto {
namespace {

constexpr std::size_t word_bytes = 15;
constexpr std::size_t check_at = word_bytes + 2 * key_bytes + 1;
constexpr std::size_t check_digits = 8;
static_assert(check_at + check_digits + 1 == key_file_bytes);

tl::unexpected<std::string_view> wrong(std::string_view what) {
  return tl::unexpected<std::string_view>(what);
}

std::string_view word_of(KeyFileKind kind) {
  return kind == KeyFileKind::SecretKey ? "gecos-secret-1 " : "gecos-public-1 ";
}

/// Writes the hex digits of `bytes` to `to`, without a NUL at the end.
void write_hex(std::span<const std::byte> bytes, std::byte* to) {
  constexpr std::string_view digits = "0123456789abcdef";
  for (const std::byte byte : bytes) {
    const auto value = std::to_integer<std::size_t>(byte);
    *to++ = std::byte(digits[value >> 4]);
    *to++ = std::byte(digits[value & 0xf]);
  }
}

std::array<std::byte, check_digits> check_of(std::span<const std::byte> before) {
  Secret<crypto_hash_sha256_BYTES> hash;
  ::crypto_hash_sha256(reinterpret_cast<unsigned char*>(hash.bytes().data()),
                       reinterpret_cast<const unsigned char*>(before.data()), before.size());
  std::array<std::byte, check_digits> digits;
  write_hex(hash.bytes().first<check_digits / 2>(), digits.data());
  return digits;
}

}  // namespace

KeyText key_file_text(KeyFileKind kind, std::span<const std::byte, key_bytes> key) {
  KeyText text;
  const auto all = text.bytes();
  std::ranges::transform(word_of(kind), all.begin(), [](char c) { return std::byte(c); });
  write_hex(key, all.data() + word_bytes);
  all[check_at - 1] = std::byte{' '};
  std::ranges::copy(check_of(all.first<check_at>()), all.begin() + check_at);
  all.back() = std::byte{'\n'};
  return text;
}

tl::expected<Secret<key_bytes>, std::string_view> read_key_file(KeyFileKind kind,
                                                                std::span<const std::byte> text) {
  if (text.empty()) return wrong("is empty");
  if (text.size() < key_file_bytes) return wrong("is cut short");
  if (text.size() > key_file_bytes) return wrong("holds more than a key");
  Secret<key_bytes> key;
  const char* const digits = reinterpret_cast<const char*>(text.data()) + word_bytes;
  std::size_t size = 0;
  const bool hex = ::sodium_hex2bin(reinterpret_cast<unsigned char*>(key.bytes().data()), key_bytes,
                                    digits, 2 * key_bytes, nullptr, &size, nullptr) == 0;
  const auto word = text.first(word_bytes);
  const bool ours = std::ranges::equal(
      word, word_of(kind), [](std::byte have, char want) { return have == std::byte(want); });
  if (!ours) return wrong("is not a key file of the expected kind");
  if (!hex || size != key_bytes ||
      !std::ranges::equal(text, key_file_text(kind, key.bytes()).bytes())) {
    return wrong("is damaged (its checksum does not match)");
  }
  return key;
}

}  // namespace gecos::crypto
