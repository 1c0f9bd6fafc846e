#include "gecos/session/protocol/handshake.hpp"

#include <algorithm>

namespace gecos::session {
namespace {

constexpr std::size_t longest_name = 256;
constexpr std::size_t most_bases = 256;
constexpr std::size_t most_operations = 4096;
constexpr std::size_t operation_hash_size = 4 + 8;

bool get_rest(wire::Decoder& from, Bytes& into) {
  ByteView rest;
  if (!from.get_view(rest, from.remaining(), "rest")) return false;
  into.assign(rest.begin(), rest.end());
  return true;
}

}  // namespace

std::size_t Hello::encoded_size() const {
  return wire::string_size(user) + wire::string_size(host) + wire::string_size(program) + 4 + 8 +
         wire::string_size(interface_name) + 8 + 8;
}

void Hello::encode(wire::Encoder& to) const {
  to.put_string(user);
  to.put_string(host);
  to.put_string(program);
  to.put(pid);
  to.put(incarnation);
  to.put_string(interface_name);
  to.put(interface_hash);
  to.put(std::int64_t{accept_within.count()});
}

bool Hello::decode(wire::Decoder& from) {
  std::int64_t within = 0;
  const bool read =
      from.get_string(user, longest_name, "user") && from.get_string(host, longest_name, "host") &&
      from.get_string(program, longest_name, "program") && from.get(pid, "pid") &&
      from.get(incarnation, "incarnation") &&
      from.get_string(interface_name, longest_name, "interface_name") &&
      from.get(interface_hash, "interface_hash") && from.get(within, "accept_within_ns");
  accept_within = Duration(within);
  return read;
}

bool Welcome::is_a(const std::string& name) const {
  return name == interface_name || std::find(bases.begin(), bases.end(), name) != bases.end();
}

std::size_t Welcome::encoded_size() const {
  std::size_t size = wire::string_size(object) + wire::string_size(interface_name) + 4 + 8 + 8 + 4 +
                     4 + operations.size() * operation_hash_size;
  for (const auto& base : bases) size += wire::string_size(base);
  return size;
}

void Welcome::encode(wire::Encoder& to) const {
  to.put_string(object);
  to.put_string(interface_name);
  to.put_count(bases.size());
  for (const auto& base : bases) to.put_string(base);
  to.put(interface_hash);
  to.put(incarnation);
  to.put(credits);
  to.put_count(operations.size());
  for (const auto& operation : operations) {
    to.put(number(operation.code));
    to.put(operation.hash);
  }
}

bool Welcome::decode(wire::Decoder& from) {
  std::size_t count = 0;
  if (!from.get_string(object, longest_name, "object") ||
      !from.get_string(interface_name, longest_name, "interface_name") ||
      !from.get_count(count, wire::string_size(""), most_bases, "bases")) {
    return false;
  }
  bases.resize(count);
  for (auto& base : bases) {
    if (!from.get_string(base, longest_name, "bases")) return false;
  }
  if (!from.get(interface_hash, "interface_hash") || !from.get(incarnation, "incarnation") ||
      !from.get(credits, "credits") ||
      !from.get_count(count, operation_hash_size, most_operations, "operations")) {
    return false;
  }
  operations.resize(count);
  for (auto& operation : operations) {
    std::uint32_t code = 0;
    if (!from.get(code, "operations") || !from.get(operation.hash, "operations")) return false;
    operation.code = FunctionCode{code};
  }
  return true;
}

std::size_t FailureBody::encoded_size() const {
  return wire::string_size(text) + wire::string_size(exception) + evidence.size();
}

void FailureBody::encode(wire::Encoder& to) const {
  to.put_string(text);
  to.put_string(exception);
  to.put_bytes(evidence);
}

bool FailureBody::decode(wire::Decoder& from) {
  return from.get_string(text, wire::npos, "text") &&
         from.get_string(exception, longest_name, "exception") && get_rest(from, evidence);
}

std::size_t ProgressBody::encoded_size() const { return 4 + 8 + feedback.size(); }

void ProgressBody::encode(wire::Encoder& to) const {
  to.put(position);
  to.put(fraction);
  to.put_bytes(feedback);
}

bool ProgressBody::decode(wire::Decoder& from) {
  return from.get(position, "position") && from.get(fraction, "fraction") &&
         get_rest(from, feedback);
}

}  // namespace gecos::session
