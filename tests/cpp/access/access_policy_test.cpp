// Who may connect, also against a model that lists all who are admitted.

#include "gecos/access/access_policy.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace gecos::access {
namespace {

const UserAtHost lab_user{"gecos", "cell"};
const UserAtHost anna_here{"anna", "cell"};
const UserAtHost bob_here{"bob", "cell"};

AllowList list_for(std::vector<std::string> users, std::vector<std::string> hosts = {},
                   std::string place = "[allow] in lab.toml:3") {
  return {std::move(users), std::move(hosts), std::move(place)};
}

TEST(AccessPolicy, AdmitsOnlyTheUserOfTheServerAndRootOfItsHostByDefault) {
  const AccessPolicy policy;
  EXPECT_EQ(policy.decide(lab_user, lab_user, "RX90").rule, AccessRule::OwnUser);
  EXPECT_EQ(policy.decide(lab_user, {"root", "cell"}, "RX90").rule, AccessRule::Root);
  EXPECT_EQ(policy.decide(lab_user, anna_here, "RX90").rule, AccessRule::NobodyNamed);
  EXPECT_FALSE(policy.decide(lab_user, {"gecos", "bench1"}, "RX90").allowed());
  EXPECT_FALSE(policy.decide(lab_user, {"root", "bench1"}, "RX90").allowed());
}

TEST(AccessPolicy, RefusesWithWordsThatSayWhatToChangeWhere) {
  EXPECT_EQ(AccessPolicy{}.decide(lab_user, bob_here, "RX90").text,
            "RX90 refuses user bob of host cell: RX90 admits only user gecos of host cell; write "
            "users = [\"bob\"] below [allow] in a lab file (GECOS_LAB_FILE)");
  EXPECT_EQ(
      (AccessPolicy{.lab = {.file = "/etc/gecos/lab.toml"}}
           .decide(lab_user, {"gecos", "bench1"}, "RX90")
           .text),
      "RX90 refuses user gecos of host bench1: RX90 admits only user gecos of host cell; write "
      "hosts = [\"bench1\"] below [allow] in /etc/gecos/lab.toml");
  const AccessPolicy named{.lab = {.file = "lab.toml", .general = list_for({"anna"})}};
  EXPECT_EQ(named.decide(lab_user, bob_here, "RX90").text,
            "RX90 refuses user bob of host cell: [allow] in lab.toml:3 does not name user bob; add "
            "\"bob\" to its users");
  EXPECT_EQ(
      named.decide(lab_user, {"anna", "bench1"}, "RX90").text,
      "RX90 refuses user anna of host bench1: [allow] in lab.toml:3 does not name host bench1; "
      "add \"bench1\" to its hosts");
  EXPECT_EQ(named.decide(lab_user, anna_here, "RX90").text,
            "RX90 admits user anna of host cell: named by [allow] in lab.toml:3");
}

TEST(AccessPolicy, AnInsecureServerAdmitsEveryUserOfEveryHostAndNoFurtherAdministrator) {
  const AccessPolicy policy{
      .program = list_for({"carl"}),
      .lab = {.file = "lab.toml", .general = list_for({"carl"}), .admin = list_for({"carl"})},
      .insecure = true};
  for (const UserAtHost& who : {bob_here, UserAtHost{"dora", "bench1"}, UserAtHost{"root", "x"}}) {
    const AccessDecision decision = policy.decide(lab_user, who, "RX90");
    EXPECT_EQ(decision.rule, AccessRule::Insecure);
    EXPECT_TRUE(decision.allowed());
    EXPECT_FALSE(policy.administers(lab_user, who));
  }
  EXPECT_EQ(
      policy.decide(lab_user, bob_here, "RX90").text,
      "RX90 admits user bob of host cell: the server of the object was started with --insecure, "
      "so no list of users counts");
  EXPECT_EQ(policy.decide(lab_user, lab_user, "RX90").rule, AccessRule::OwnUser);
}

TEST(MayReport, TheOwnerOfASourceAloneAndOtherwiseTheUserOfTheZone) {
  LabAccess lab;
  lab.sources["CELL"]["DOOR"] = {{"door", "gate"}, "[objects.CELL.sources] in lab.toml:2"};
  const Reporter owner{UserAtHost{"door", "gate"}}, own{UserAtHost{"robcl", "cell"}, true},
      other{UserAtHost{"ben", "gate"}}, unknown{std::nullopt, true};
  EXPECT_TRUE(may_report(lab, "CELL", "DOOR", owner).allowed);
  for (const Reporter& one : {own, other, unknown}) {
    EXPECT_FALSE(may_report(lab, "CELL", "DOOR", one).allowed);
  }
  for (const auto& [zone, source] : {std::pair("CELL", "GRIP"), std::pair("HALL", "DOOR")}) {
    EXPECT_TRUE(may_report(lab, zone, source, own).allowed);
    EXPECT_TRUE(may_report(lab, zone, source, unknown).allowed);
    EXPECT_FALSE(may_report(lab, zone, source, owner).allowed);
  }
  EXPECT_EQ(may_report(lab, "CELL", "DOOR", other).text,
            "a program of user ben of host gate may not report for DOOR of CELL: "
            "[objects.CELL.sources] in lab.toml:2 binds this source to user door of host gate; "
            "report as this user, or name another user in that table");
  EXPECT_EQ(may_report(lab, "CELL", "GRIP", other).text,
            "a program of user ben of host gate may not report for GRIP of CELL: no "
            "[objects.CELL.sources] of a lab file binds this source, so only the user of the "
            "zone's server may report for it; write GRIP = \"ben@gate\" under "
            "[objects.CELL.sources]");
}

TEST(MayRegister, OnlyTheOwnerOfANameThatTheFileBinds) {
  const LabAccess lab{.file = "lab.toml",
                      .names = {{"RX90", {{"robcl", "cell"}, "[names] in lab.toml:3"}}}};
  EXPECT_TRUE(may_register(lab, "RX90", UserAtHost{"robcl", "cell"}).allowed);
  for (const UserAtHost& other :
       {UserAtHost{"robcl", "desk"}, {"anna", "cell"}, {"root", "cell"}, lab_user, {"", ""}}) {
    EXPECT_FALSE(may_register(lab, "RX90", other).allowed) << other.user << "@" << other.host;
    EXPECT_TRUE(may_register(lab, "LDS", other).allowed);
  }
  EXPECT_FALSE(may_register(lab, "RX90", std::nullopt).allowed);
  EXPECT_TRUE(may_register(lab, "LDS", std::nullopt).allowed);
}

TEST(MayRegister, SaysTheRuleAndWhatToDo) {
  const LabAccess lab{.file = "lab.toml",
                      .names = {{"RX90", {{"robcl", "cell"}, "[names] in lab.toml:3"}}}};
  EXPECT_EQ(may_register(lab, "RX90", UserAtHost{"ben", "desk"}).text,
            "a server of user ben of host desk may not register RX90: [names] in lab.toml:3 binds "
            "this name to user robcl of host cell; serve the object as this user, or write RX90 = "
            "\"ben@desk\" in that table");
  EXPECT_EQ(may_register(lab, "RX90", std::nullopt).text,
            "a server whose key has no owner may not register RX90: [names] in lab.toml:3 binds "
            "this name to user robcl of host cell; name the owner of the key at the broker: gecos "
            "keys add FILE robcl@cell");
}

TEST(AccessPolicy, NamesAdministrators) {
  const UserAtHost user_elsewhere{"gecos", "bench1"};
  const AccessPolicy nobody{.lab = {.file = "lab.toml", .general = list_for({"anna"})}};
  EXPECT_TRUE(nobody.administers(lab_user, lab_user));
  EXPECT_FALSE(nobody.administers(lab_user, user_elsewhere));
  EXPECT_FALSE(nobody.administers(lab_user, anna_here)) << "who may connect is no administrator";
  const AccessPolicy anna{.lab = {.file = "lab.toml", .admin = list_for({"anna"})}};
  EXPECT_TRUE(anna.administers(lab_user, anna_here));
  EXPECT_FALSE(anna.administers(lab_user, {"anna", "bench1"})) << "of this host alone";
  EXPECT_FALSE(anna.administers(lab_user, bob_here));
}

TEST(AccessPolicy, NeedsTheListOfTheProgramAndThatOfTheLabFileIfBothExist) {
  const AccessPolicy policy{.program = list_for({"anna", "bob"}, {}, "Server::allow"),
                            .lab = {.file = "lab.toml", .general = list_for({"bob", "eve"})}};
  EXPECT_EQ(policy.decide(lab_user, anna_here, "RX90").rule, AccessRule::UserNotNamed);
  EXPECT_EQ(policy.decide(lab_user, bob_here, "RX90").text,
            "RX90 admits user bob of host cell: named by Server::allow and [allow] in lab.toml:3");
  EXPECT_FALSE(policy.decide(lab_user, {"eve", "cell"}, "RX90").allowed());
}

TEST(AccessPolicy, TakesTheListOfAnObjectInPlaceOfTheGeneralOne) {
  const AccessPolicy policy{.lab = {.file = "lab.toml",
                                    .general = list_for({"anna"}),
                                    .objects = {{"RX90", list_for({"bob"})}}}};
  EXPECT_FALSE(policy.decide(lab_user, anna_here, "RX90").allowed());
  EXPECT_TRUE(policy.decide(lab_user, bob_here, "RX90").allowed());
  EXPECT_TRUE(policy.decide(lab_user, anna_here, "LDS").allowed());
  EXPECT_FALSE(policy.decide(lab_user, bob_here, "LDS").allowed());
}

TEST(AccessPolicy, LetsEverybodyAskTheBrokerWhoIsAdmittedToAnObject) {
  AccessPolicy policy{.lab = {.file = "lab.toml",
                              .general = list_for({"anna"}),
                              .objects = {{"RX90", list_for({"bob"})}}}};
  EXPECT_TRUE(policy.decide(lab_user, anna_here, "BROKER").allowed());
  EXPECT_TRUE(policy.decide(lab_user, bob_here, "BROKER").allowed());
  EXPECT_FALSE(policy.decide(lab_user, {"eve", "cell"}, "BROKER").allowed());
  policy.lab.objects["BROKER"] = list_for({"anna"});
  EXPECT_FALSE(policy.decide(lab_user, bob_here, "BROKER").allowed());
}

// The model: sets of all users that are admitted

using Admitted = std::set<std::pair<std::string, std::string>>;
const std::vector<std::string> all_users{"gecos", "root", "anna", "bob"};
const std::vector<std::string> all_hosts{"cell", "bench1", "desk"};

/// All that a list admits: each of its users on each of its hosts.
Admitted admitted_by(const AllowList& list) {
  const auto expanded = [](const std::vector<std::string>& names, const auto& all,
                           const std::string& own) {
    std::set<std::string> found{own};
    for (const auto& name : names) {
      if (name == "*") found.insert(all.begin(), all.end());
      found.insert(name);
    }
    return found;
  };
  Admitted admitted;
  for (const auto& user : expanded(list.users, all_users, lab_user.user)) {
    for (const auto& host : expanded(list.hosts, all_hosts, lab_user.host)) {
      admitted.emplace(user, host);
    }
  }
  return admitted;
}

Admitted both(const std::vector<Admitted>& sets) {
  Admitted common = sets.front();
  for (const auto& one : sets)
    std::erase_if(common, [&](const auto& who) { return !one.count(who); });
  return common;
}

/// All that the lists of the lab file admit to `object`; no value when no list is about it.
std::optional<Admitted> admitted_by(const LabAccess& lab, const std::string& object) {
  if (lab.objects.count(object)) return admitted_by(lab.objects.at(object));
  std::vector<const AllowList*> lists;
  if (lab.general) lists.push_back(&*lab.general);
  if (object == "BROKER") {
    for (const auto& [name, list] : lab.objects) lists.push_back(&list);
  }
  if (lists.empty()) return std::nullopt;
  Admitted any;
  for (const auto* list : lists) any.merge(admitted_by(*list));
  return any;
}

Admitted model(const AccessPolicy& policy, const std::string& object) {
  std::vector<Admitted> limits;
  if (policy.program) limits.push_back(admitted_by(*policy.program));
  if (auto in_file = admitted_by(policy.lab, object)) limits.push_back(*in_file);
  Admitted admitted;
  if (!limits.empty()) admitted = both(limits);
  admitted.emplace(lab_user.user, lab_user.host);
  admitted.emplace("root", lab_user.host);
  return admitted;
}

class RandomPolicies {
 public:
  AccessPolicy next() {
    AccessPolicy policy;
    if (chance(3)) policy.program = list();
    if (chance(2)) policy.lab.general = list();
    for (const auto* object : {"RX90", "LDS", "BROKER"}) {
      if (chance(3)) policy.lab.objects[object] = list();
    }
    return policy;
  }

