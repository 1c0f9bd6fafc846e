// 100,000 random schedules of the line for a status, at a real object with a clock of the test:
// ask, wait, grant by a release, deny, cancel, time-out, stop and death, compared reply by reply
// with a model of its own. SCHEDULES and SCHEDULES_SEED ask for others.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <optional>
#include <random>
#include <set>
#include <string>
#include <tuple>
#include <vector>

#include "object_host_bench.hpp"

namespace gecos::session {
namespace {

using namespace std::chrono_literals;

constexpr std::ptrdiff_t most_questions_of_program = 8;

/// What the model forgets, so that a test shows that the schedules find it.
enum class Forgotten { Nothing, TimeOut, Denial, Order, Drain, Death };

/// The reply to a call of one of the clients.
using Told = std::tuple<int, std::uint64_t, Detail>;

/// Who holds the status and who waits for it. Clients and their calls have numbers.
class LineModel {
 public:
  explicit LineModel(Forgotten forgotten) : forgotten_(forgotten) {}

  void acquire(int who, std::uint64_t call, Duration patience) {
    if (grant(who, line_.size())) return tell(who, call, Detail::Done);
    if (patience == Duration{}) return tell(who, call, Detail::Fault);
    line_.push_back({who, call, ++last_id_, now_ + patience});
    answer_questions();
  }
  void release(int who, std::uint64_t call) {
    if (holder_ == who && !releasing_ && --claims_ == 0) {
      releasing_ = runs_ && forgotten_ != Forgotten::Drain;
      if (!releasing_) holder_.reset();
    }
    serve();
    tell(who, call, Detail::Done);
  }
  void begin(std::uint64_t call) { runs_ = call; }
  void finish() {
    tell(*holder_, *std::exchange(runs_, std::nullopt), Detail::Done);
    if (releasing_) holder_.reset();
    serve();
  }
  void ask(int who, std::uint64_t call, std::uint64_t after, Duration patience) {
    if (std::ranges::count(questions_, who, &Waits::who) == most_questions_of_program)
      return tell(who, call, Detail::QueueFull);
    questions_.push_back({who, call, after, now_ + patience});
    answer_questions();
  }
  void deny(int who, std::uint64_t call, std::uint64_t id) {
    if (holder_ != who || releasing_) return tell(who, call, Detail::Fault);
    const auto denied = std::ranges::find(line_, id, &Waits::id);
    if (denied != line_.end()) {
      tell(denied->who, denied->call, Detail::Fault);
      if (forgotten_ != Forgotten::Denial) line_.erase(denied);
    }
    tell(who, call, Detail::Done);
  }
  void cancel(int who, std::uint64_t call) {
    const auto of_call = [&](const Waits& one) { return one.who == who && one.call == call; };
    if (std::erase_if(line_, of_call) + std::erase_if(questions_, of_call) != 0) {
      tell(who, call, Detail::Canceled);
    }
  }
  void stop(int who, std::uint64_t call) {
    for (const Waits& request : std::exchange(line_, {})) {
      tell(request.who, request.call, Detail::Stopped);
    }
    if (holder_ != who) holder_.reset();
    tell(who, call, Detail::Done);
  }
  void depart(int who) {
    const auto of_client = [&](const Waits& one) { return one.who == who; };
    if (forgotten_ != Forgotten::Death) std::erase_if(line_, of_client);
    std::erase_if(questions_, of_client);
    if (holder_ == who) holder_.reset();
    serve();
  }
  void pass(Duration time) {
    now_ += time;
    serve();
    answer_questions();
  }

  /// The replies since the last call of this function.
  std::vector<Told> told() { return std::exchange(told_, {}); }
  std::optional<int> holder() const { return holder_; }
  bool releasing() const { return releasing_; }
  bool runs() const { return runs_.has_value(); }
  std::uint64_t last_id() const { return last_id_; }
  std::size_t waiting() const { return line_.size(); }

 private:
  struct Waits {
    int who = 0;
    std::uint64_t call = 0;
    std::uint64_t id = 0;  ///< of a request; of a question, the last id that its client knows
    TimePoint give_up{};
  };

