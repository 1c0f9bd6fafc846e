#include "gecos/lab.hpp"

#include <algorithm>
#include <ostream>

#include "gecos/base/log.hpp"
#include "gecos/binding.hpp"
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/connect.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/client/movable_session.hpp"
#include "gecos/session/client/select.hpp"
#include "gecos/session/protocol/packets.hpp"

namespace gecos {

std::string CreateError::to_string() const {
  std::string text;
  for (const auto& attempt : attempts) {
    text += (text.empty() ? "" : "\n") + attempt.name + (attempt.name.empty() ? "" : ": ") +
            std::string(gecos::to_string(attempt.detail)) + ": " + attempt.reason;
  }
  return text;
}

std::ostream& operator<<(std::ostream& out, const CreateError& error) {
  return out << error.to_string();
}

namespace {

session::LabOrWhyNot make_context(LabOptions options, media::WrapMedium wrap) {
  if (const auto& problem = log_level_problem()) return tl::unexpected(session::NoLab{*problem});
  return session::Runtime::make(std::move(options), session::system_clock(), std::move(wrap))
      .map([](std::shared_ptr<session::Runtime> runtime) {
        return std::make_shared<session::Context>(std::move(runtime));
      });
}

}  // namespace

Lab::Lab(LabOptions options) : Lab(make_context(std::move(options), {})) {}

Lab::~Lab() = default;

void Lab::close() {
  if (core_) (*core_)->close(std::chrono::seconds(1));
}

namespace session {

Lab LabAccess::with_media(LabOptions options, media::WrapMedium wrap) {
  return Lab(make_context(std::move(options), std::move(wrap)));
}

namespace {

using Attempt = CreateError::Attempt;

bool entry_is_a(const Entry& entry, std::string_view interface_name) {
  return entry.interface_name == interface_name ||
         std::find(entry.bases.begin(), entry.bases.end(), interface_name) != entry.bases.end();
}

}  // namespace

CreateError::Attempt closed_lab(const std::string& name) {
  return {name, Detail::NoServer, "this Lab is closed; make a new one"};
}

tl::expected<Entry, CreateError::Attempt> find_entry(Context& lab,
                                                     const InterfaceDescription& wanted,
                                                     const std::string& name,
                                                     const CreateOptions& options) {
  if (name.empty()) {
    return tl::unexpected(Attempt{"(nil)", Detail::NoServer, "an empty name refers to no object"});
  }
  if (lab.closed()) return tl::unexpected(closed_lab(name));
  auto entry = look_up(lab, name, deadline_after(options.patience));
  if (!entry) return tl::unexpected(Attempt{name, Detail::NoServer, entry.error()});
  if (!entry_is_a(*entry, wanted.name)) {
    return tl::unexpected(Attempt{name, Detail::Refused,
                                  name + " is a " + entry->interface_name + ", not a " +
                                      std::string(wanted.name) + "; create a " +
                                      entry->interface_name + ", or name another object"});
  }
  if (options.incarnation != 0 && options.incarnation != entry->boot) {
    return tl::unexpected(Attempt{name, Detail::Refused,
                                  name + " is served by another process than the one in the "
                                         "reference: the server was restarted; ask for a new "
                                         "reference, or create the proxy by name"});
  }
  return *std::move(entry);
}

tl::expected<Created, CreateError> create(const LabOrWhyNot& lab,
                                          const InterfaceDescription& wanted,
                                          const std::vector<std::string>& names,
                                          const CreateOptions& options) {
  auto created = try_create(lab, wanted, names, options);
  if (created || !lab || options.wait <= Duration::zero()) return created;
  CreateWait waiting(lab, names, options.wait);
  while (!created && waiting.helps(created.error())) {
    waiting.wait();
    created = try_create(lab, wanted, names, options);
  }
  return created;
}

tl::expected<Created, CreateError> try_create(const LabOrWhyNot& lab,
                                              const InterfaceDescription& wanted,
                                              const std::vector<std::string>& names,
                                              const CreateOptions& options) {
  CreateError passed_over;
  for (const auto& name : names) {
    auto session = lab ? open_object(**lab, wanted, name, options)
                       : tl::unexpected(Attempt{name, Detail::NoServer, lab.error().text});
    if (session) {
      return Created{with_failover(**lab, std::move(*session), wanted), std::move(passed_over)};
    }
    passed_over.attempts.push_back(std::move(session.error()));
  }
  if (names.empty()) {
    passed_over.attempts.push_back({"", Detail::NoServer, "create was given no name"});
  }
  return tl::unexpected(std::move(passed_over));
}

}  // namespace session
}  // namespace gecos
