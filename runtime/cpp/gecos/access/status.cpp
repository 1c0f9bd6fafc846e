#include "gecos/access/status.hpp"

namespace gecos::access {

std::string_view to_string(Status status) {
  switch (status) {
    case Status::Sensor:
      return "sensor";
    case Status::Actor:
      return "actor";
    case Status::Master:
      return "master";
  }
  return "unknown status";
}

}  // namespace gecos::access