  void tell(int who, std::uint64_t call, Detail how) { told_.emplace_back(who, call, how); }
  bool grant(int who, std::size_t before) {
    if (holder_ && (holder_ != who || (releasing_ && before > 0))) return false;
    claims_ = holder_ && !releasing_ ? claims_ + 1 : 1;
    holder_ = who;
    releasing_ = false;
    return true;
  }
  /// Grants the status to the first that may have it, and refuses those who waited too long. Who
  /// has released it gets it back only before all others.
  void serve() {
    if (!holder_) releasing_ = false;
    if (forgotten_ == Forgotten::Order) std::ranges::reverse(line_);
    std::vector<Waits> stay;
    for (const Waits& request : line_) {
      if (grant(request.who, stay.size())) {
        tell(request.who, request.call, Detail::Done);
      } else if (request.give_up <= now_ && forgotten_ != Forgotten::TimeOut) {
        tell(request.who, request.call, Detail::Fault);
      } else {
        stay.push_back(request);
      }
    }
    line_ = std::move(stay);
  }
  void answer_questions() {
    std::erase_if(questions_, [&](const Waits& question) {
      const auto newer = [&](const Waits& request) { return request.id > question.id; };
      if (question.give_up > now_ && std::ranges::none_of(line_, newer)) return false;
      tell(question.who, question.call, Detail::Done);
      return true;
    });
  }

  const Forgotten forgotten_;
  TimePoint now_{};
  std::optional<int> holder_;
  int claims_ = 0;
  bool releasing_ = false;
  std::optional<std::uint64_t> runs_;  ///< the call of the holder whose handler runs
  std::vector<Waits> line_;
  std::vector<Waits> questions_;
  std::uint64_t last_id_ = 0;
  std::vector<Told> told_;
};

/// Never destroyed: the maintenance thread of a runtime may read the clock until the program ends.
struct Host {
  SuspendedMachine clock;
  const std::shared_ptr<Runtime> runtime = Runtime::make({}, clock).value();
};
Host& host() {
  static Host& only = *new Host;
  return only;
}

/// The server's end of a client.
struct Caller {
  std::shared_ptr<ServerSession> session;
  TestConnection* connection = nullptr;
  std::uint64_t counter = 0;
  Epoch epoch{};  ///< of its last grant
};

class LineSchedule {
 public:
  LineSchedule(std::uint64_t seed, Forgotten forgotten) : random_(seed), model_(forgotten) {
    servant_.keep = true;
    for (Caller& caller : callers_) connect(caller);
  }
  ~LineSchedule() {
    object_->close();
    servant_.kept.clear();
    object_->join();
  }
  LineSchedule(const LineSchedule&) = delete;
  LineSchedule& operator=(const LineSchedule&) = delete;

  /// Returns the first difference between object and model; empty when there is none.
  std::string run() {
    for (int step = 0; step < 24; ++step) {
      const std::string done = act();
      most_waiting_ = std::max(most_waiting_, model_.waiting());
      std::vector<Told> wanted = model_.told();
      std::vector<Told> found = replies();
      std::ranges::sort(wanted);
      std::ranges::sort(found);
      if (wanted != found) {
        return "step " + std::to_string(step) + ", " + done + ": the object told " + shown(found) +
               ", the model " + shown(wanted);
      }
    }
    return {};
  }
  std::size_t most_waiting() const { return most_waiting_; }

 private:
  static std::string shown(const std::vector<Told>& told) {
    std::string text;
    for (const auto& [who, call, how] : told) {
      text += (text.empty() ? "" : ", ") + std::to_string(who) + "/" + std::to_string(call) + " " +
              std::string(to_string(how));
    }
    return text.empty() ? "nothing" : text;
  }

  unsigned draw(unsigned below) { return static_cast<unsigned>(random_() % below); }

