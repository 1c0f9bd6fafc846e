#include "dynamic_description.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <algorithm>
#include <deque>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

namespace gecos::python {
namespace {

namespace nb = nanobind;

/// The description of an interface, together with the data to which the description points. Texts
/// and models are elements of deques, so that pointers to them stay valid.
struct OwnedDescription {
  std::deque<std::string> texts;
  std::vector<std::string_view> bases;
  std::vector<OperationDescription> operations;
  std::vector<StreamDescription> streams;
  std::vector<InwardDescription> inward_streams;
  /// One description for the interface itself and one for each of its bases. Each of these
  /// descriptions contains only the JSON model that the object serves. The operations of all bases
  /// are in `operations`.
  std::deque<InterfaceDescription> models;
  std::vector<const InterfaceDescription*> inherits;
  InterfaceDescription table;

  std::string_view keep(nb::handle text) { return texts.emplace_back(nb::cast<std::string>(text)); }
};

template <class T>
T field(nb::handle table, const char* name) {
  return nb::cast<T>(table.attr(name));
}

/// Converts the attribute `name` of `table`, a Python IntEnum, to the C++ enum with the same
/// values. Throws for values above `last`.
template <class Enum>
Enum enumerator(nb::handle table, const char* name, Enum last) {
  const auto number = field<std::uint8_t>(table, name);
  if (number > static_cast<std::uint8_t>(last)) throw nb::value_error(name);
  return static_cast<Enum>(number);
}

Duration duration(nb::handle table, const char* name) {
  return Duration(field<Duration::rep>(table, name));
}

qos::Quality quality_of(nb::handle table) {
  qos::Quality quality;
  quality.line = enumerator(table, "line", qos::Class::HardRealtime);
  quality.reliability = enumerator(table, "reliability", qos::Reliability::BestEffort);
  quality.deadline = duration(table, "deadline_ns");
  quality.start_by = duration(table, "start_by_ns");
  quality.latency = duration(table, "latency_ns");
  quality.lifespan = duration(table, "lifespan_ns");
  quality.liveliness = field<bool>(table, "manual_liveliness") ? qos::Liveliness::Manual
                                                               : qos::Liveliness::Automatic;
  quality.depth = field<std::uint32_t>(table, "depth");
  quality.on_degraded = enumerator(table, "on_degraded", qos::OnDegraded::Failover);
  quality.media = static_cast<qos::Media>(field<std::uint8_t>(table, "media"));
  return quality;
}

OperationDescription operation_of(nb::handle table, OwnedDescription& owner) {
  OperationDescription operation;
  operation.code = FunctionCode{field<std::uint32_t>(table, "code")};
  operation.name = owner.keep(table.attr("name"));
  operation.kind = enumerator(table, "kind", OperationKind::Setter);
  operation.status = enumerator(table, "access", access::Status::Master);
  operation.safety = field<bool>(table, "safety");
  operation.presence = field<bool>(table, "presence");
  operation.idempotent = field<bool>(table, "idempotent");
  operation.cancelable = field<bool>(table, "cancelable");
  operation.parallel = field<bool>(table, "parallel");
  operation.ordered = field<bool>(table, "ordered");
  operation.on_new = enumerator(table, "on_new", OnNew::Blend);
  operation.on_loss = enumerator(table, "on_loss", OnLoss::Finish);
  operation.quality = quality_of(table.attr("quality"));
  operation.hash = field<std::uint64_t>(table, "hash");
  return operation;
}

StreamDescription stream_of(nb::handle table, OwnedDescription& owner) {
  StreamDescription stream;
  stream.code = FunctionCode{field<std::uint32_t>(table, "code")};
  stream.name = owner.keep(table.attr("name"));
  stream.status = enumerator(table, "access", access::Status::Master);
  stream.rate_hz = field<double>(table, "rate_hz");
  stream.largest = field<std::size_t>(table, "largest");
  stream.bulk = field<bool>(table, "bulk");
  stream.event = field<bool>(table, "event");
  stream.hash = field<std::uint64_t>(table, "hash");
  stream.open_fingerprint = field<std::optional<std::uint64_t>>(table, "open_fingerprint");
  stream.quality = quality_of(table.attr("quality"));
  return stream;
}

InwardDescription inward_of(nb::handle table, OwnedDescription& owner) {
  InwardDescription stream;
  stream.code = FunctionCode{field<std::uint32_t>(table, "code")};
  stream.name = owner.keep(table.attr("name"));
  stream.hash = field<std::uint64_t>(table, "hash");
  stream.status = enumerator(table, "access", access::Status::Master);
  stream.presence = field<bool>(table, "presence");
  stream.rate_hz = field<double>(table, "rate_hz");
  stream.watchdog = duration(table, "watchdog_ns");
  stream.largest = field<std::size_t>(table, "largest");
  stream.quality = quality_of(table.attr("quality"));
  return stream;
}

}  // namespace

const InterfaceDescription& description_of(nb::handle interface) {
  // These two containers are leaked on purpose: threads of sessions may still read the descriptions
  // while the process exits.
  static auto& kept = *new std::deque<OwnedDescription>();
  static auto& known = *new std::unordered_map<PyObject*, const InterfaceDescription*>();
  if (const auto found = known.find(interface.ptr()); found != known.end()) return *found->second;
  OwnedDescription made;
  for (const nb::handle base : interface.attr("bases")) made.bases.push_back(made.keep(base));
  for (const nb::handle operation : interface.attr("operations")) {
    made.operations.push_back(operation_of(operation, made));
  }
  for (const nb::handle stream : interface.attr("streams")) {
    made.streams.push_back(stream_of(stream, made));
  }
  for (const nb::handle stream : interface.attr("inward_streams")) {
    made.inward_streams.push_back(inward_of(stream, made));
  }
  for (const nb::handle model : interface.attr("models")) {
    made.models.emplace_back().model = made.keep(model);
  }
  const auto by_code = [](const auto& a, const auto& b) { return a.code < b.code; };
  std::ranges::sort(made.operations, by_code);
  std::ranges::sort(made.streams, by_code);
  std::ranges::sort(made.inward_streams, by_code);
  made.table.name = made.keep(interface.attr("name"));
  made.table.version = made.keep(interface.attr("version"));
  made.table.hash = field<std::uint64_t>(interface, "hash");
  made.table.quality = quality_of(interface.attr("quality"));

  OwnedDescription& owned = kept.emplace_back(std::move(made));
  owned.table.bases = owned.bases;
  owned.table.operations = owned.operations;
  owned.table.streams = owned.streams;
  owned.table.inward_streams = owned.inward_streams;
  for (const InterfaceDescription& each : owned.models) owned.inherits.push_back(&each);
  owned.table.inherits = owned.inherits;
  interface.inc_ref();  // never released, so that no other interface gets this address
  known.emplace(interface.ptr(), &owned.table);
  return owned.table;
}

}  // namespace gecos::python
