// Who is met over lcm: users and the keys that they admit.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "gecos/base/user_and_host.hpp"
#include "gecos/media/sealed/keys.hpp"
#include "lcm_recorder.hpp"
#include "media_under_test.hpp"

namespace gecos::media {
namespace {

/// Two users: each has a key directory.
class LcmUsers : public testing::Test {
 protected:
  crypto::PublicKey key_of(const std::string& whom) {
    return SealedKeys::open(options(whom).key_directory).value()->own.public_key();
  }
  void admit(const std::string& whom, const std::string& by) {
    const auto key = key_of(whom);
    ASSERT_NE(SealedKeys::open(options(by).key_directory).value(), nullptr);
    const std::string file = "/" + key.to_string() + ".public";
    std::filesystem::copy(options(whom).key_directory + file, options(by).key_directory + file);
  }
  /// Writes in the directory of `by` whose key that of `whom` is.
  void name(const std::string& whom, const std::string& owner, const std::string& by) {
    const auto key = key_of(whom);
    const std::string file = options(by).key_directory + "/" + key.to_string() + ".owner";
    std::ofstream(file) << owner << "\n";
    ASSERT_EQ(::chmod(file.c_str(), 0600), 0);
  }
  void remove(const std::string& whom, const std::string& by) {
    const auto key = key_of(whom);
    for (const char* const kind : {".public", ".owner"}) {
      std::filesystem::remove(options(by).key_directory + "/" + key.to_string() + kind);
    }
  }
  LcmOptions options(const std::string& whose) { return with_keys(directory_, whose); }
  /// What the client says of a server that it cannot meet.
  std::string trouble(Acceptor& acceptor, Connection& client, const std::string& expected) {
    const TimePoint end = too_late();
    while (client.loss_text().find(expected) == std::string::npos &&
           std::chrono::steady_clock::now() < end) {
      client.beat();
      EXPECT_EQ(client.loss(), Loss::None);
      EXPECT_EQ(acceptor.accept(), nullptr);
    }
    return client.loss_text();
  }

