// Bodies of the packets that are not calls: opening a session, and progress and failure of
// commands.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"
#include "gecos/wire/contents.hpp"

namespace gecos::session {

/// The client that asks for a session, and the interface that it expects. What the medium proves
/// about the peer overrides what is claimed here.
struct Hello {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
  std::uint64_t incarnation = 0;
  std::string interface_name;
  std::uint64_t interface_hash = 0;
  /// Maximum age of a call when the server reads it. The server does not accept older calls: the
  /// client has given them up, or sends them again. 0: no limit.
  Duration accept_within{0};

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }  // sent in an envelope, never alone
};

/// A hash of what is encoded in the calls of one operation.
struct OperationHash {
  FunctionCode code{};
  std::uint64_t hash = 0;
};

/// The session that was opened: its id is in the envelope.
struct Welcome {
  std::string object;
  std::string interface_name;
  std::vector<std::string> bases;
  std::uint64_t interface_hash = 0;
  std::uint64_t incarnation = 0;
  std::uint32_t credits = 0;              ///< calls that the client may have unanswered
  std::vector<OperationHash> operations;  ///< all, when the client's interface is not this one

  bool is_a(const std::string& name) const;
  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

/// Body of Refused and of a Reply that is not DONE; the detail is in the envelope's flags.
struct FailureBody {
  std::string text;
  std::string exception;
  Bytes evidence;

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

/// Body of Progress; the detail (Queued, Executing, Canceling) is in the envelope's flags.
struct ProgressBody {
  std::uint32_t position = 0;
  double fraction = 0;
  Bytes feedback;  ///< the rest of the body

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

}  // namespace gecos::session
