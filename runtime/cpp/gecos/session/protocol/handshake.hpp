// Bodies of the packets that are not calls: opening a session, and what became of a command.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "gecos/base/ids.hpp"
#include "gecos/command.hpp"
#include "gecos/wire/contents.hpp"

namespace gecos::session {

/// Who asks for a session, and what it believes the object to be. What the medium proves about the
/// peer counts more than what is claimed here.
struct Hello {
  std::string user;
  std::string host;
  std::string program;
  std::int32_t pid = 0;
  std::uint64_t incarnation = 0;
  std::string interface_name;
  std::uint64_t interface_hash = 0;
  /// Calls that are older when the server reads them are not taken up: the client has given them
  /// up, or sends them again. 0: however old.
  Duration accept_within{0};

  std::size_t encoded_size() const;
  void encode(wire::Encoder& to) const;
  bool decode(wire::Decoder& from);
  static std::int64_t fingerprint() { return 0; }  // travels in an envelope, never alone
};

/// What travels in the calls of one operation, in a number.
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
