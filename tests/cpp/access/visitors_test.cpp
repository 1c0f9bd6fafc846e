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
  return {server, boot, number, {std::move(users), std::move(hosts), "Server::allow"}};
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
    const ProgramList list{its_server, 1, 1, {{any(), any()}, {any(), any()}, "Server::allow"}};
    const UserAtHost who{any(), any()};
    if (!admits_visitor(list, who)) continue;
    ++visitors;
    EXPECT_TRUE(AccessPolicy{.program = list.list}.decide(list.server, who, "RX90").allowed());
  }
  EXPECT_GT(visitors, 100);
}

TEST(VisitorBook, ShowsTheObjectsWhoseListsNameTheUser) {
  VisitorBook book;
  EXPECT_TRUE(book.set("RX90", 7, list_for({"anna"})));
  EXPECT_TRUE(book.set("LASER", 7, list_for({"carl"})));
  EXPECT_TRUE(book.shows("RX90", anna));
  EXPECT_FALSE(book.shows("LASER", anna));
  EXPECT_FALSE(book.shows("GRIPPER", anna));
  EXPECT_EQ(book.object_of(anna), "RX90");
  EXPECT_EQ(book.object_of(ben_elsewhere), std::nullopt);
}

TEST(VisitorBook, KeepsTheNewestListOfOneServer) {
  VisitorBook book;
  EXPECT_TRUE(book.set("RX90", 7, list_for({"carl"}, {}, 2)));
  EXPECT_FALSE(book.set("RX90", 7, list_for({"anna"}, {}, 1))) << "it was sent before";
  EXPECT_FALSE(book.set("RX90", 7, std::nullopt)) << "so was this";
  EXPECT_FALSE(book.set("RX90", 7, list_for({"carl"}, {}, 2)));
  EXPECT_EQ(book.object_of(anna), std::nullopt);
  EXPECT_TRUE(book.set("RX90", 7, list_for({"anna"}, {}, 3)));
  EXPECT_TRUE(book.shows("RX90", anna));
}

TEST(VisitorBook, DropsTheListWhenAnotherServerTakesTheNameOrNobodyHasIt) {
  VisitorBook book;
  book.set("RX90", 7, list_for({"anna"}, {}, 5));
  EXPECT_TRUE(book.set("RX90", 8, list_for({"carl"}, {}, 1, 8))) << "numbers are of one life";
  EXPECT_FALSE(book.shows("RX90", anna));
  EXPECT_TRUE(book.set("RX90", 9, std::nullopt));
  EXPECT_TRUE(book.empty());
  book.set("RX90", 9, list_for({"anna"}, {}, 1, 9));
  book.keep_only([](const std::string& name) { return name != "RX90"; });
  EXPECT_TRUE(book.empty());
}

TEST(VisitorBook, GivesEachViewANumberThatItNeverHadBefore) {
  VisitorBook book;
  const auto nothing = book.view_of(anna);
  book.set("RX90", 7, list_for({"anna"}));
  const auto first = book.view_of(anna);
  EXPECT_NE(first, nothing);
  book.set("LASER", 7, list_for({"carl"}));
  EXPECT_EQ(book.view_of(anna), first) << "another user sees it";
  book.set("RX90", 7, list_for({}, {}, 2));
  EXPECT_EQ(book.view_of(anna), nothing);
  book.set("RX90", 7, list_for({"anna"}, {}, 3));
  EXPECT_NE(book.view_of(anna), first) << "what happened meanwhile is not for this user";
}

TEST(VisitorBook, KnowsWhoIsRevokedWhileItHasLists) {
  VisitorBook book;
  EXPECT_FALSE(book.knows_revoked());
  book.set("RX90", 7, list_for({"anna"}));
  book.revoke(std::vector<RevokedUser>{{"", "anna@cell"}});
  EXPECT_TRUE(book.knows_revoked());
  EXPECT_TRUE(book.revoked("", anna));
  EXPECT_FALSE(book.revoked("", ben_elsewhere));
  book.revoke(std::nullopt);
  EXPECT_FALSE(book.knows_revoked());
  EXPECT_TRUE(book.revoked("", anna)) << "the last list counts";
  book.revoke(std::vector<RevokedUser>{});
  EXPECT_FALSE(book.revoked("", anna));
  book.set("RX90", 8, std::nullopt);
  EXPECT_FALSE(book.knows_revoked()) << "nobody reads the list now";
}

}  // namespace
}  // namespace gecos::access
