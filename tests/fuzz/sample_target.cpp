// Samples of inward streams from a client that sends what it likes, while its session, its status
// and its command come and go.
#include <algorithm>

#include "gecos/session/server/inward_admission.hpp"
#include "script.hpp"
#include "targets.hpp"

namespace gecos::fuzz {
namespace {

using namespace session;

/// Often the true value, else any.
std::uint64_t claimed(Script& script, std::uint64_t truth) {
  return script.one_in(4) ? script.number() : truth;
}

Bytes sample_of(Script& script, const InwardSender& sender) {
  if (script.one_in(8)) return script.bytes(64);
  const InwardHeader header{SessionId{claimed(script, number(sender.session))},
                            Epoch{claimed(script, number(sender.epoch.value_or(Epoch{})))},
                            claimed(script, sender.feeding.value_or(0))};
  const Bytes value = script.bytes(32);
  Bytes bytes(inward_header_size + value.size());
  write_inward_header(std::span(bytes).first<inward_header_size>(), header);
  std::copy(value.begin(), value.end(), bytes.begin() + inward_header_size);
  return bytes;
}

}  // namespace

void try_samples(ByteView input) {
  Script script(input);
  InwardSender sender{SessionId{script.number()}, true, Epoch{1}, std::nullopt};
  InwardAdmission admission;
  std::uint64_t newest = 0;
  while (!script.over()) {
    switch (script.below(4)) {
      case 0:
        sender.alive = !script.one_in(4);
        break;
      case 1:
        if (script.one_in(4)) {
          sender.epoch.reset();
        } else {
          sender.epoch = Epoch{number(sender.epoch.value_or(Epoch{})) + script.below(3)};
        }
        break;
      case 2:
        sender.feeding.reset();
        if (script.below(4) > 0) sender.feeding = script.number();
        break;
      default: {
        const Bytes bytes = sample_of(script, sender);
        const auto sample = read_inward_sample(bytes);
        expect(sample.has_value() == (bytes.size() >= inward_header_size),
               "a sample is read exactly when it has a whole header");
        if (!sample) break;
        Bytes again(inward_header_size);
        write_inward_header(std::span(again).first<inward_header_size>(), sample->header);
        expect(std::equal(again.begin(), again.end(), bytes.begin()),
               "a header is read as written");
        const std::uint64_t sequence = claimed(script, newest + 1);
        const InwardAge age{Duration(script.below(4)), Duration(script.below(4))};
        const bool fits = sample->header.session == sender.session && sender.alive &&
                          sample->header.epoch == sender.epoch && sender.feeding &&
                          sample->header.command == *sender.feeding && sequence > newest &&
                          age.age <= age.limit;
        const auto verdict = admission.judge(sample->header, sequence, sender, age);
        expect((verdict == InwardVerdict::Admitted) == fits, "exactly what fits is admitted");
        expect(describe(verdict) != "unknown", "every verdict has words");
        if (fits) newest = sequence;
      }
    }
  }
}

}  // namespace gecos::fuzz
