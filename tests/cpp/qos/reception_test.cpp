#include "gecos/qos/reception.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/media/sealed/inward.hpp"

namespace gecos::qos {
namespace {

using namespace std::chrono_literals;
using Way = Reception::Way;

constexpr TimePoint start{1h};

TEST(Reception, ASampleIsReadableAtItsLifespanAndNotAfterIt) {
  Reception reads({.lifespan = 20ms}, start, 0, std::nullopt);
  EXPECT_TRUE(reads.take(Way::InOrder, 1, start, start + 20ms));
  EXPECT_TRUE(reads.still_valid(start + 20ms));
  EXPECT_FALSE(reads.still_valid(start + 20ms + 1ns));
  EXPECT_FALSE(reads.expired(start, start + 20ms));
  EXPECT_TRUE(reads.expired(start, start + 20ms + 1ns));
  EXPECT_FALSE(reads.take(Way::InOrder, 2, start, start + 20ms + 1ns));
  EXPECT_EQ(reads.counts(), (StreamCounts{.received = 1, .expired = 1}));
}

TEST(Reception, WithoutTermsEverySampleIsReadable) {
  Reception reads({}, start, 0, std::nullopt);
  EXPECT_TRUE(reads.take(Way::InOrder, 5, start - 24h, start));
  reads.find_nothing(start + 24h);
  EXPECT_TRUE(reads.still_valid(start + 24h));
  EXPECT_TRUE(reads.writer_alive());
  EXPECT_FALSE(reads.report_late());
  EXPECT_EQ(reads.late_at(), TimePoint::max());
  EXPECT_EQ(reads.counts(), (StreamCounts{.received = 1}));
}

TEST(Reception, SamplesBeforeTheOneThatIsReadAreLostOrSkipped) {
  Reception reads({}, start, 3, 3);  // an event: the reader expects number 4
  EXPECT_TRUE(reads.take(Way::InOrder, 6, start, start));
  EXPECT_TRUE(reads.take(Way::Newest, 10, start, start));
  EXPECT_TRUE(reads.take(Way::InOrder, 11, start, start));
  EXPECT_EQ(reads.counts(), (StreamCounts{.received = 3, .lost = 2, .skipped = 3}));
}

TEST(Reception, ASilenceIsReportedOnceAndEachOfItsPeriodsCounts) {
  Reception reads({.deadline = 10ms}, start, 0, std::nullopt);
  EXPECT_EQ(reads.late_at(), start + 10ms + 1ns);
  reads.find_nothing(start + 10ms);
  EXPECT_FALSE(reads.report_late()) << "a sample may still come in time";
  reads.find_nothing(reads.late_at());
  EXPECT_TRUE(reads.report_late());
  EXPECT_FALSE(reads.report_late());
  EXPECT_EQ(reads.late_at(), TimePoint::max());
  reads.find_nothing(start + 35ms);
  EXPECT_FALSE(reads.report_late());
  EXPECT_EQ(reads.counts().missed_deadlines, 3u);
  EXPECT_TRUE(reads.take(Way::InOrder, 1, start + 41ms, start + 42ms));
  EXPECT_EQ(reads.counts().missed_deadlines, 4u) << "three of the four were known";
  EXPECT_EQ(reads.late_at(), start + 52ms + 1ns) << "from the reading, at which it was there";
  reads.find_nothing(start + 53ms);
  EXPECT_TRUE(reads.report_late()) << "another silence";
}

TEST(Reception, ASlowReaderFindsTheGapsOfTheWriterAndNoOthers) {
  Reception reads({.deadline = 10ms}, start, 0, std::nullopt);
  EXPECT_TRUE(reads.take(Way::InOrder, 1, start + 5ms, start + 1s));
  EXPECT_TRUE(reads.take(Way::InOrder, 2, start + 15ms, start + 1s));
  EXPECT_EQ(reads.counts().missed_deadlines, 0u);
  EXPECT_TRUE(reads.take(Way::InOrder, 3, start + 36ms, start + 1s));
  EXPECT_EQ(reads.counts().missed_deadlines, 2u);
  EXPECT_TRUE(reads.take(Way::InOrder, 5, start + 90ms, start + 1s));
  EXPECT_EQ(reads.counts().missed_deadlines, 2u) << "number 4 may have been in time";
}

TEST(Reception, AReaderThatBeginsLateFindsNoGapBeforeItsFirstSample) {
  const Quality terms{.deadline = 10ms};
  Reception late(terms, start, 3, std::nullopt);
  EXPECT_TRUE(late.take(Way::InOrder, 93, start + 900ms, start + 1s));
  EXPECT_EQ(late.counts().missed_deadlines, 0u) << "numbers 4 to 92 may have been in time";
  Reception at_once(terms, start, 3, std::nullopt);
  EXPECT_TRUE(at_once.take(Way::InOrder, 4, start + 35ms, start + 1s));
  EXPECT_EQ(at_once.counts().missed_deadlines, 3u) << "number 4 is the first since it subscribed";
}

TEST(Reception, AWriterThatItselfShowsThatItLivesIsDeadFromAMissedDeadlineToTheNextSample) {
  Reception reads({.deadline = 10ms, .liveliness = Liveliness::Manual}, start, 0, std::nullopt);
  EXPECT_TRUE(reads.take(Way::Newest, 1, start, start));
  reads.find_nothing(start + 10ms);
  EXPECT_TRUE(reads.writer_alive());
  EXPECT_TRUE(reads.still_valid(start + 10ms));
  reads.find_nothing(start + 11ms);
  EXPECT_FALSE(reads.writer_alive());
  EXPECT_FALSE(reads.still_valid(start + 11ms));
  EXPECT_TRUE(reads.take(Way::Newest, 2, start + 12ms, start + 12ms));
  EXPECT_TRUE(reads.writer_alive());
}

// A random schedule of the real buffers of samples beside a model that is not incremental: it keeps
// everything that happened, and derives each answer and each count from the definitions in
// docs/gidl.md.

struct Published {
  std::uint64_t sequence;
  TimePoint measured;
  bool arrives;  ///< not lost on the way
};

/// What the reader saw at one moment: a sample, or that there was none.
struct Look {
  TimePoint at;
  std::optional<Published> sample;
  Way way;
};

/// The samples of a stream between its writer and one reader. The bytes of a sample are of no
/// interest here.
class Buffer {
 public:
  virtual ~Buffer() = default;
  virtual bool loses() const = 0;  ///< some samples do not arrive
  virtual void write(const Published& sample) = 0;
  /// Opens the stream: from now on `reader` may be used. `newest`: the newest sample, if any.
  virtual void open(const std::optional<Published>& newest) = 0;
  std::unique_ptr<media::StreamReader> reader;
};

/// A ring in memory, whose slots the reader reads while the writer goes on.
class Ring final : public Buffer {
 public:
  explicit Ring(std::size_t depth) : writer_(acceptor_->make_stream(8, depth)) {}
  bool loses() const override { return false; }
  void write(const Published& sample) override {
    EXPECT_TRUE(writer_->publish({}, 0));
    EXPECT_EQ(writer_->newest(), sample.sequence);
  }
  void open(const std::optional<Published>&) override {
    EXPECT_TRUE(server_->share(1, *writer_));
    reader = client_->open_stream(1);
  }

