#include "gecos/binding.hpp"
#include "gecos/broker_interface.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/connect.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/client/lab_file_settings.hpp"

namespace gecos::session {

tl::expected<std::shared_ptr<ClientSession>, std::string> broker_session(const LabOrWhyNot& lab,
                                                                         TimePoint deadline) {
  return (*lab)->broker(deadline).map_error([](NoBroker why) { return std::move(why.text); });
}

tl::expected<std::shared_ptr<ClientSession>, std::string> session_at(const LabOrWhyNot& lab,
                                                                     const std::string& address,
                                                                     TimePoint deadline) {
  Context& context = **lab;
  auto opened = connect(*context.runtime(), address, GecosObjectInterface::description, deadline);
  if (opened && !context.keep(*opened)) {
    return tl::unexpected(std::string("this Lab is closed; make a new one"));
  }
  return opened;
}

tl::expected<access::LabBroker, std::string> broker_in_lab_file(Duration patience) {
  return LabFileSettings({}).broker(deadline_after(patience));
}

std::vector<BrokerPlace> find_brokers(const LabOrWhyNot& lab, Duration patience) {
  std::vector<BrokerPlace> places;
  Runtime& runtime = *(*lab)->runtime();
  for (const media::Kind kind : media::all_kinds()) {
    if (media::reach_of(kind) == media::Reach::Process) continue;
    const auto medium = runtime.medium(kind);
    if (!medium) continue;
    const std::string address = (*medium)->well_known_address(broker_name);
    const auto found =
        connect(runtime, address, BrokerInterface::description, deadline_after(patience));
    if (!found) continue;
    places.push_back({address, IncarnationId{(*found)->welcome().incarnation}});
    (*found)->close(patience);
  }
  return places;
}

}  // namespace gecos::session
