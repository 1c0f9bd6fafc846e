// Each term of @qos over each medium: which medium is taken, or which term is violated. The table
// is quality_table.txt. After a deliberate change: `WRITE_QUALITY_TABLE=1 quality_table_test`, then
// read the difference.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <future>
#include <regex>
#include <sstream>

#include "../media/kind_names.hpp"
#include "bench.hpp"
#include "gecos/binding.hpp"
#include "gecos/media/testing/faulty.hpp"
#include "written_lab_file.hpp"

namespace {

using namespace std::chrono_literals;
using gecos::media::Kind;
using gecos::qos::Class;
using gecos::qos::Liveliness;
using gecos::qos::Media;
using gecos::qos::OnDegraded;
using gecos::qos::Quality;
using gecos::qos::Reliability;

struct Row {
  const char* written;
  Quality quality;
};

const std::vector<Row>& rows() {
  static const std::vector<Row> all = {
      {"nothing", {}},
      {"class=TIME_INDEPENDENT", {.line = Class::TimeIndependent}},
      {"class=SOFT_REALTIME", {.line = Class::SoftRealtime}},
      {"class=HARD_REALTIME", {.line = Class::HardRealtime}},
      {"reliability=RELIABLE", {.reliability = Reliability::Reliable}},
      {"reliability=BEST_EFFORT", {.reliability = Reliability::BestEffort}},
      {"media=inproc", {.media = Media::Inproc}},
      {"media=shm", {.media = Media::Shm}},
      {"media=lcm", {.media = Media::Lcm}},
      {"media=shm|can", {.media = Media::Shm | Media::Can}},
      {"media=tcp", {.media = Media::Tcp}},
      {"class=HARD_REALTIME, media=lcm", {.line = Class::HardRealtime, .media = Media::Lcm}},
      {"deadline=1h", {.deadline = 1h}},
      {"start_by=1h", {.start_by = 1h}},
      {"latency=1us", {.latency = 1us}},
      {"class=SOFT_REALTIME, latency=1h", {.line = Class::SoftRealtime, .latency = 1h}},
      {"lifespan=1s", {.lifespan = 1s}},
      {"deadline=1h, liveliness=MANUAL", {.deadline = 1h, .liveliness = Liveliness::Manual}},
      {"depth=4", {.depth = 4}},
      {"class=SOFT_REALTIME, latency=1h, on_degraded=fail",
       {.line = Class::SoftRealtime, .latency = 1h, .on_degraded = OnDegraded::Fail}},
      {"class=SOFT_REALTIME, latency=1h, on_degraded=failover",
       {.line = Class::SoftRealtime, .latency = 1h, .on_degraded = OnDegraded::Failover}},
  };
  return all;
}

/// Demands that the paper's satellite keeps, and some that it does not keep.
const std::vector<Row>& satellite_rows() {
  static const std::vector<Row> all = {
      {"class=TIME_INDEPENDENT, latency=100ms", {.latency = 100ms}},
      {"class=SOFT_REALTIME, latency=100ms", {.line = Class::SoftRealtime, .latency = 100ms}},
      {"class=SOFT_REALTIME, latency=1us", {.line = Class::SoftRealtime, .latency = 1us}},
      {"class=HARD_REALTIME, latency=1ms", {.line = Class::HardRealtime, .latency = 1ms}},
  };
  return all;
}

constexpr auto alarm_code = probe::function_code("probe::Probe::alarm");

constexpr gecos::InwardDescription alter{.code = probe::function_code("probe::Probe::alter"),
                                         .name = "alter",
                                         .watchdog = 1h,
                                         .largest = 4};

/// The interface of the probe, with an event and an inward stream.
const gecos::InterfaceDescription& description() {
  static const auto streams = [] {
    std::vector all(probe::description().streams.begin(), probe::description().streams.end());
    all.push_back({.code = alarm_code, .name = "alarm", .largest = 4, .event = true});
    std::ranges::sort(all, {}, &gecos::StreamDescription::code);
    return all;
  }();
  static const auto described = [] {
    gecos::InterfaceDescription made = probe::description();
    made.streams = streams;
    made.inward_streams = std::span(&alter, 1);
    return made;
  }();
  return described;
}

class WatchedProbe final : public probe::ProbeServant {
 public:
  const gecos::InterfaceDescription& gecos_interface() const override { return description(); }
};
/// Demands that a lab file answers that says that lcm is real-time, and shm is not.
const std::vector<Row>& stated_rows() {
  static const std::vector<Row> all = {
      {"nothing", {}},
      {"class=SOFT_REALTIME", {.line = Class::SoftRealtime}},
      {"class=HARD_REALTIME", {.line = Class::HardRealtime}},
      {"class=HARD_REALTIME, media=lcm", {.line = Class::HardRealtime, .media = Media::Lcm}},
  };
  return all;
}

gecos::LabOptions with_lab_file(const std::string& path) {
  gecos::LabOptions options = probe::patient();
  options.lab_file = path;
  return options;
}

/// Delays every medium, or only the one that is called `only`.
gecos::Lab delayed_lab(const std::string& only = "") {
  static const gecos::SystemClock clock;
  static const std::atomic<gecos::Duration::rep> satellite{gecos::Duration(600ms).count()};
  return gecos::session::LabAccess::with_media(
      probe::patient(), [only](std::unique_ptr<gecos::media::Medium> inner) {
        const bool delayed = only.empty() || inner->capabilities().name == only;
        if (!delayed) return inner;
        // `more_delay`, because with a `delay` the medium itself promises no real time.
        return gecos::media::make_faulty(std::move(inner), {.more_delay = &satellite}, clock);
      });
}

class QualityTable : public probe::Bench {
 protected:
  void SetUp() override {
    Bench::SetUp();
    gecos::ObjectOptions hardware;  // of a simulated object, HARD_REALTIME is relaxed
    ASSERT_TRUE(server_->add("PROBE", watched_, hardware));
  }
  void TearDown() override { server_.reset(); }  // before its servant

