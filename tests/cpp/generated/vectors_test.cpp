#include <gtest/gtest.h>

#include "cases.hpp"

TEST(GeneratedVectors, AValueBecomesTheBytesOfTheVector) {
  ASSERT_GT(cases().size(), 50u);
  for (const Case& each : cases()) {
    EXPECT_EQ(to_hex(each.encode()), each.hex) << each.type << ": " << each.name;
  }
}

TEST(GeneratedVectors, BytesBecomeAnEqualValueAndTheSameBytesAgain) {
  for (const Case& each : cases()) {
    const gecos::Bytes bytes = from_hex(each.hex);
    EXPECT_TRUE(each.equals(bytes)) << each.type << ": " << each.name;
    const Verdict verdict = judge(each.type, bytes);
    ASSERT_TRUE(verdict.bytes) << each.type << ": " << each.name << ": " << verdict.why;
    EXPECT_EQ(to_hex(*verdict.bytes), each.hex);
  }
}

TEST(GeneratedVectors, EveryValuePrintsItsTypeUnlessItIsWrittenByHand) {
  for (const Case& each : cases()) {
    const std::string type(each.type);
    if (type == "robcl::Frame") continue;
    const std::string printed = each.print().substr(0, each.print().find('{'));
    // The type of the event robcl::Manipulator::stood is Manipulator_stood.
    const std::string simple = type.substr(type.rfind(':') + 1);
    EXPECT_EQ(printed, simple == "stood" ? "Manipulator_stood" : simple) << each.print();
    EXPECT_EQ(each.print().back(), '}');
  }
}

TEST(GeneratedVectors, BytesCutAnywhereNeverCrashAndSayWhere) {
  for (const Case& each : cases()) {
    const gecos::Bytes bytes = from_hex(each.hex);
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const Verdict verdict = judge(each.type, gecos::ByteView(bytes.data(), size));
      if (verdict.bytes) continue;  // an older writer's appendable value
      EXPECT_NE(verdict.why.find(" byte "), std::string::npos) << verdict.why;
    }
  }
}