  void connect(Caller& caller) {
    auto connection = std::make_unique<TestConnection>(true);
    caller = {};
    caller.connection = connection.get();
    caller.session = std::make_shared<ServerSession>(std::move(connection), object_);
    Hello hello;
    hello.user = "ada";
    hello.incarnation = static_cast<std::uint64_t>(&caller - callers_.data()) + 1;
    hello.interface_name = "probe::Probe";
    send(caller, wire::PacketKind::Hello, 0, {}, wire::to_bytes(hello));
  }
  void send(Caller& caller, wire::PacketKind kind, std::uint64_t counter, FunctionCode code,
            ByteView body = {}, Epoch epoch = {}) {
    wire::PacketHeader header;
    header.kind = kind;
    header.session = caller.session->id();
    header.counter = counter;
    header.code = code;
    header.epoch = epoch;
    Bytes packet;
    write_packet(packet, header, body);
    object_->take(caller.session, packet);
    object_->run_ready(Starter::Poller);
  }
  std::uint64_t call(int who, FunctionCode code, ByteView body = {}, Epoch epoch = {}) {
    Caller& caller = callers_.at(static_cast<std::size_t>(who));
    send(caller, wire::PacketKind::Call, ++caller.counter, code, body, epoch);
    return caller.counter;
  }

  /// Takes all replies out of the connections.
  std::vector<Told> replies() {
    std::vector<Told> told;
    for (std::size_t who = 0; who < callers_.size(); ++who) {
      Caller& caller = callers_.at(who);
      for (const Bytes& sent : std::exchange(caller.connection->sent, {})) {
        const auto packet = wire::decode_packet(sent);
        if (packet->header.kind != wire::PacketKind::Reply) continue;
        const auto how = detail_from(static_cast<std::uint8_t>(packet->header.flags));
        told.emplace_back(static_cast<int>(who), packet->header.counter, how.value());
        note_epoch(caller, *packet);
      }
    }
    return told;
  }
  /// A reply to an acquisition has a grant; others tell the epoch if it is newer.
  void note_epoch(Caller& caller, const wire::PacketView& packet) const {
    if (packet.header.epoch != Epoch{}) caller.epoch = packet.header.epoch;
    Grant grant;
    wire::Decoder from(packet.body);
    if (acquires_.contains({caller.session->id(), packet.header.counter}) &&
        wire::get_block(from, grant, "grant")) {
      caller.epoch = Epoch{grant.epoch};
    }
  }

  std::string act() {
    const int who = static_cast<int>(draw(callers));
    const std::string name = std::to_string(who);
    switch (draw(16)) {
      case 0:
      case 1:
      case 2:
      case 3:
        acquires(who);
        return name + " acquires";
      case 4:
      case 5:
        releases(model_.holder().value_or(who));
        return "the holder releases";
      case 6:
        begins();
        return "the holder begins a command";
      case 7:
        finishes();
        return "a command finishes";
      case 8:
      case 9:
        asks(who);
        return name + " asks who waits";
      case 10:
        denies(draw(3) == 0 ? who : model_.holder().value_or(who));
        return "a request is denied";
      case 11:
        cancels(who);
        return name + " cancels";
      case 12:
        stops(who);
        return name + " stops";
      case 13:
        dies(who);
        return name + " goes";
      default:
        passes();
        return "time passes";
    }
  }

