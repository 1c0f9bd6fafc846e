#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "gecos/access/status.hpp"
#include "gecos/base/clock.hpp"
#include "gecos/base/ids.hpp"
#include "gecos/qos/quality.hpp"

/// The interface description that the session uses: constant tables that gidl generates.
namespace gecos {

enum class OperationKind : std::uint8_t { Operation, Getter, Setter };
enum class OnNew : std::uint8_t { Queue, Reject, Preempt, Blend };
enum class OnLoss : std::uint8_t { Stop, Finish };

struct OperationDescription {
  FunctionCode code{};
  std::string_view name{};  ///< for example "move"; "tool" for a getter, "tool=" for a setter
  std::uint64_t hash = 0;
  OperationKind kind = OperationKind::Operation;
  access::Status status = access::Status::Actor;  ///< the status that the caller needs
  bool safety = false;      ///< starts before all queued calls; never refused for lack of status
  bool presence = true;     ///< needs a person in the laboratory
  bool idempotent = false;  ///< may be sent again in a new session
  bool cancelable = false;  ///< long-running: runs on a worker thread and reports progress
  bool parallel = false;    ///< may run at the same time as other actor commands
  /// True for a sensor operation that keeps its place among the actor commands of its caller.
  bool ordered = false;
  OnNew on_new = OnNew::Queue;
  OnLoss on_loss = OnLoss::Stop;
  qos::Quality quality{};
};

/// Makes the entry for one operation in a generated table. `rest` has the values of the other
/// members, as far as they differ from their defaults.
constexpr OperationDescription operation(std::uint32_t code, std::string_view name,
                                         std::uint64_t hash, OperationDescription rest = {}) {
  rest.code = FunctionCode{code};
  rest.name = name;
  rest.hash = hash;
  return rest;
}

/// Makes the entry for the getter of an attribute, like `operation`. A getter needs only sensor
/// status and is idempotent.
constexpr OperationDescription getter(std::uint32_t code, std::string_view name, std::uint64_t hash,
                                      OperationDescription rest = {}) {
  rest.kind = OperationKind::Getter;
  rest.status = access::Status::Sensor;
  rest.presence = false;
  rest.idempotent = true;
  return operation(code, name, hash, rest);
}

/// A stream that the server publishes. The operation with the same code reads the attribute once;
/// an event has no such operation.
struct StreamDescription {
  FunctionCode code{};
  std::string_view name{};
  access::Status status = access::Status::Sensor;
  double rate_hz = 0;
  /// The size of the largest sample in bytes. 0: the interface sets no bound, and samples of up to
  /// 64 KiB are sent.
  std::size_t largest = 0;
  bool bulk = false;  ///< samples have a @bulk sequence of octets, which can be written in place
  /// True if each sample is an occurrence of an event. A reader gets only the occurrences after its
  /// subscription.
  bool event = false;
  /// The hash of an event; 0 for any other stream, because its getter has the hash.
  std::uint64_t hash = 0;
  /// The LCM fingerprint of the samples of an @open_stream; nullopt for other streams.
  std::optional<std::uint64_t> open_fingerprint{};
  qos::Quality quality{};
};

/// A stream of samples that clients send to the servant.
struct InwardDescription {
  FunctionCode code{};
  std::string_view name{};
  std::uint64_t hash = 0;
  access::Status status = access::Status::Actor;  ///< the status that a sender needs
  bool presence = true;                           ///< needs a person in the laboratory
  double rate_hz = 0;
  /// A sample that is older than this time when it is read has no effect; 0: no limit.
  Duration watchdog{};
  /// The size of the largest sample in bytes. 0: the interface sets no bound, and samples of up to
  /// 64 KiB are sent.
  std::size_t largest = 0;
  qos::Quality quality{};
};

/// Stands for the time stamp of a sample that is measured at the moment at which it is published or
/// sent.
inline constexpr std::int64_t measured_now = std::numeric_limits<std::int64_t>::min();

struct InterfaceDescription {
  std::string_view name{};  ///< for example "robcl::Rx90"
  std::string_view version{};
  std::uint64_t hash = 0;
  std::span<const std::string_view> bases{};  ///< scoped names of all direct and indirect bases
  /// The direct bases, whose operations and streams this interface inherits.
  std::span<const InterfaceDescription* const> inherits{};
  std::span<const OperationDescription>
      operations{};  ///< operations that are not inherited, sorted by code
  std::span<const StreamDescription> streams{};  ///< streams that are not inherited, sorted by code
  std::span<const InwardDescription>
      inward_streams{};  ///< inward streams that are not inherited, sorted by code
  qos::Quality quality{};
  /// This interface as JSON, without its bases, as gidl writes it; empty for the built-in
  /// operations.
  std::string_view model{};

  /// Returns the operation (or stream) that has this code, whether the interface declares it itself
  /// or inherits it. Returns null when there is none.
  const OperationDescription* find(FunctionCode code) const;
  const StreamDescription* find_stream(FunctionCode code) const;
  const InwardDescription* find_inward_stream(FunctionCode code) const;
  /// Returns all operations (or streams) that the interface declares or inherits, each once, sorted
  /// by code.
  std::vector<const OperationDescription*> all_operations() const;
  std::vector<const StreamDescription*> all_streams() const;
  std::vector<const InwardDescription*> all_inward_streams() const;
  /// Returns the models of this interface and of all its bases, each once.
  std::vector<std::string_view> all_models() const;
  bool is_a(std::string_view interface_name) const;
};

}  // namespace gecos
