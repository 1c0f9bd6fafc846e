// Each term of @qos over each medium: which medium is taken, or which term is violated. The table
// is quality_table.txt. After a deliberate change: `WRITE_QUALITY_TABLE=1 quality_table_test`, then
// read the difference.
#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "../media/kind_names.hpp"
#include "bench.hpp"
#include "gecos/binding.hpp"

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
  };
  return all;
}

class QualityTable : public probe::Bench {
 protected:
  void SetUp() override {
    Bench::SetUp();
    gecos::ObjectOptions hardware;  // of a simulated object, HARD_REALTIME is relaxed
    ASSERT_TRUE(server_->add("PROBE", servant_, hardware));
  }

  auto created(const gecos::InterfaceDescription& wanted, std::optional<Kind> medium) {
    return gecos::session::create(gecos::session::LabAccess::context(lab_), wanted, {"PROBE"},
                                  {.medium = medium, .patience = 20s});
  }
  /// An interface that demands it: the medium that `create` takes, or why it takes none.
  std::string of_interface(const Quality& quality, std::optional<Kind> medium) {
    gecos::InterfaceDescription wanted = probe::description();
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
    gecos::InterfaceDescription wanted = probe::description();
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
};

TEST_F(QualityTable, IsWhatEachTermAndMediumGive) {
  std::ostringstream table;
  for (const auto& [written, quality] : rows()) {
    table << "@qos(" << written << ")\n  interface: " << of_interface(quality, std::nullopt)
          << "\n";
    for (const Kind medium : gecos::media::all_kinds()) {
      table << "  interface over " << to_string(medium) << ": " << of_interface(quality, medium)
            << "\n  operation over " << to_string(medium) << ": " << of_operation(quality, medium)
            << "\n";
    }
  }
  if (std::getenv("WRITE_QUALITY_TABLE") != nullptr) std::ofstream(QUALITY_TABLE) << table.str();
  std::ostringstream expected;
  expected << std::ifstream(QUALITY_TABLE).rdbuf();
  EXPECT_EQ(table.str(), expected.str());
}

}  // namespace