  void acquires(int who) {
    const Duration patience = std::array<Duration, 4>{0s, 10s, 30s, 300s}.at(draw(4));
    const GecosObject_acquire_arguments asked{draw(4) == 0 ? Status::MASTER : Status::ACTOR,
                                              {},
                                              std::chrono::duration<double>(patience).count()};
    Caller& caller = callers_.at(static_cast<std::size_t>(who));
    acquires_.emplace(caller.session->id(), caller.counter + 1);
    const auto number = call(who, GecosObjectInterface::acquire.code, layout::to_bytes(asked));
    model_.acquire(who, number, patience);
  }
  void releases(int who) {
    const Epoch epoch = callers_.at(static_cast<std::size_t>(who)).epoch;
    const GecosObject_release_arguments asked{number(epoch), false};
    model_.release(who, call(who, GecosObjectInterface::release.code, layout::to_bytes(asked)));
  }
  void begins() {
    if (!model_.holder() || model_.releasing() || model_.runs()) return;
    const int who = *model_.holder();
    const Epoch epoch = callers_.at(static_cast<std::size_t>(who)).epoch;
    model_.begin(call(who, probe::set_code, {}, epoch));
  }
  void finishes() {
    if (servant_.kept.empty()) return;
    servant_.kept.back().finish({});
    servant_.kept.clear();
    object_->run_ready(Starter::Poller);
    model_.finish();
  }
  void asks(int who) {
    const Duration patience = draw(3) == 0 ? 0s : 30s;
    const std::uint64_t after = draw(2) == 0 ? 0 : model_.last_id();
    const GecosObject_requests_arguments asked{after,
                                               std::chrono::duration<double>(patience).count()};
    const auto number = call(who, GecosObjectInterface::requests.code, layout::to_bytes(asked));
    model_.ask(who, number, after, patience);
  }
  void denies(int who) {
    const std::uint64_t id = 1 + draw(static_cast<unsigned>(model_.last_id()) + 1);
    const GecosObject_deny_arguments asked{id, "not now"};
    model_.deny(who, call(who, GecosObjectInterface::deny.code, layout::to_bytes(asked)), id);
  }
  void cancels(int who) {
    Caller& caller = callers_.at(static_cast<std::size_t>(who));
    if (caller.counter == 0) return;
    const std::uint64_t canceled = 1 + draw(static_cast<unsigned>(caller.counter));
    send(caller, wire::PacketKind::Cancel, canceled, {});
    model_.cancel(who, canceled);
  }
  /// Not while a handler runs: what waits for it then is shown by other tests.
  void stops(int who) {
    if (model_.runs()) return;
    model_.stop(who, call(who, GecosObjectInterface::stop.code));
  }
  void dies(int who) {
    if (model_.runs()) return;
    Caller& caller = callers_.at(static_cast<std::size_t>(who));
    using Departure = ObjectHost::Departure;
    object_->depart(caller.session, draw(2) == 0 ? Departure::Lost : Departure::InOrder);
    connect(caller);
    model_.depart(who);
  }
  /// All clients show that they live.
  void passes() {
    host().clock.pass(7s);
    for (Caller& caller : callers_) object_->check_liveness(caller.session);
    object_->on_tick(host().clock.now());
    model_.pass(7s);
  }

  static constexpr unsigned callers = 4;
  std::mt19937_64 random_;
  LineModel model_;
  Servant servant_;
  std::shared_ptr<ObjectHost> object_ =
      std::make_shared<ObjectHost>(host().runtime, "PROBE", servant_, ObjectOptions{});
  std::array<Caller, callers> callers_;
  std::set<std::pair<SessionId, std::uint64_t>> acquires_;  ///< calls whose result is a grant
  std::size_t most_waiting_ = 0;
};

std::uint64_t asked_for(const char* variable, std::uint64_t standard) {
  const char* const text = std::getenv(variable);
  return text == nullptr ? standard : std::strtoull(text, nullptr, 10);
}

struct Searched {
  std::string alarm;
  std::uint64_t schedules = 0;
  std::uint64_t long_lines = 0;  ///< schedules in which at least two waited
};

Searched search(std::uint64_t count, Forgotten forgotten = Forgotten::Nothing) {
  Searched searched;
  const std::uint64_t first = asked_for("SCHEDULES_SEED", 1);
  for (std::uint64_t seed = first; seed < first + count && searched.alarm.empty(); ++seed) {
    LineSchedule schedule(seed, forgotten);
    const std::string alarm = schedule.run();
    if (!alarm.empty()) searched.alarm = "seed " + std::to_string(seed) + ": " + alarm;
    searched.long_lines += schedule.most_waiting() >= 2 ? 1 : 0;
    ++searched.schedules;
  }
  return searched;
}

TEST(HandOverSchedules, TellEachClientWhatTheModelTells) {
  const Searched searched = search(asked_for("SCHEDULES", 100'000));
  EXPECT_EQ(searched.alarm, "");
  EXPECT_GT(searched.long_lines, searched.schedules / 4) << "few schedules have a line";
}

class HandOverMutants : public ::testing::TestWithParam<Forgotten> {};
INSTANTIATE_TEST_SUITE_P(Of, HandOverMutants,
                         ::testing::Values(Forgotten::TimeOut, Forgotten::Denial, Forgotten::Order,
                                           Forgotten::Drain, Forgotten::Death));

TEST_P(HandOverMutants, AreFound) {
  const Searched searched = search(1'000, GetParam());
  EXPECT_NE(searched.alarm, "");
}

}  // namespace
}  // namespace gecos::session
