#include "gecos/broker/names.hpp"

#include <gtest/gtest.h>

#include "gecos/access/access_policy.hpp"
#include "gecos/base/whole_characters.hpp"

namespace gecos::broker {
namespace {

Entry object_named(const std::string& name) {
  Entry entry;
  entry.name = name;
  return entry;
}

TEST(Names, OfObjectsAreShortAndHarmless) {
  for (const auto& name : {std::string("RX90"), std::string("left arm"),
                           std::string("Greifer \u00fc"), std::string(access::longest_name, 'A')}) {
    EXPECT_EQ(why_not_listed(object_named(name), {}), "") << name;
  }
  for (const auto& name :
       {std::string(), std::string("BROKER"), std::string("A\n"), std::string("A\x1b[31m"),
        std::string("A\x7f"), std::string(access::longest_name + 1, 'A')}) {
    EXPECT_EQ(why_not_listed(object_named(name), {}),
              "the name of an object has 1 to 256 bytes without control characters, and is not "
              "BROKER; give the object another name")
        << name;
  }
}

TEST(Names, OfAdmittedUsersAndHostsAreShortAndHarmless) {
  const std::string fits(access::longest_name, 'a');
  EXPECT_EQ(why_not_listed(object_named("RX90"), AdmittedNames{1, {fits, "*"}, {fits}}), "");
  for (const auto& [name, fault] :
       {std::pair(fits + "a", "has more than 256 bytes"), std::pair(std::string(), "is empty"),
        std::pair(std::string("a\x1b"), "has a control character")}) {
    for (const auto& admitted :
         {AdmittedNames{1, {"anna", name}, {}}, AdmittedNames{1, {}, {"cell", name}}}) {
      EXPECT_EQ(why_not_listed(object_named("RX90"), admitted),
                "the list of users and hosts that the server of RX90 admits has a name that " +
                    std::string(fault) + "; correct the list in its program or in its lab file");
    }
  }
}

TEST(Names, AreShortenedAfterAWholeCharacter) {
  EXPECT_EQ(whole_characters("RX90", 256), "RX90");
  EXPECT_EQ(whole_characters(std::string(300, 'a'), 256), std::string(256, 'a'));
  const std::string longer = std::string(255, 'a') + "\u00fc" + "b";
  EXPECT_EQ(whole_characters(longer, 256), std::string(255, 'a'));
}

}  // namespace
}  // namespace gecos::broker
