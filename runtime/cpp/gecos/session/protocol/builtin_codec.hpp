// Arguments and results of gecos::GecosObject and gecos::Broker, laid out as gidl lays them out.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gecos/access/status.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/object_types.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/wire/fields.hpp"

namespace gecos::session {

/// An appendable value in its block.
template <class T>
std::size_t block_size(const T& value) {
  return 4 + value.encoded_size();
}
template <class T>
void put_block(wire::Encoder& to, const T& value) {
  to.put_count(value.encoded_size());
  value.encode(to);
}

template <class T>
Bytes block_bytes(const T& value) {
  Bytes bytes(block_size(value));
  wire::Encoder to(bytes);
  put_block(to, value);
  return bytes;
}

template <class T>
std::size_t blocks_size(const std::vector<T>& values) {
  std::size_t size = 4;
  for (const auto& value : values) size += block_size(value);
  return size;
}
template <class T>
Bytes blocks_bytes(const std::vector<T>& values) {
  Bytes bytes(blocks_size(values));
  wire::Encoder to(bytes);
  to.put_count(values.size());
  for (const auto& value : values) put_block(to, value);
  return bytes;
}
template <class T>
[[nodiscard]] bool get_blocks(wire::Decoder& from, std::vector<T>& values) {
  return wire::get_sequence(from, values, 4, wire::npos, "result",
                            [&](T& value) { return wire::get_block(from, value, "result"); });
}

inline access::Status status_of(Status status) { return static_cast<access::Status>(status); }
inline Status status_of(access::Status status) { return static_cast<Status>(status); }

}  // namespace gecos::session