 private:
  const std::unique_ptr<media::Medium> medium_ = media::make_inproc();
  const std::unique_ptr<media::Acceptor> acceptor_ = medium_->listen("RING", false).value();
  const std::unique_ptr<media::Connection> client_ = medium_->connect(acceptor_->address()).value();
  const std::unique_ptr<media::Connection> server_ = acceptor_->accept();
  const std::unique_ptr<media::StreamWriter> writer_;
};

/// What a reader keeps of samples that arrive as datagrams.
class Arrived final : public Buffer {
 public:
  explicit Arrived(std::size_t depth) : samples_(std::make_shared<media::SampleBuffer>(depth)) {}
  bool loses() const override { return true; }
  void write(const Published& sample) override {
    if (sample.arrives && reader) samples_->put(sample.sequence, 0, {});
  }
  void open(const std::optional<Published>& newest) override {
    if (newest) samples_->put(newest->sequence, 0, {});  // its writer repeats it
    reader = std::make_unique<media::InwardReader>(samples_);
  }

 private:
  const std::shared_ptr<media::SampleBuffer> samples_;
};

class World {
 public:
  World(std::uint32_t seed, const Quality& terms, Buffer& buffer)
      : random_(seed), terms_(terms), buffer_(buffer) {
    for (auto before = pick(0, 2 * static_cast<std::int64_t>(terms.depth)); before > 0; --before) {
      publish();
    }
    if (!published_.empty()) {
      published_.back().arrives = true;
      joined_at_ = published_.back().sequence;
    }
    buffer_.open(published_.empty() ? std::nullopt : std::optional(published_.back()));
    reads_.emplace(terms, start, joined_at_, std::nullopt);
  }

