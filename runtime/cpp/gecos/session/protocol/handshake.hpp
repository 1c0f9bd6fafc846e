// The bodies of the packets that open a session or report the progress or failure of a command.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"
#include "gecos/wire/contents.hpp"

namespace gecos::session {

/// Body of a Hello packet: describes the client that opens a session, and the interface that this
/// client expects. If the medium proves the identity of the client, the server uses the proved
/// identity instead of the one that the client claims here.
struct Hello {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
  std::uint64_t incarnation = 0;
  std::string interface_name;
  std::uint64_t interface_hash = 0;
  /// Maximum age of a call when the server reads it. The server does not accept older calls,
  /// because the client has given these calls up or sends them again. 0: no limit.
  Duration accept_within{0};

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  /// No fingerprint is sent, because the kind of the packet tells the type.
  static std::int64_t fingerprint() { return 0; }
};

/// A hash of the encoding of one operation's calls.
struct OperationHash {
  FunctionCode code{};
  std::uint64_t hash = 0;
};

/// Body of a Welcome packet: describes the session that was opened. The id of the session is in the
/// packet header.
struct Welcome {
  std::string object;
  std::string interface_name;
  std::vector<std::string> bases;
  std::uint64_t interface_hash = 0;
  std::uint64_t incarnation = 0;
  std::uint32_t credits = 0;  ///< maximum number of calls of the client that are without a reply
  /// The hashes of all operations of the interface. Empty if the interface_hash of the Hello equals
  /// that of the server.
  std::vector<OperationHash> operations;

  bool is_a(const std::string& name) const;
  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

/// Body of a Refused packet, and of a Reply packet that reports a failure. The flags of the packet
/// header contain the detail.
struct FailureBody {
  std::string text;
  std::string exception;
  Bytes evidence;

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

/// Body of a Progress packet. The flags of the packet header contain the detail (Queued, Executing
/// or Canceling).
struct ProgressBody {
  std::uint32_t position = 0;
  double fraction = 0;
  Bytes feedback;  ///< all remaining bytes of the packet body

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }
};

}  // namespace gecos::session
