#pragma once

#include <string>

namespace gecos::audit {

/// Returns the folder of the audit of this user's servers: the one in the environment variable
/// `GECOS_AUDIT_DIR`, else $XDG_STATE_HOME/gecos/audit, else ~/.local/state/gecos/audit.
std::string default_folder();

}  // namespace gecos::audit
