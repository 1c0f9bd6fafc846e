#include "gecos/session/server/object_inward.hpp"

#include <algorithm>
#include <utility>

#include "gecos/session/protocol/inward_sample.hpp"
#include "gecos/session/protocol/sample_bounds.hpp"
#include "gecos/session/protocol/sample_time.hpp"
#include "gecos/session/server/server_session.hpp"

namespace gecos::session {
namespace {

/// The bounds of the streams that feed `stream`. The servant's thread copies each sample before the
/// sample is judged, so a client without a status must not choose the size. A client whose
/// interface is newer may have larger samples, up to those of a stream without a bound.
media::StreamBounds bounds_of(const InwardDescription& stream) {
  const std::size_t depth = stream.quality.depth != 0 ? stream.quality.depth : usual_depth;
  return {inward_header_size + std::max(stream.largest, unbounded_sample) + measured_bytes, depth};
}

}  // namespace

ObjectInward::ObjectInward(const ObjectSetup& setup, const NameClaim& claim,
                           const access::ObjectPresence& presence) {
  for (const InwardDescription* stream : setup.interface.all_inward_streams()) {
    ports_.push_back(
        std::make_unique<InwardPort>(*stream, setup.clock(), setup.pauses(), claim, presence));
  }
}

InwardPort* ObjectInward::find(FunctionCode code) const {
  const auto code_of = [](const auto& port) { return port->stream().code; };
  const auto place = std::ranges::lower_bound(ports_, code, {}, code_of);
  return place != ports_.end() && code_of(*place) == code ? place->get() : nullptr;
}

tl::expected<bool, std::string> ObjectInward::feed(InwardPort& port,
                                                   const std::shared_ptr<ServerSession>& session,
                                                   std::uint32_t id) const {
  if (port.has(session->id(), id)) return true;
  media::Connection& connection = session->connection();
  auto reader = connection.open_stream(id, bounds_of(port.stream()));
  if (!reader) {
    if (auto why = connection.why_no_stream(id); !why.empty())
      return tl::unexpected(std::move(why));
    return false;
  }
  port.add({session->id(), id, std::move(reader), session->standing,
            [session] { return session->connection().clock_difference().value_or(Duration{}); }});
  return true;
}

void ObjectInward::depart(SessionId session) const {
  for (const auto& port : ports_) port->depart(session);
}

std::vector<InwardStats> ObjectInward::stats() const {
  std::vector<InwardStats> all;
  for (const auto& port : ports_) {
    all.push_back({std::string(port->stream().name), port->report()});
  }
  return all;
}

}  // namespace gecos::session
