#include "schedules/schedule.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "gecos/object_calls.hpp"
#include "gecos/object_interface.hpp"
#include "gecos/object_types.hpp"
#include "gecos/session/client/own_call.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/executor.hpp"
#include "gecos/wire/fields.hpp"

namespace gecos::session {
namespace {

/// What the object of the schedule that runs has given to its workers.
std::deque<std::function<void()>> posted;

}  // namespace

// In place of executor.cpp, so that a worker is a step as any other.
bool Executor::post(std::function<void()> job) {
  if (ended_) return false;
  posted.push_back(std::move(job));
  return true;
}

void Executor::join() { ended_ = true; }

namespace schedules {
namespace {

using namespace std::chrono_literals;
using access::Status;

constexpr std::size_t most_commands = 12;
/// What a sign of life may have lain unread, and a look of maintenance may be late.
constexpr Duration unread = oldest_sign_of_life + PauseWatch::longest_gap;
constexpr int steps = 40;

std::vector<OperationDescription> make_operations() {
  std::vector<OperationDescription> all(7);
  for (std::size_t at = 0; at < all.size(); ++at) {
    all[at].code = FunctionCode{static_cast<std::uint32_t>(1000 + at)};
  }
  all[0].name = "tap";
  all[1].name = "file", all[1].cancelable = true;
  all[2].name = "glide", all[2].parallel = true;
  all[3].name = "gauge", all[3].status = Status::Sensor, all[3].ordered = true;
  all[4].name = "weigh", all[4].status = Status::Sensor;
  all[5].name = "scan", all[5].status = Status::Sensor, all[5].cancelable = true;
  all[6].name = "halt", all[6].status = Status::Sensor, all[6].safety = true;
  return all;
}

template <class T>
T take(std::deque<T>& from, std::size_t at) {
  T taken = std::move(from[at]);
  from.erase(from.begin() + static_cast<std::ptrdiff_t>(at));
  return taken;
}

}  // namespace

const InterfaceDescription& bench() {
  static const auto operations = make_operations();
  static const auto described = [] {
    InterfaceDescription made;
    made.name = "schedules::Bench";
    made.version = "1.0";
    made.hash = 1;
    made.operations = operations;
    return made;
  }();
  return described;
}

/// Runs what comes, or keeps it in lanes until a thread of its own begins it. Answers later.
class Schedule::Handlers final : public Servant {
 public:
  explicit Handlers(Schedule& schedule) : schedule_(schedule) {}

  const InterfaceDescription& gecos_interface() const override { return bench(); }
  bool gecos_begins_calls() const override { return schedule_.lanes_ == Lanes::Queued; }
  void gecos_dispatch(IncomingCall call) override {
    if (schedule_.lanes_ == Lanes::Queued) {
      const OperationDescription& operation = call.operation();
      const std::size_t lane = operation.safety                                           ? 0
                               : operation.status == Status::Sensor && !operation.ordered ? 1
                                                                                          : 2;
      return lanes.at(lane).push_back(std::move(call));
    }
    run(std::move(call));
  }
  /// It may begin now, and so it does.
  void run(IncomingCall call) {
    schedule_.touched(Side::Server);  // it was marked: from now on nothing keeps it from beginning
    schedule_.began(call);
    running.push_back(std::move(call));
    if (schedule_.dice_.one_in(2)) finish(running.size() - 1);
  }
  void finish(std::size_t at) {
    IncomingCall call = take(running, at);
    if (schedule_.runs(Side::Server)) schedule_.judge_.finished(number_of(call));
    Bytes result(8);
    call.finish(result);
  }
  static std::size_t number_of(const IncomingCall& call) {
    std::uint64_t number = 0;
    wire::Decoder from(call.arguments());
    static_cast<void>(from.get(number, "number"));
    return number;
  }

  std::array<std::deque<IncomingCall>, 3> lanes;
  std::deque<IncomingCall> running;