  auto created(const gecos::InterfaceDescription& wanted, std::optional<Kind> medium) {
    return gecos::session::create(gecos::session::LabAccess::context(*client_), wanted, {"PROBE"},
                                  {.medium = medium, .latency = accepted_, .patience = 20s});
  }
  /// An interface that demands it: the medium that `create` takes, or why it takes none.
  std::string of_interface(const Quality& quality, std::optional<Kind> medium) {
    gecos::InterfaceDescription wanted = description();
    wanted.quality = quality;
    const auto session = created(wanted, medium);
    return session ? std::string(session->session->capabilities().name)
                   : session.error().to_string();
  }
  /// An operation that demands it, over a medium that the interface allows.
  std::string of_operation(const Quality& quality, Kind medium) {
    std::vector<gecos::OperationDescription> operations(probe::description().operations.begin(),
                                                        probe::description().operations.end());
    const auto read =
        std::ranges::find(operations, probe::read_code, &gecos::OperationDescription::code);
    read->quality = quality;
    gecos::InterfaceDescription wanted = description();
    wanted.operations = operations;
    const auto session = created(wanted, medium);
    if (!session) return session.error().to_string();
    const auto call = session->session->call(
        *read, 4, [](gecos::wire::Encoder& to) { to.put(std::int32_t{0}); }, {});
    call->wait_until(gecos::TimePoint::max());
    const gecos::Detail detail = call->progress().detail;
    return detail == gecos::Detail::Done
               ? "DONE"
               : std::string(to_string(detail)) + ": " + call->failure().text;
  }
  /// A stream or event that demands it, over a medium that the interface allows. The getter of the
  /// stream demands nothing.
  std::string of_stream(gecos::FunctionCode code, const Quality& quality, Kind medium) {
    std::vector<gecos::StreamDescription> streams(description().streams.begin(),
                                                  description().streams.end());
    const auto stream = std::ranges::find(streams, code, &gecos::StreamDescription::code);
    stream->quality = quality;
    gecos::InterfaceDescription wanted = description();
    wanted.streams = streams;
    const auto session = created(wanted, medium);
    return session ? opened(session->session->subscribe(*stream)) : session.error().to_string();
  }
  /// An inward stream that demands it, over a medium that the interface allows.
  std::string of_inward_stream(const Quality& quality, Kind medium) {
    gecos::InwardDescription stream = alter;
    stream.quality = quality;
    gecos::InterfaceDescription wanted = description();
    wanted.inward_streams = std::span(&stream, 1);
    const auto session = created(wanted, medium);
    return session ? opened(session->session->open_writer(stream)) : session.error().to_string();
  }
  template <class Core>
  static std::string opened(const tl::expected<Core, gecos::Failure>& stream) {
    return stream ? "OPENED"
                  : std::string(to_string(stream.error().detail)) + ": " + stream.error().text;
  }
  /// Fills all cells of the row at the same time: over the satellite, each takes seconds.
  void add_row(const Row& row) {
    struct Cell {
      std::string name;
      std::future<std::string> text;
    };
    std::vector<Cell> cells;
    const auto add = [&](const std::string& name, auto text) {
      cells.push_back({name, std::async(std::launch::async, text)});
    };
    const Quality& quality = row.quality;
    add("interface", [&] { return of_interface(quality, std::nullopt); });
    for (const Kind medium : gecos::media::all_kinds()) {
      const std::string over = " over " + std::string(to_string(medium));
      add("interface" + over, [&, medium] { return of_interface(quality, medium); });
      add("operation" + over, [&, medium] { return of_operation(quality, medium); });
      add("stream" + over, [&, medium] { return of_stream(probe::level_code, quality, medium); });
      add("event" + over, [&, medium] { return of_stream(alarm_code, quality, medium); });
      add("inward stream" + over, [&, medium] { return of_inward_stream(quality, medium); });
    }
    table_ << "@qos(" << row.written << ")\n";
    for (Cell& cell : cells) table_ << "  " << cell.name << ": " << cell.text.get() << "\n";
  }
  /// Moves the figures of the table out of the text, which is the same in every run.
  std::vector<double> take_figures(std::string& text) {
    static const std::regex figure("measured at ([0-9.]+)(us|ms|s)");
    std::vector<double> found;
    for (std::sregex_iterator each(text.begin(), text.end(), figure), end; each != end; ++each) {
      const double unit = (*each)[2] == "s" ? 1 : (*each)[2] == "ms" ? 1e-3 : 1e-6;
      found.push_back(std::stod((*each)[1]) * unit);
    }
    text = std::regex_replace(text, figure, "measured at N");
    return found;
  }

