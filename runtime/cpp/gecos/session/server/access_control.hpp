#pragma once

#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/base/result.hpp"
#include "gecos/media/medium.hpp"
#include "gecos/server.hpp"
#include "gecos/session/server/broker_contact.hpp"
#include "gecos/session/server/lab_file_reader.hpp"

namespace gecos::session {

struct Visitors;

/// Decides which users may connect to the objects of one server (access::AccessPolicy), by the lab
/// file (LabFileReader) and the lists of the program. The lab file is read again whenever a client
/// of another user connects, so that an edit acts on the next connection. A decision waits at most
/// 250 ms for the file; after that, it uses the lists that were read last. The registration of a
/// name waits at most 500 ms; after that, it is refused. Thread-safe.
class AccessControl {
 public:
  /// @param lab_file the path of the lab file, as in LabOptions::lab_file
  /// @param contact knows which users the laboratory has revoked
  AccessControl(const std::string& lab_file, Admission admission,
                std::shared_ptr<const BrokerContact> contact);

  /// Reads the lab file. Waits while the file is being written. Fails when the file is still being
  /// written after 3 s, when its file system does not answer for 3 s, or when the file has an error
  /// and no earlier text was correct.
  tl::expected<void, std::string> read();
  /// Requests that the lab file is read again soon, because it may have been edited. Does not wait.
  void reread() { file_.ask(); }

  /// Returns the lists that were read last from the lab file. Each reading makes new lists.
  std::shared_ptr<const access::LabAccess> lists() const { return file_.lists(); }
  /// Returns the zone in which the lab file places an object; an empty text for an object in no
  /// zone. Uses the lists that were read last.
  std::string zone_of(const std::string& object);

  /// Sets the list of the program: from now on the program admits `users` and `hosts`, and no
  /// longer the users and hosts of an earlier call.
  void allow(std::vector<std::string> users, std::vector<std::string> hosts);

  /// Returns the users whom both the program and the lab file admit to `object`
  /// (AccessPolicy::named_by_program). Uses the lists that were read last, and does not wait.
  access::AllowList named_by_program(const std::string& object);

  /// From now on admits the users in `visitors` to the object BROKER as visitors. There are no
  /// visitors while the lab file has a list for BROKER, or while the broker's own program has
  /// called `allow`.
  void receive(std::shared_ptr<const Visitors> visitors);

  /// The decision whether a client may connect to an object, and the rule that led to it.
  struct Judgement {
    bool admitted = true;
    /// True if the client is a program of the server's user or of root, or if neither the kernel
    /// nor a key names another user. Such a client is admitted, and the members below are empty.
    bool own = true;
    access::UserAtHost who{};
    std::string text{};    ///< a sentence for people, like AccessDecision::text
    bool visitor = false;  ///< admitted as a visitor only (access/visitors.hpp)
  };
  /// Decides whether `peer`, a client that connects, is admitted. While the server is out of
  /// contact with the broker, no client whose key has an owner is admitted, because the laboratory
  /// may have revoked the owner.
  Judgement judge(const std::string& object, const media::Peer& peer) noexcept;
  /// Decides whether `peer` may stay connected to the object. Uses the lists that were read last,
  /// and does not wait.
  Judgement judge_again(const std::string& object, const media::Peer& peer) noexcept {
    return judge_by_lists(object, peer);
  }
  /// Returns the user and the host of the client. Returns no value if the client is a program of
  /// the server's user or of root, or if neither the kernel nor a key names another user.
  std::optional<access::UserAtHost> other_user(const media::Peer& peer);
  /// Returns no value if the client may connect to the object with all rights of its status.
  /// Otherwise returns the client's user: the client is a visitor or is refused, and a refused
  /// client may do no more than a visitor. Decides like `judge_again`.
  std::optional<access::UserAtHost> visitor(const std::string& object,
                                            const media::Peer& peer) noexcept;
  /// Returns whether `peer` may end the status of other clients. This holds if `peer` runs as the
  /// user of the server or as root, or if the lab file names its user as an administrator. Uses the
  /// lists that were read last and does not wait, because the caller holds the mutex of an object.
  bool administers(const media::Peer& peer) noexcept;
  /// Decides whether the server `peer` may register an object under `name` with the broker of this
  /// process (access::may_register). While the lab file has an error or is not read within 500 ms,
  /// no server may register, because the correct file might bind the name to another server.
  Judgement judge_registration(const std::string& name, const media::Peer& peer) noexcept;
  /// Decides whether `peer` may report for `source`, for example a door contact of `zone`, that a
  /// person is present (access::may_report). Uses the lists that were read last.
  Judgement judge_report(const std::string& zone, const std::string& source,
                         const media::Peer& peer) noexcept;

 private:
  access::UserAtHost user_of(const media::Peer& peer, const std::string& host);
  Judgement judge_by_lists(const std::string& object, const media::Peer& peer) noexcept;
  /// Decides whether the client `peer` of the user `who`, whom no list admits, is admitted as a
  /// visitor. `refusal`: the text of the decision if the client is refused.
  /// @param server the user of this server, and the server's host
  Judgement judge_visitor(const std::string& object, const media::Peer& peer,
                          const access::UserAtHost& server, const access::UserAtHost& who,
                          std::string refusal) GECOS_REQUIRES(mutex_);
  /// Returns the policy with the lists that were read last from the lab file.
  const access::AccessPolicy& policy() GECOS_REQUIRES(mutex_);
  std::string name_of(std::uint32_t uid);
  bool knows_revoked();  ///< whether `visitors_` knows which users are revoked

  LabFileReader file_;
  const std::shared_ptr<const BrokerContact> contact_;
  Mutex mutex_;
  /// The names of the users who have connected. The server checks each session repeatedly, and must
  /// not ask a directory server of the network each time.
  std::map<std::uint32_t, std::string> names_ GECOS_GUARDED_BY(mutex_);
  access::AccessPolicy policy_ GECOS_GUARDED_BY(mutex_);
  /// The lists that `policy_` uses.
  std::shared_ptr<const access::LabAccess> lists_ GECOS_GUARDED_BY(mutex_);
  /// The users whom the broker admits as visitors; null if there are none.
  std::shared_ptr<const Visitors> visitors_ GECOS_GUARDED_BY(mutex_);
};

}  // namespace gecos::session
