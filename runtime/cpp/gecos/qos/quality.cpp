#include "gecos/qos/quality.hpp"

namespace gecos::qos {

std::string_view to_string(Class line) {
  switch (line) {
    case Class::TimeIndependent:
      return "TIME_INDEPENDENT";
    case Class::SoftRealtime:
      return "SOFT_REALTIME";
    case Class::HardRealtime:
      return "HARD_REALTIME";
  }
  return "unknown class";
}

std::string_view to_string(Reliability reliability) {
  return reliability == Reliability::Reliable ? "RELIABLE" : "BEST_EFFORT";
}

}  // namespace gecos::qos
