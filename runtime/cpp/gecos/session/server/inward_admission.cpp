#include "gecos/session/server/inward_admission.hpp"

namespace gecos::session {

std::string_view describe(InwardVerdict verdict) {
  switch (verdict) {
    case InwardVerdict::Admitted:
      return "the sample is admitted";
    case InwardVerdict::OtherSession:
      return "the sample names another session";
    case InwardVerdict::SessionEnded:
      return "its session has ended";
    case InwardVerdict::OtherEpoch:
      return "the sender does not have the status, or the status has ended";
    case InwardVerdict::NameUnconfirmed:
      return "the broker does not confirm the name of the object";
    case InwardVerdict::NobodyPresent:
      return "nobody is known to be present in the zone of the object";
    case InwardVerdict::CommandNotRunning:
      return "its command does not run";
    case InwardVerdict::TooOld:
      return "the sample is older than the watchdog or the lifespan of the stream";
    case InwardVerdict::NotNewer:
      return "a newer sample has arrived";
  }
  return "unknown";
}

InwardVerdict InwardAdmission::judge(const InwardHeader& sample, std::uint64_t sequence,
                                     const InwardSender& sender, const InwardAge& age) {
  if (sample.session != sender.session) return InwardVerdict::OtherSession;
  if (!sender.alive) return InwardVerdict::SessionEnded;
  if (sample.epoch != sender.epoch) return InwardVerdict::OtherEpoch;
  if (sender.name_unconfirmed) return InwardVerdict::NameUnconfirmed;
  if (sender.nobody_present) return InwardVerdict::NobodyPresent;
  if (sample.command != sender.feeding) return InwardVerdict::CommandNotRunning;
  if (age.age > age.limit) return InwardVerdict::TooOld;
  if (sequence <= newest_) return InwardVerdict::NotNewer;
  newest_ = sequence;
  return InwardVerdict::Admitted;
}

}  // namespace gecos::session
