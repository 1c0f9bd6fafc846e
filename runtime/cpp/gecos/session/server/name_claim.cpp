#include "gecos/session/server/name_claim.hpp"

namespace gecos::session {

std::string NameClaim::text() const {
  switch (standing_) {
    case Standing::Unregistered:
      return "not needed";
    case Standing::Asked:
      return "the broker has not yet confirmed that this object still has its name";
    case Standing::Unanswered:
      return "no broker confirms that this object still has its name (" + why_ +
             "); the server goes on asking";
    case Standing::Held:
      return "confirmed";
    case Standing::Taken:
      return "another server has the name: " + why_ +
             "; create a new proxy to reach that server, or end that server";
  }
  return {};
}

}  // namespace gecos::session
