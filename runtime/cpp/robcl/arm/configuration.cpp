#include "robcl/arm/configuration.hpp"

#include <ostream>

namespace robcl::arm {
namespace {

template <typename Choice>
bool fits(const std::optional<Choice>& asked, const std::optional<Choice>& actual) {
  return !asked || !actual || *asked == *actual;
}

template <typename Choice>
const char* word(const std::optional<Choice>& choice, const char* first, const char* second) {
  if (!choice) return "any";
  return *choice == static_cast<Choice>(0) ? first : second;
}

}  // namespace

bool Configuration::admits(const Configuration& other) const {
  return fits(shoulder, other.shoulder) && fits(elbow, other.elbow) && fits(wrist, other.wrist);
}

std::ostream& operator<<(std::ostream& out, const Configuration& configuration) {
  return out << word(configuration.shoulder, "righty", "lefty") << ", "
             << word(configuration.elbow, "above", "below") << ", "
             << word(configuration.wrist, "noflip", "flip");
}

}  // namespace robcl::arm