  WatchedProbe watched_;
  const probe::WrittenLabFile file_{
      "[media.lcm]\nreal_time = true\n[media.shm]\nreal_time = false\n"};
  gecos::Lab stated_{with_lab_file(file_.path())};
  gecos::Lab far_ = delayed_lab();
  gecos::Lab* client_ = &lab_;
  gecos::Duration accepted_{};  ///< what the program asks for in `create`
  std::ostringstream table_;
};

TEST_F(QualityTable, IsWhatEachTermAndMediumGive) {
  for (const Row& row : rows()) add_row(row);
  table_ << "\nwhere the lab file says that lcm is real-time and shm is not\n";
  client_ = &stated_;
  for (const Row& row : stated_rows()) add_row(row);
  table_ << "\nover a satellite: every answer comes 600 ms late\n";
  client_ = &far_;
  for (const Row& row : satellite_rows()) add_row(row);
  accepted_ = 100ms;
  table_ << "create asks for a latency of 100ms\n";
  table_ << of_interface({}, std::nullopt) << "\n";

  std::string table = std::regex_replace(table_.str(), std::regex(file_.path()), "lab.toml");
  for (const double measured : take_figures(table)) EXPECT_GE(measured, 0.6) << "s";
  if (std::getenv("WRITE_QUALITY_TABLE") != nullptr) std::ofstream(QUALITY_TABLE) << table;
  std::ostringstream expected;
  expected << std::ifstream(QUALITY_TABLE).rdbuf();
  EXPECT_EQ(table, expected.str());
}

TEST_F(QualityTable, HasNoSlowMediumWhereTheNextOneIsFastEnough) {
  gecos::Lab slow_inproc = delayed_lab("inproc");
  client_ = &slow_inproc;
  const Quality asked{.line = Class::SoftRealtime, .latency = 500ms};
  EXPECT_EQ(of_interface({}, std::nullopt), "inproc");
  EXPECT_EQ(of_interface(asked, std::nullopt), "shm");
}

}  // namespace
