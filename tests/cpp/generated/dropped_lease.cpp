// Not part of the build: the compiler is to warn of both.
#include "gecos/gecos.hpp"
#include "robcl/rx90_client.hpp"

void move(const robcl::Rx90& robot) {
  gecos::actor(robot);
  gecos::master(robot);
}