  const ScratchDirectory directory_;
  const std::unique_ptr<Medium> ada_ = make_lcm(options("ada"));
  const std::unique_ptr<Medium> bob_ = make_lcm(options("bob"));
};

TEST_F(LcmUsers, AServerWhoseKeyIsNotAdmittedIsRefusedAtOnce) {
  const auto acceptor = ada_->listen("RX90", false).value();
  const auto refused = bob_->connect(acceptor->address());
  ASSERT_FALSE(refused);
  const auto key = SealedAddress::parse(acceptor->address())->key.value();
  EXPECT_NE(refused.error().text.find("the key " + key.short_name() + " is not admitted here"),
            std::string::npos)
      << refused.error().text;
  EXPECT_NE(refused.error().text.find(options("bob").key_directory), std::string::npos);
}

TEST_F(LcmUsers, AClientWhoseKeyIsNotAdmittedIsNotMetAndToldWhatToDo) {
  admit("ada", "bob");
  const auto acceptor = ada_->listen("RX90", false).value();
  auto client = std::move(*bob_->connect(acceptor->address()));
  ASSERT_TRUE(client->send(bytes_of("let me in"), {}));
  for (int i = 0; i < 20; ++i) EXPECT_EQ(acceptor->accept(), nullptr);
  const std::string text = trouble(*acceptor, *client, "the server does not admit our key");
  EXPECT_NE(text.find(options("bob").key_directory + "/"), std::string::npos) << text;
  EXPECT_NE(text.find("gecos keys add FILE " + user_name(::geteuid()) + "@" + host_name() + "`"),
            std::string::npos)
      << "a key without an owner would be admitted past all lists: " << text;
  admit("bob", "ada");
  EXPECT_NE(wait_for_client(*acceptor, *client), nullptr)
      << "from now on, with the same connection";
}

TEST_F(LcmUsers, AKeyFileThatIsDamagedIsNamedToWhoAdmitsByIt) {
  admit("ada", "bob");
  const auto acceptor = ada_->listen("RX90", false).value();
  const auto key = SealedAddress::parse(acceptor->address())->key.value();
  const std::string file = options("bob").key_directory + "/" + key.to_string() + ".public";
  std::filesystem::resize_file(file, 40);
  const auto refused = bob_->connect(acceptor->address());
  ASSERT_FALSE(refused);
  EXPECT_NE(refused.error().text.find("is not admitted here: " + file +
                                      ": is cut short: copy it again, or remove it"),
            std::string::npos)
      << refused.error().text;
}

TEST_F(LcmUsers, WhoMeetsNobodyIsToldHowFarItsPacketsGo) {
  const auto said = [&](int ttl) {
    LcmOptions options = this->options("bob");
    options.ttl = ttl;
    const auto medium = make_lcm(options);
    return (*medium->connect(medium->well_known_address("NOBODY")))->loss_text();
  };
  EXPECT_NE(said(0).find("GECOS_LCM_TTL is 0, so packets of this program stay on this host"),
            std::string::npos)
      << said(0);
  EXPECT_NE(said(1).find("only if its own GECOS_LCM_TTL is 1 or more"), std::string::npos)
      << said(1);
}

TEST_F(LcmUsers, AnImpostorAtAWellKnownPlaceIsRefused) {
  const auto impostor = ada_->listen("BROKER", true).value();
  auto client = std::move(*bob_->connect(bob_->well_known_address("BROKER")));
  const std::string text =
      trouble(*impostor, *client, "does not admit the key of the server that answered");
  EXPECT_NE(text.find("is not admitted here"), std::string::npos) << text;
}

TEST_F(LcmUsers, AKeyDirectoryThatOthersMayReadIsAnErrorThatSaysSo) {
  ASSERT_TRUE(std::filesystem::create_directory(options("eve").key_directory));
  ASSERT_EQ(::chmod(options("eve").key_directory.c_str(), 0755), 0);
  const auto medium = make_lcm(options("eve"));
  const auto acceptor = medium->listen("RX90", false);
  ASSERT_FALSE(acceptor);
  EXPECT_NE(acceptor.error().text.find("lcm needs a key"), std::string::npos)
      << acceptor.error().text;
  EXPECT_NE(acceptor.error().text.find("chmod 700"), std::string::npos) << acceptor.error().text;
  ASSERT_EQ(::chmod(options("eve").key_directory.c_str(), 0700), 0);
  EXPECT_TRUE(medium->listen("RX90", false)) << "mended, it works without another medium";
}

TEST_F(LcmUsers, EachOfTwoUsersWhoAdmitEachOtherProvesItsKey) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  End client(std::move(*bob_->connect(acceptor->address())));
  End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
  ASSERT_NE(server.connection, nullptr);
  EXPECT_TRUE(
      server.connection->peer().description.starts_with("key " + key_of("bob").short_name()));
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");
}

TEST_F(LcmUsers, TheServerDecidesByTheOwnerOfTheKeyThatAClientHasProved) {
  admit("ada", "bob");
  admit("bob", "ada");
  name("bob", "bob@desk", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  std::string asked;
  acceptor->admit_by([&](const Peer& peer) -> std::string {
    EXPECT_FALSE(peer.uid);
    asked += peer.user + " of " + peer.host + ". ";
    EXPECT_EQ(peer.key, key_of("bob").to_string());
    return peer.host == "desk" ? "" : "only desk is admitted";
  });
  End client(std::move(*bob_->connect(acceptor->address())));
  End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
  ASSERT_NE(server.connection, nullptr);
  EXPECT_EQ(server.connection->peer().user, "bob");
  EXPECT_EQ(server.connection->peer().host, "desk");
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");

  name("bob", "bob@bench", "ada");
  const auto refused = std::move(*bob_->connect(acceptor->address()));
  const TimePoint end = too_late();
  while (refused->loss() == Loss::None && std::chrono::steady_clock::now() < end) {
    EXPECT_EQ(acceptor->accept(), nullptr);
    refused->beat();
  }
  EXPECT_EQ(refused->loss(), Loss::Refused);
  EXPECT_EQ(refused->loss_text(), "only desk is admitted");
  EXPECT_EQ(asked, "bob of desk. bob of bench. ");
  EXPECT_NE(server.connection->later_refusal()().find("has changed since the client connected"),
            std::string::npos);
}

TEST_F(LcmUsers, RefusedClientsOccupyNoDescriptorOfTheServer) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  acceptor->admit_by([](const Peer&) -> std::string { return "nobody is admitted"; });
  const auto refuse_one = [&] {
    const auto client = std::move(*bob_->connect(acceptor->address()));
    const TimePoint end = too_late();
    while (client->loss() == Loss::None && std::chrono::steady_clock::now() < end) {
      EXPECT_EQ(acceptor->accept(), nullptr);
      client->beat();
    }
    EXPECT_EQ(client->loss_text(), "nobody is admitted");
  };
  refuse_one();
  const std::size_t before = open_descriptors();
  for (int client = 0; client < 10; ++client) refuse_one();
  EXPECT_EQ(open_descriptors(), before);
}

TEST_F(LcmUsers, TheServersOwnKeyAndAKeyWithoutAnOwnerAreTheServersUser) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  std::string asked;
  acceptor->admit_by([&](const Peer& peer) -> std::string {
    asked += peer.key;
    return peer.user.empty() ? "" : "nobody else is admitted";
  });
  for (Medium* const medium : {ada_.get(), bob_.get()}) {
    const auto client = std::move(*medium->connect(acceptor->address()));
    const auto server = wait_for_client(*acceptor, *client);
    ASSERT_NE(server, nullptr);
    EXPECT_EQ(server->peer().user, "");
    const auto refusal = server->later_refusal();
    EXPECT_EQ(refusal == nullptr, medium == ada_.get()) << "the own key stays admitted";
    if (refusal) {
      EXPECT_EQ(refusal(), "");
    }
  }
  EXPECT_EQ(asked, key_of("bob").to_string()) << "a key without an owner may be revoked";
}

