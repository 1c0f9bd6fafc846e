#include "gecos/access/proof.hpp"

#include <gtest/gtest.h>

#include <utility>

namespace gecos::access {
namespace {

TEST(Proof, SamePasswordProvesTheSame) {
  EXPECT_TRUE(plain_proof("sesame").proves_the_same_as(plain_proof("sesame")));
}

TEST(Proof, AnyOtherPasswordDoesNot) {
  const Proof proof = plain_proof("sesame");
  for (const char* wrong : {"", "sesamE", "Sesame", "sesam", "sesame1"}) {
    EXPECT_FALSE(proof.proves_the_same_as(plain_proof(wrong))) << wrong;
  }
}

TEST(Proof, OfNoPasswordIsEmpty) {
  EXPECT_TRUE(Proof().empty());
  EXPECT_TRUE(plain_proof("").empty());
  EXPECT_FALSE(plain_proof("x").empty());
}

TEST(Proof, AssigningReplacesIt) {
  Proof proof = plain_proof("old");
  const Proof fresh = plain_proof("new");
  proof = fresh;
  EXPECT_TRUE(proof.proves_the_same_as(plain_proof("new")));
  proof = plain_proof("newest");
  EXPECT_TRUE(proof.proves_the_same_as(plain_proof("newest")));
}

}  // namespace
}  // namespace gecos::access
