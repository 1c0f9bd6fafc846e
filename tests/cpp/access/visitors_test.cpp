// Whom the lists of programs make visitors of the broker.
#include "gecos/access/visitors.hpp"

#include <gtest/gtest.h>

#include <random>

namespace gecos::access {
namespace {

const UserAtHost server{"gecos", "cell"};
const UserAtHost anna{"anna", "cell"};
const UserAtHost ben_elsewhere{"ben", "desk"};

ProgramList list_for(std::vector<std::string> users, std::vector<std::string> hosts = {},
                     std::uint64_t number = 1, std::uint64_t boot = 7) {
  return {{server, boot, true}, number, {std::move(users), std::move(hosts), "Server::allow"}};
}

bool shows(const VisitorBook& book, const std::string& name, const UserAtHost& who) {
  return book.seen_by(who).objects.contains(name);
}
std::optional<std::string> object_of(const VisitorBook& book, const UserAtHost& who) {
  return book.object_of(who, [](const ServerLife&) { return true; });
}

TEST(Visitors, AreTheUsersWhomAListNames) {
  EXPECT_TRUE(admits_visitor(list_for({"anna"}), anna));
  EXPECT_FALSE(admits_visitor(list_for({"anna"}), {"anna", "desk"}));
  EXPECT_TRUE(admits_visitor(list_for({"ben"}, {"desk"}), ben_elsewhere));
  EXPECT_TRUE(admits_visitor(list_for({"*"}, {"*"}), ben_elsewhere));
  EXPECT_FALSE(admits_visitor(list_for({}), anna));
}

TEST(Visitors, AreNotThoseWhoNeedNoList) {
  for (const auto& list : {list_for({"*"}, {"*"}), list_for({"gecos", "root"})}) {
    EXPECT_FALSE(admits_visitor(list, server)) << "they would stay when the lab file drops them";
    EXPECT_FALSE(admits_visitor(list, {"root", "cell"}));
  }
  EXPECT_TRUE(admits_visitor(list_for({}, {"desk"}), {"gecos", "desk"}));
}

/// The server and the broker decide by one rule: whom a list makes a visitor, the server admits.
TEST(Visitors, AreAdmittedByTheServerToo) {
  std::mt19937 random(1);
  const std::vector<std::string> names{"anna", "ben", "gecos", "root", "cell", "desk", "*"};
  const auto any = [&] { return names[random() % names.size()]; };
  int visitors = 0;
  for (int i = 0; i < 10000; ++i) {
    const UserAtHost its_server{any(), any()};
    const ProgramList list{{its_server}, 1, {{any(), any()}, {any(), any()}, "Server::allow"}};
    const UserAtHost who{any(), any()};
    if (!admits_visitor(list, who)) continue;
    ++visitors;
    EXPECT_TRUE(AccessPolicy{.program = list.list}.decide(list.server.user, who, "RX90").allowed());
  }
  EXPECT_GT(visitors, 100);
}

TEST(VisitorBook, ShowsTheObjectsWhoseListsNameTheUser) {
  VisitorBook book;
  EXPECT_TRUE(book.set("RX90", list_for({"anna"}), 0));
  EXPECT_TRUE(book.set("LASER", list_for({"carl"}), 0));
  EXPECT_TRUE(shows(book, "RX90", anna));
  EXPECT_FALSE(shows(book, "LASER", anna));
  EXPECT_FALSE(shows(book, "GRIPPER", anna));
  EXPECT_EQ(object_of(book, anna), "RX90");
  EXPECT_EQ(object_of(book, ben_elsewhere), std::nullopt);
}

TEST(VisitorBook, KeepsTheNewestListOfOneServer) {
  VisitorBook book;
  EXPECT_TRUE(book.set("RX90", list_for({"carl"}, {}, 2), 0));
  EXPECT_FALSE(book.set("RX90", list_for({"anna"}, {}, 1), 0)) << "it was sent before";
  EXPECT_FALSE(book.drop_other("RX90", {server, 7, true})) << "it has this list";
  EXPECT_FALSE(book.set("RX90", list_for({"carl"}, {}, 2), 0));
  EXPECT_EQ(object_of(book, anna), std::nullopt);
  EXPECT_TRUE(book.set("RX90", list_for({"anna"}, {}, 3), 0));
  EXPECT_TRUE(shows(book, "RX90", anna));
}

TEST(VisitorBook, DropsTheListWhenAnotherServerTakesTheNameOrNobodyHasIt) {
  VisitorBook book;
  book.set("RX90", list_for({"anna"}, {}, 5), 0);
  EXPECT_TRUE(book.set("RX90", list_for({"carl"}, {}, 1, 8), 0)) << "numbers are of one life";
  EXPECT_FALSE(shows(book, "RX90", anna));
  EXPECT_TRUE(book.drop_other("RX90", {server, 9, true}));
  EXPECT_FALSE(book.names_somebody());
  book.set("RX90", list_for({"anna"}, {}, 1, 9), 0);
  book.keep_only([](const std::string& name) { return name != "RX90"; });
  EXPECT_FALSE(book.names_somebody());
}

TEST(VisitorBook, GivesEachViewANumberThatItNeverHadBefore) {
  VisitorBook book;
  const auto nothing = book.seen_by(anna).view;
  book.set("RX90", list_for({"anna"}), 0);
  const auto first = book.seen_by(anna).view;
  EXPECT_NE(first, nothing);
  book.set("LASER", list_for({"carl"}), 0);
  EXPECT_EQ(book.seen_by(anna).view, first) << "another user sees it";
  book.set("RX90", list_for({}, {}, 2), 0);
  EXPECT_EQ(book.seen_by(anna).view, nothing);
  book.set("RX90", list_for({"anna"}, {}, 3), 0);
  EXPECT_NE(book.seen_by(anna).view, first) << "what happened meanwhile is not for this user";
}

TEST(VisitorBook, KnowsWhoIsRevokedWhileItHasLists) {
  VisitorBook book;
  EXPECT_FALSE(book.knows_revoked());
  book.set("RX90", list_for({"anna"}), 0);
  book.set_revoked({{"", "anna@cell"}});
  EXPECT_TRUE(book.knows_revoked());
  EXPECT_TRUE(book.revoked("", anna));
  EXPECT_FALSE(book.revoked("", ben_elsewhere));
  book.lose_revoked();
  EXPECT_FALSE(book.knows_revoked());
  EXPECT_TRUE(book.revoked("", anna)) << "the last list counts";
  book.set_revoked({});
  EXPECT_FALSE(book.revoked("", anna));
  book.drop_other("RX90", {server, 8, true});
  EXPECT_FALSE(book.knows_revoked()) << "nobody reads the list now";
}

TEST(VisitorBook, ListsThatNameNobodyAreKeptForTheirNumbers) {
  VisitorBook book;
  EXPECT_TRUE(book.set("RX90", list_for({}, {}, 2), 0));
  EXPECT_FALSE(book.names_somebody());
  EXPECT_FALSE(book.set("RX90", list_for({"anna"}, {}, 1), 0)) << "it was sent before";
  EXPECT_EQ(object_of(book, anna), std::nullopt);
}

TEST(VisitorBook, TheListOfARevokedUserOrKeyMakesNobodyAVisitor) {
  const std::string key(64, 'a');
  for (const RevokedUser& revoked : {RevokedUser{"", "gecos@cell"}, RevokedUser{key, ""}}) {
    VisitorBook book;
    ProgramList list = list_for({"anna"});
    list.server.own = false;
    list.server.key = key;
    book.set("RX90", list, 0);
    EXPECT_EQ(object_of(book, anna), "RX90");
    book.set_revoked({revoked});
    EXPECT_EQ(object_of(book, anna), std::nullopt);
    EXPECT_FALSE(shows(book, "RX90", anna));
  }
}

TEST(VisitorBook, AListCountsAsLongAsItsServerDoes) {
  VisitorBook book;
  book.set("RX90", list_for({"anna"}), 0);
  EXPECT_EQ(book.object_of(anna, [](const ServerLife& one) { return one.user != server; }),
            std::nullopt);
}

TEST(VisitorBook, SaysFromWhichChangeOnAUserMaySeeTheChanges) {
  VisitorBook book;
  book.set("RX90", list_for({"anna"}), 4);
  book.set("LASER", list_for({"carl"}), 9);
  EXPECT_EQ(book.seen_by(anna).since, 4u);
  book.set("GRIPPER", list_for({"anna"}), 11);
  EXPECT_EQ(book.seen_by(anna).since, 11u) << "of all these objects at once";
}

}  // namespace
}  // namespace gecos::access