 private:
  bool chance(unsigned of) { return random_() % of == 0; }
  std::vector<std::string> some(const std::vector<std::string>& all) {
    if (chance(6)) return {"*"};
    std::vector<std::string> names;
    for (const auto& name : all) {
      if (chance(3)) names.push_back(name);
    }
    return names;
  }
  AllowList list() { return {some(all_users), some(all_hosts), "a list"}; }

  std::mt19937_64 random_{20261127};
};

TEST(AccessPolicy, AdmitsWhomTheModelAdmitsInAHundredThousandPolicies) {
  RandomPolicies policies;
  std::size_t refused = 0, named = 0;
  const std::vector<std::string> objects{"RX90", "GRIPPER", "BROKER"};
  for (std::size_t i = 0; i < 100'000; ++i) {
    const AccessPolicy policy = policies.next();
    const std::string& object = objects[i / 12 % 3];
    const UserAtHost who{all_users[i % 4], all_hosts[i / 4 % 3]};
    const AccessDecision decision = policy.decide(lab_user, who, object);
    ASSERT_EQ(decision.allowed(), model(policy, object).contains({who.user, who.host}))
        << "policy " << i << ": " << decision.text;
    refused += !decision.allowed();
    named += decision.rule == AccessRule::Named;
  }
  EXPECT_GT(refused, 20'000u) << "the policies must not be too simple";
  EXPECT_GT(named, 10'000u);
}

TEST(WhomBothAdmit, AreTheNamesInBothListsAndAStarStandsForAll) {
  const auto users_of = [](std::vector<std::string> one, std::vector<std::string> other) {
    return whom_both_admit(list_for(std::move(one)), list_for(std::move(other))).users;
  };
  using Names = std::vector<std::string>;
  EXPECT_EQ(users_of({"anna", "bob"}, {"bob", "carl"}), Names{"bob"});
  EXPECT_EQ(users_of({"anna"}, {"bob"}), Names{});
  EXPECT_EQ(users_of({"anna"}, {}), Names{});
  EXPECT_EQ(users_of({"*"}, {"anna", "bob"}), (Names{"anna", "bob"}));
  EXPECT_EQ(users_of({"anna", "bob"}, {"*"}), (Names{"anna", "bob"}));
  EXPECT_EQ(users_of({"anna", "*"}, {"bob"}), Names{"bob"})
      << "a program may name more than a star";
  EXPECT_EQ(users_of({"*"}, {"*"}), Names{"*"});
  EXPECT_EQ(users_of({"anna@desk"}, {"anna"}), Names{}) << "a list names users and hosts apart";
  const auto both =
      whom_both_admit(list_for({"anna"}, {"*"}, "one"), list_for({"anna"}, {"desk"}, "other"));
  EXPECT_EQ(both.hosts, Names{"desk"});
  EXPECT_EQ(both.place, "one and other");
}

TEST(WhomBothAdmit, AreNamedByTheProgramAndAdmittedByThePolicyInAHundredThousandPolicies) {
  RandomPolicies policies;
  std::size_t named = 0, narrower = 0;
  for (std::size_t i = 0; i < 100'000; ++i) {
    AccessPolicy policy = policies.next();
    policy.insecure = i % 7 == 0;
    const std::string object = i / 12 % 2 == 0 ? "RX90" : "GRIPPER";
    const UserAtHost who{all_users[i % 4], all_hosts[i / 4 % 3]};
    const auto by = [&](const AllowList& list) {
      return decide_by(list, lab_user, who) == AccessRule::Named;
    };
    const bool by_program = policy.program && by(*policy.program);
    const bool expected = by_program && policy.decide(lab_user, who, object).allowed();
    ASSERT_EQ(by(policy.named_by_program(object)), expected) << "policy " << i;
    named += expected;
    narrower += by_program && !expected;
  }
  EXPECT_GT(named, 1'000u) << "the policies must not be too simple";
  EXPECT_GT(narrower, 1'000u);
}

}  // namespace
}  // namespace gecos::access
