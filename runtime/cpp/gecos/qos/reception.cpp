#include "gecos/qos/reception.hpp"

#include <algorithm>

namespace gecos::qos {

Reception::Reception(const Quality& terms, TimePoint opened, std::uint64_t newest,
                     std::optional<std::uint64_t> after)
    : lifespan_(terms.lifespan),
      deadline_(terms.deadline),
      manual_(terms.liveliness == Liveliness::Manual),
      newest_at_first_(newest),
      last_(after),
      gap_from_(opened),
      silent_from_(opened) {}

bool Reception::take(Way way, std::uint64_t sequence, TimePoint measured, TimePoint now) {
  const std::uint64_t unread = last_ ? sequence - *last_ - 1 : 0;
  (way == Way::InOrder ? lost_ : skipped_).add(unread);
  if (sequence <= last_.value_or(newest_at_first_) + 1) {
    count_missed(periods_in(measured - gap_from_));
  }
  last_ = sequence;
  measured_ = measured;
  gap_from_ = std::max(gap_from_, measured);
  silent_from_ = now;
  reported_ = false;
  missed_here_.reset();
  const bool too_old = expired(measured, now);
  (too_old ? expired_ : received_).add(1);
  return !too_old;
}

void Reception::find_nothing(TimePoint now) { count_missed(periods_in(now - silent_from_)); }

bool Reception::still_valid(TimePoint now) const {
  return writer_alive() && !expired(measured_, now);
}

bool Reception::report_late() {
  if (reported_ || missed_here_.get() == 0) return false;
  reported_ = true;
  return true;
}

TimePoint Reception::late_at() const {
  if (deadline_ <= Duration{} || reported_) return TimePoint::max();
  return silent_from_ + deadline_ + Duration(1);
}

bool Reception::writer_alive() const { return !manual_ || missed_here_.get() == 0; }

StreamCounts Reception::counts() const {
  return {received_.get(), lost_.get(), skipped_.get(), expired_.get(), missed_.get()};
}

/// Returns how many deadlines passed in `gap`. A sample that comes exactly at the deadline is in
/// time.
std::uint64_t Reception::periods_in(Duration gap) const {
  if (deadline_ <= Duration{} || gap <= deadline_) return 0;
  return static_cast<std::uint64_t>((gap - Duration(1)) / deadline_);
}

/// Adds the missed deadlines of the present gap to the count, except those that were counted
/// before. `in_this_gap`: how many deadlines have passed in this gap so far.
void Reception::count_missed(std::uint64_t in_this_gap) {
  if (in_this_gap <= missed_here_.get()) return;
  const std::uint64_t more = in_this_gap - missed_here_.get();
  missed_.add(more);
  missed_here_.add(more);
}

}  // namespace gecos::qos