  void step() {
    now_ += Duration(pick(0, 9) == 0 ? pick(0, 60'000) : pick(0, 4'000));
    switch (pick(0, 9)) {
      case 0:
      case 1:
      case 2:
      case 3:
        return publish();
      case 4:
      case 5:
      case 6:
        return read(Way::InOrder);
      case 7:
      case 8:
        return read(Way::Newest);
      default:
        return see_history();  // nothing else happens for a while
    }
  }

  void compare() {
    EXPECT_EQ(reads_->counts(), counts())
        << "lifespan " << terms_.lifespan.count() << ", deadline " << terms_.deadline.count();
  }

 private:
  std::int64_t pick(std::int64_t least, std::int64_t most) {
    return std::uniform_int_distribution<std::int64_t>(least, most)(random_);
  }

  void publish() {
    const auto late = Duration(pick(0, 7) == 0 ? pick(0, 30'000) : 0);
    const bool arrives = !buffer_.loses() || pick(0, 19) != 0;
    published_.push_back({published_.size() + 1, now_ - late, arrives});
    buffer_.write(published_.back());
  }

  /// The samples that the medium still has for the reader, the oldest first: as many as the depth,
  /// of those that arrived since the reader joined.
  std::vector<Published> stored() const {
    std::vector<Published> there;
    for (auto each = published_.rbegin(); each != published_.rend(); ++each) {
      if (there.size() == terms_.depth || each->sequence < joined_at_) break;
      if (each->arrives) there.push_back(*each);
    }
    std::ranges::reverse(there);
    return there;
  }

  void read(Way way) {
    std::optional<Published> found;
    for (const Published& each : stored()) {
      if (each.sequence <= last_read()) continue;
      if (!found || way == Way::Newest) found = each;
    }
    media::StreamSample sample;
    const bool read = way == Way::InOrder ? buffer_.reader->next(last_read(), sample)
                                          : buffer_.reader->latest(last_read(), sample);
    EXPECT_EQ(read ? sample.sequence : 0, found ? found->sequence : 0);
    looks_.push_back({now_, found, way});
    if (found) {
      EXPECT_EQ(reads_->take(way, found->sequence, found->measured, now_), fresh(*found));
    } else {
      reads_->find_nothing(now_);
      if (last()) {
        EXPECT_EQ(reads_->still_valid(now_), fresh(*last()) && alive());
      }
    }
    EXPECT_EQ(reads_->writer_alive(), alive());
    if (pick(0, 1) == 0) expect_report();
  }

  /// A history has the stored samples that are fresh, and changes no count (compare()).
  void see_history() {
    for (const Published& each : stored()) {
      EXPECT_NE(reads_->expired(each.measured, now_), fresh(each)) << each.sequence;
    }
  }

  void expect_report() {
    const auto silence = this_silence();
    const bool told = silence.has_value() && told_of_ == silence;
    const bool due = missed_in_this_gap() != 0 && !told;
    EXPECT_EQ(reads_->report_late(), due);
    if (due) told_of_ = silence;
    const bool waits = terms_.deadline > Duration{} && !(told || due);
    EXPECT_EQ(reads_->late_at(), waits ? silent_from() + terms_.deadline + 1ns : TimePoint::max());
  }

  // What the definitions say.
  bool fresh(const Published& sample) const {
    return terms_.lifespan == Duration{} || now_ <= sample.measured + terms_.lifespan;
  }
  std::optional<Published> last() const {
    for (auto each = looks_.rbegin(); each != looks_.rend(); ++each) {
      if (each->sample) return each->sample;
    }
    return std::nullopt;
  }
  std::uint64_t last_read() const { return last() ? last()->sequence : 0; }
  /// The number of the gap: how many samples were read before it.
  std::optional<std::size_t> this_silence() const {
    std::size_t samples = 0;
    for (const Look& each : looks_) samples += each.sample ? 1 : 0;
    return samples;
  }
  TimePoint silent_from() const {
    TimePoint from = start;
    for (const Look& each : looks_) from = each.sample ? each.at : from;
    return from;
  }
  /// How many deadlines lie strictly between, counted one by one.
  std::uint64_t deadlines_between(TimePoint from, TimePoint to) const {
    std::uint64_t passed = 0;
    if (terms_.deadline == Duration{}) return 0;
    for (TimePoint due = from + terms_.deadline; due < to; due += terms_.deadline) ++passed;
    return passed;
  }
  /// Of the silence since the last sample, as far as the reader has looked.
  std::uint64_t missed_in_this_gap() const {
    if (looks_.empty() || looks_.back().sample) return 0;
    return deadlines_between(silent_from(), looks_.back().at);
  }
  bool alive() const {
    return terms_.liveliness == Liveliness::Automatic || missed_in_this_gap() == 0;
  }

  StreamCounts counts() const {
    StreamCounts all;
    std::optional<Published> before;
    TimePoint newest_measured = start;
    TimePoint read_at = start;
    TimePoint looked_last = start;  // without success, since the sample before
    for (const Look& each : looks_) {
      if (!each.sample) {
        looked_last = each.at;
        continue;
      }
      const Published& sample = *each.sample;
      const std::uint64_t between = before ? sample.sequence - before->sequence - 1 : 0;
      (each.way == Way::InOrder ? all.lost : all.skipped) += between;
      const bool old = terms_.lifespan > Duration{} && each.at > sample.measured + terms_.lifespan;
      ++(old ? all.expired : all.received);
      const std::uint64_t seen = deadlines_between(read_at, looked_last);
      const bool follows = before ? between == 0 : sample.sequence <= joined_at_ + 1;
      const std::uint64_t measured =
          follows ? deadlines_between(newest_measured, sample.measured) : 0;
      all.missed_deadlines += std::max(seen, measured);
      newest_measured = std::max(newest_measured, sample.measured);
      read_at = looked_last = each.at;
      before = sample;
    }
    all.missed_deadlines += deadlines_between(read_at, looked_last);
    return all;
  }

  std::mt19937 random_;
  const Quality terms_;
  Buffer& buffer_;
  std::optional<Reception> reads_;
  TimePoint now_ = start;
  std::vector<Published> published_;
  std::uint64_t joined_at_ = 0;  ///< the newest sample when the reader opened the stream
  std::vector<Look> looks_;
  std::optional<std::size_t> told_of_;
};

template <class Kept>
void judge_random_schedules() {
  constexpr int steps = 300;  // each derives its answers from all that came before
  for (std::uint32_t seed = 0; seed < 400; ++seed) {
    Quality terms;
    terms.depth = 1 + seed % 7;
    if (seed % 2 != 0) terms.lifespan = Duration(1'000 + 7'919 * (seed % 5));
    if (seed % 3 != 0) terms.deadline = Duration(1'500 + 5'003 * (seed % 4));
    if (seed % 4 >= 2) terms.liveliness = Liveliness::Manual;
    Kept buffer(terms.depth);
    World world(seed, terms, buffer);
    for (int step = 0; step < steps; ++step) world.step();
    world.compare();
    if (::testing::Test::HasFailure()) FAIL() << "seed " << seed;
  }
}

TEST(Reception, GivesAndReportsExactlyWhatAModelPredictsOfARingOnRandomSchedules) {
  judge_random_schedules<Ring>();
}

TEST(Reception, GivesAndReportsExactlyWhatAModelPredictsOfDatagramsOnRandomSchedules) {
  judge_random_schedules<Arrived>();
}

}  // namespace
}  // namespace gecos::qos
