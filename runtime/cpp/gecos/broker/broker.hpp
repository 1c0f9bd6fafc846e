#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "gecos/base/mutex.hpp"
#include "gecos/broker/directory.hpp"
#include "gecos/broker_server.hpp"
#include "gecos/serve.hpp"
#include "gecos/server.hpp"

namespace gecos::broker {

/// The broker as an object: `gecos::serve(lab, {broker.serving()})` serves it at this host's
/// well-known address; `broker.serve(server)` does so in a program that has a server of its own.
/// The broker removes an entry when the session that enlisted the entry ends. In its first second
/// the broker prefers objects that were served before the broker started (directory.hpp).
class Broker final : public BrokerServant {
 public:
  /// The broker as an object of `gecos::serve`. Its first second begins now.
  Serving serving(std::vector<media::Kind> media = {});
  /// Serves this broker. Fails when this host has a broker already.
  tl::expected<void, ServeError> serve(Server& server, std::vector<media::Kind> media = {});

  void gecos_dispatch(IncomingCall call) override;
  void gecos_session_ended(std::uint64_t session) override;

 protected:
  Result<std::optional<double>> enlist(const Entry& what, double served_for) override;
  Result<void> withdraw(const std::string& name) override;
  Result<Entry> lookup(const std::string& name) override;
  Result<std::vector<Entry>> list() override;
  Result<std::vector<SilentObject>> silent() override;

 private:
  struct {
    std::uint64_t session = 0;
    std::uint64_t incarnation = 0;
  } calling_;    ///< the client of the current call; handlers run one at a time
  Mutex mutex_;  ///< needed because calls run on one thread and sessions end on another
  Directory directory_ GECOS_GUARDED_BY(mutex_){SystemClock().since_boot()};
};

}  // namespace gecos::broker