TEST_F(LcmUsers, AKeyThatIsRemovedIsRevoked) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  const auto client = std::move(*bob_->connect(acceptor->address()));
  const auto server = wait_for_client(*acceptor, *client);
  ASSERT_NE(server, nullptr);
  const auto refusal = server->later_refusal();
  EXPECT_EQ(refusal(), "");
  remove("bob", "ada");
  EXPECT_NE(refusal().find("is not admitted here"), std::string::npos);
  admit("bob", "ada");
  EXPECT_EQ(refusal(), "");
}

TEST_F(LcmUsers, AClientGoesOnWithAServerWhoseKeyWasRemovedAndMeetsItNoMore) {
  admit("ada", "bob");
  admit("bob", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  End client(std::move(*bob_->connect(acceptor->address())));
  End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
  ASSERT_NE(server.connection, nullptr);
  remove("ada", "bob");
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");
  EXPECT_FALSE(bob_->connect(acceptor->address()));
}

TEST_F(LcmUsers, AKeyThatIsRemovedDuringTheHandshakeMakesNoConnection) {
  admit("ada", "bob");
  admit("bob", "ada");
  name("bob", "bob@desk", "ada");
  const auto acceptor = ada_->listen("RX90", false).value();
  const auto late = std::move(*bob_->connect(acceptor->address()));
  const TimePoint end = too_late();
  while (late->loss_text() != "the server accepted us, but has sent no packet since") {
    ASSERT_LT(std::chrono::steady_clock::now(), end) << late->loss_text();
    ASSERT_EQ(acceptor->accept(), nullptr);
    EXPECT_EQ(late->loss(), Loss::None);  // reads the answer, and sends the first sealed packet
  }
  remove("bob", "ada");
  late->beat();
  const auto own = std::move(*ada_->connect(acceptor->address()));
  const auto server = wait_for_client(*acceptor, *own);
  ASSERT_NE(server, nullptr);
  const auto ada = SealedKeys::open(options("ada").key_directory).value()->own.public_key();
  EXPECT_TRUE(server->peer().description.starts_with("key " + ada.short_name()))
      << "the first client that the server met is " << server->peer().description;
  EXPECT_EQ(acceptor->accept(), nullptr);
}

TEST_F(LcmUsers, BothSidesMayBeginAgain) {
  for (int life = 0; life < 3; ++life) {
    const auto acceptor = ada_->listen("BROKER", true).value();
    for (int client_life = 0; client_life < 3; ++client_life) {
      End client(std::move(*ada_->connect(acceptor->address())));
      End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
      ASSERT_NE(server.connection, nullptr);
      ASSERT_TRUE(client.send("hello"));
      ASSERT_EQ(server.receive(), "hello");
      if (client_life == 1) {
        client.connection.reset();
        EXPECT_EQ(server.wait_for_loss(), Loss::Closed);
      } else {
        server.connection.reset();
        EXPECT_EQ(client.wait_for_loss(), Loss::Closed);
      }
    }
  }
}

TEST_F(LcmUsers, ARecordingPlayedToTheNextLifeOfAServerMakesNoConnection) {
  std::vector<Bytes> recorded;
  const SealedAddress place = SealedAddress::parse(ada_->well_known_address("BROKER")).value();
  Recorder stranger(place.port, place.channel);
  {
    const auto acceptor = ada_->listen("BROKER", true).value();
    End client(std::move(*ada_->connect(acceptor->address())));
    End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
    ASSERT_TRUE(client.send("move"));
    ASSERT_EQ(server.receive(), "move");
    ASSERT_FALSE(stranger.of(DatagramKind::Sealed).empty());
    recorded = stranger.all();
  }
  const auto acceptor = ada_->listen("BROKER", true).value();
  for (const Bytes& datagram : recorded) stranger.say(place.channel, datagram);
  End client(std::move(*ada_->connect(acceptor->address())));
  End server(wait_for_client(*acceptor, *client.connection), acceptor.get());
  ASSERT_TRUE(client.send("hello"));
  EXPECT_EQ(server.receive(), "hello");
  EXPECT_TRUE(server.others.empty());
}

}  // namespace
}  // namespace gecos::media
