#include "gecos/base/pid_namespace.hpp"
#include "gecos/binding.hpp"
#include "gecos/broker_types.hpp"  // generated from idl/gecos/broker.gidl
#include "gecos/media/kinds.hpp"

namespace gecos::session {

bool sees_process(const Entry& entry) {
  const std::string here = media::host_identity();
  return entry.pid > 0 && entry.pid_namespace != 0 && entry.pid_namespace == pid_namespace() &&
         entry.host == here && media::on_one_machine(entry.host, here);
}

}  // namespace gecos::session
