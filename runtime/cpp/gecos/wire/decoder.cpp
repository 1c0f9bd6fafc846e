#include "gecos/wire/decoder.hpp"

namespace gecos::wire {

bool Decoder::fail_number(DecodeProblem problem, RefusedNumber number, const char* limits,
                          std::size_t size, const char* field) {
  if (failed_) return false;
  fail(problem, field, offset() - size);
  error_.limits = limits;
  error_.number = number;
  return false;
}

}  // namespace gecos::wire