 private:
  Schedule& schedule_;
};

Schedule::Schedule(std::shared_ptr<Runtime> runtime, ScheduleClock& clock, std::uint64_t seed,
                   Mutant mutant)
    : runtime_(std::move(runtime)),
      clock_(clock),
      mutant_(mutant),
      dice_(seed),
      lanes_(dice_.one_in(3) ? Lanes::Queued : Lanes::Called),
      line_(static_cast<Way>(dice_.below(3)), mutant, clock_, dice_),
      pauses_(runtime_->maintenance().pauses()),
      handlers_(std::make_unique<Handlers>(*this)) {
  clock_.after_reading = [this] {
    readings_.emplace(clock_.seen_by_server(), clock_.now());
    touched(acts_);
  };
  line_.touched = [this](Side side) { touched(side); };
  line_.parting = [this] {
    if (served_ && !served_->heartbeats.awaited && !pauses_.suspected(clock_.seen_by_server())) {
      judge_.parted();
    }
  };
  pauses_.judged(clock_.now() + Maintenance::tick);
}

Schedule::~Schedule() {
  calm_ = true;
  line_.kill(Side::Client);
  line_.kill(Side::Server);
  // Commands of a killed client are still open: each keeps the session alive, and the session it.
  if (session_) session_->close(Duration{});
  session_.reset();
  object_->close();
  posted.clear();
  handlers_->running.clear();
  for (auto& lane : handlers_->lanes) lane.clear();
  posted.clear();
  object_->join();
  pauses_.judged(TimePoint::max());
  clock_.after_reading = nullptr;
  line_.touched = nullptr;
  line_.parting = nullptr;
}

std::vector<std::string> Schedule::run() {
  open();
  // A withdrawal that is lost, or not read yet, is known by the client's silence (known-limits.md).
  if (line_.way() == Way::Radio) judge_.news_take(runtime_->options().lease_ttl + unread);
  trace_(clock_.now(), "way", static_cast<int>(line_.way()), "lanes", static_cast<int>(lanes_));
  calm_ = false;
  for (int left = steps; left > 0; --left) {
    pass(20ms);
    switch (dice_.below(24)) {
      case 0:
        freeze(Side::Server);
        break;
      case 1:
        if (dice_.one_in(3)) freeze(Side::Client);
        break;
      case 2:
        if (dice_.one_in(3)) freeze_both();
        break;
      case 3:
        if (dice_.one_in(4)) cut();
        break;
      case 4:
        if (dice_.one_in(8)) kill(dice_.one_in(2) ? Side::Server : Side::Client);
        break;
      default:
        step(dice_.one_in(2) ? Side::Client : Side::Server);
    }
  }
  settle();
  judge_.sum_up();
  return judge_.alarms();
}

// The beginning

void Schedule::open() {
  ObjectOptions options;
  options.simulated = true;
  options.thread_safe = lanes_ == Lanes::Queued || dice_.one_in(2);
  options.blocking = dice_.one_in(4);
  object_ = std::make_shared<ObjectHost>(runtime_, "BENCH", *handlers_, options);
  served_ = std::make_shared<ServerSession>(line_.connection(Side::Server), object_);

  wire::PacketHeader header;
  header.kind = wire::PacketKind::Hello;
  Hello told = runtime_->introduce(bench());
  // The age of a call would hide this mutant: a call that lay unread for 750 ms is refused.
  if (mutant_ == Mutant::ClosingIsGoodbye) told.accept_within = {};
  Bytes hello;
  write_packet(hello, header, wire::to_bytes(told));
  object_->take(served_, hello);
  line_.forget(Side::Client);  // the welcome, whose content is known here
  Welcome welcome;
  welcome.object = "BENCH";
  welcome.interface_name = bench().name;
  welcome.interface_hash = bench().hash;
  welcome.incarnation = number(process_incarnation());
  welcome.credits = ObjectQueue::most_of_object;
  session_ =
      std::make_shared<ClientConnection>(runtime_, line_.connection(Side::Client), served_->id(),
                                         std::move(welcome), std::vector<FunctionCode>{});
  take_status();
}

void Schedule::take_status() {
  const auto command = own_call(*session_, GecosObjectInterface::acquire,
                                GecosObject_acquire_arguments{gecos::Status::ACTOR, {}});
  const TimePoint give_up = clock_.now() + 10s;
  while (project(command->progress().detail) == State::Running && clock_.now() < give_up) {
    pass(5ms);
    server_step();
    client_ticks();
  }
  Grant grant;
  wire::Decoder from(command->result());
  if (wire::get_block(from, grant, "grant")) session_->lease_acquired(grant.epoch);
}

// Steps

void Schedule::step(Side side) {
  if (!runs(side)) return;
  const Side before = std::exchange(acts_, side);
  if (side == Side::Client) {
    client_step();
    look();
  } else {
    server_step();
  }
  acts_ = before;
  tick();
}

void Schedule::client_step() {
  client_ticks();
  if (!session_) return;
  switch (dice_.below(16)) {
    case 0:
      if (judge_.count() != 0) judge_.command(dice_.below(judge_.count())).cancel();
      return;
    case 1:
      if (session_->lost() && judge_.all_ended()) session_.reset();  // its connection closes
      return;
    case 2:
      if (!dice_.one_in(12)) return;
      if (line_.way() == Way::Radio) judge_.drains();  // a message may be lost, whatever it says
      closes_ = true;
      return session_->close(Duration(1));
    case 3:
    case 4:
      return session_->reader().poll_once();
    default:
      for (auto more = dice_.below(3); more > 0; --more) issue();
  }
}

void Schedule::client_ticks() {
  if (!session_ || !runs(Side::Client) || clock_.now() < client_due_) return;
  static_cast<void>(session_->tick_target().on_tick(clock_.now()));
  client_due_ = clock_.now() + Maintenance::tick;
}

void Schedule::issue() {
  if (judge_.count() == most_commands) return;
  const auto& operations = bench().operations;
  const OperationDescription& operation = operations[dice_.below(operations.size())];
  CallOptions options;
  if (dice_.one_in(4)) options.deadline = dice_.between(10ms, 5s);
  const std::size_t number =
      judge_.issued(operation, clock_.now(), options.deadline.value_or(Duration{}));
  auto command = session_->call(
      operation, 8, [&](wire::Encoder& to) { to.put(static_cast<std::uint64_t>(number)); },
      options);
  command->observe();
  judge_.sent(number, std::static_pointer_cast<PendingCommand>(std::move(command)));
}

void Schedule::server_step() {
  if (clock_.now() >= server_due_) {
    // Whoever wakes first after a pause is not always the one who judges it.
    if (!dice_.one_in(3)) server_maintains();
  }
  switch (dice_.below(6)) {
    case 0:
      return server_finishes();
    case 1:
      return server_begins();
    case 2:
      return server_works();
    default:
      for (auto more = dice_.below(4); more > 0; --more) server_polls();
  }
}

void Schedule::server_polls() {
  std::shared_ptr<ServerCall> started;
  if (served_) {
    if (const auto packet = served_->connection().receive()) {
      started = object_->take_and_start(served_, *packet, Starter::Poller);
    }
  }
  if (started || object_->ready()) object_->run_ready(Starter::Poller, std::move(started));
}

/// As Maintenance, Server and IoLoop do together.
void Schedule::server_maintains() {
  if (const auto stood_still = pauses_.tick(clock_.since_boot())) {
    trace_(clock_.now(), "the server knows that it stood still for", stood_still->count());
    if (served_) object_->await_sign_of_life(*served_);
    object_->after_pause(*stood_still);
    pauses_.judged(clock_.since_boot() + Maintenance::tick);
  }
  const TimePoint now = clock_.now();
  if (served_) {
    served_->sender().flush();
    if (now >= server_beat_due_) {
      served_->connection().beat();
      server_beat_due_ = now + runtime_->options().heartbeat;
    }
    if (object_->check_liveness(served_)) {
      trace_(clock_.now(), "the server has not heard of its client for too long");
      object_->depart(served_, ObjectHost::Departure::Lost);
      served_.reset();
    } else if (served_->connection().loss() != media::Loss::None) {
      part();
    }
  }
  object_->on_tick(now);
  server_due_ = clock_.now() + Maintenance::tick;
  const TimePoint looked = clock_.since_boot();
  static_cast<void>(pauses_.due(looked + Maintenance::tick, looked));  // else it is judged next
}

void Schedule::part() {
  using Departure = ObjectHost::Departure;
  trace_(clock_.now(), "the server parts from its client");
  const bool closed = served_->connection().loss() == media::Loss::Closed;
  while (const auto packet = served_->connection().receive()) object_->take(served_, *packet);
  const auto session = std::exchange(served_, nullptr);
  const bool as_a_goodbye = closed && mutant_ == Mutant::ClosingIsGoodbye;
  object_->depart(session, as_a_goodbye ? Departure::InOrder : Departure::Lost);
  if (object_->ready()) object_->run_ready(Starter::Other);
}

/// A thread that waits for the judgement of a pause takes no step.
void Schedule::server_begins() {
  auto& lane = handlers_->lanes.at(dice_.below(3));
  if (lane.empty() || pauses_.suspected(clock_.seen_by_server())) return;
  IncomingCall call = take(lane, 0);
  if (call.begin()) handlers_->run(std::move(call));
}

void Schedule::server_works() {
  if (posted.empty() || pauses_.suspected(clock_.seen_by_server())) return;
  take(posted, dice_.below(posted.size()))();
}

void Schedule::server_finishes() {
  if (handlers_->running.empty() || pauses_.suspected(clock_.seen_by_server())) return;
  handlers_->finish(dice_.below(handlers_->running.size()));
}

void Schedule::began(const IncomingCall& call) {
  if (!runs(Side::Server)) return;
  if (closes_ && line_.goodbye_heard()) judge_.drains();
  const TimePoint marked = readings_.at(call.marked_at().value());
  judge_.began(Handlers::number_of(call), marked, clock_.now(), freezes_);
}

// Time

void Schedule::pass(Duration most) { clock_.advance(Duration(1 + dice_.below(most.count()))); }

void Schedule::touched(Side by) {
  tick();
  if (by == Side::Client) look();
  if (inside_ || calm_ || !runs(by)) return;
  if (!dice_.one_in(96)) return;
  inside_ = true;
  const auto what = dice_.below(16);
  if (what < 8) {
    freeze(by);
  } else if (what < 10) {
    freeze_both();
  } else if (what == 10) {
    kill(by);
  } else {  // on another core
    for (auto more = 1 + dice_.below(3); more > 0; --more) step(other(by));
  }
  inside_ = false;
}

void Schedule::freeze(Side side) {
  if (line_.way() == Way::Inside) return freeze_both();
  ++freezes_;
  const Duration length = dice_.between(50ms, 10s);
  trace_(clock_.now(), side == Side::Client ? "client" : "server", "stands still for",
         length.count(), inside_ ? "within a step" : "");
  const TimePoint end = clock_.now() + length;
  const Side lives = other(side);
  const bool was_inside = std::exchange(inside_, true);
  while (clock_.now() < end) {
    const bool nothing_more = lives == Side::Client
                                  ? !session_ || (session_->lost() && judge_.all_ended())
                                  : served_ == nullptr;
    if (!runs(lives) || (nothing_more && dice_.one_in(3))) break;
    pass(std::min<Duration>(120ms, end - clock_.now()));
    step(lives);
  }
  inside_ = was_inside;
  if (clock_.now() < end) clock_.advance(end - clock_.now());
  wake(side, length);
}

void Schedule::freeze_both() {
  ++freezes_;
  const Duration length = dice_.between(50ms, 10s);
  trace_(clock_.now(), "both stand still for", length.count(), inside_ ? "within a step" : "");
  clock_.advance(length);
  wake(Side::Client, length);
  wake(Side::Server, length);
}

void Schedule::wake(Side side, Duration stood_still) {
  if (side == Side::Client) return judge_.client_stood_still(stood_still);
  if (mutant_ == Mutant::PauseForgotten) clock_.hide_from_server(stood_still);
  if (stood_still > PauseWatch::longest_gap + 2 * Maintenance::tick) {
    judge_.server_woke(clock_.now());
  }
}

/// The dead are told nothing.
void Schedule::look() {
  if (runs(Side::Client)) judge_.look(clock_.now());
}

void Schedule::cut() {
  const Duration length = dice_.between(50ms, 5s);
  trace_(clock_.now(), "the line is cut for", length.count());
  line_.cut_until(clock_.now() + length);
}

void Schedule::kill(Side side) {
  if (line_.way() == Way::Inside || !runs(Side::Client) || !runs(Side::Server)) return;
  trace_(clock_.now(), side == Side::Client ? "client" : "server", "is killed");
  line_.kill(side);
  if (side == Side::Client) judge_.client_died(clock_.now());
}

/// Nothing stops any more: all that was issued ends.
void Schedule::settle() {
  calm_ = true;
  const TimePoint give_up = clock_.now() + 30s;
  while (runs(Side::Client) && !judge_.all_ended() && clock_.now() < give_up) {
    pass(60ms);
    if (runs(Side::Server)) {
      server_maintains();
      for (int turn = 0; turn < 4; ++turn) server_step();
      server_finishes();
    }
    client_ticks();
    look();
  }
}

}  // namespace schedules
}  // namespace gecos::session
