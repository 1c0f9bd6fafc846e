// The server's side of sessions whose clients send what they like.
#include <array>
#include <map>
#include <mutex>
#include <set>
#include <vector>

#include "gecos/media/inproc/inproc.hpp"
#include "gecos/session/protocol/builtin.hpp"
#include "gecos/session/protocol/packets.hpp"
#include "gecos/session/server/object_host.hpp"
#include "gecos/wire/fields.hpp"
#include "packet_target.hpp"
#include "probe.hpp"
#include "scripted_connection.hpp"

namespace gecos::fuzz {
namespace {

using namespace gecos::session;
using Kind = wire::PacketKind;

bool moves(const OperationDescription& operation) {
  return operation.status != access::Status::Sensor;
}

/// Does with a call what its serial number says, now or when the script says so. Calls of what is
/// cancelable come on threads of the object.
class Servant final : public gecos::Servant {
 public:
  const InterfaceDescription& gecos_interface() const override { return probe::description(); }
  void gecos_dispatch(IncomingCall call) override {
    std::uint64_t serial = 0;
    wire::Decoder from(call.arguments());
    // The flags may say that the body begins with a ChainReport; then the number is taken for one.
    const bool numbered = from.get(serial, "serial");
    {
      const std::lock_guard lock(mutex_);
      if (numbered) expect(started_.insert(serial).second, "a call starts at most once");
      if (moves(call.operation())) {
        expect(!moving_, "one command of an object runs at a time");
        expect(granted_.contains(call.caller().session), "a command runs under a status");
      }
      if (serial % 3 == 0) {
        moving_ = moving_ || moves(call.operation());
        kept_.push_back(std::move(call));
        return;
      }
    }
    answer(std::move(call), serial);
  }
  void grant(SessionId session) {
    const std::lock_guard lock(mutex_);
    granted_.insert(number(session));
  }
  void go_on_with_one(Script& script) {
    std::unique_lock lock(mutex_);
    if (kept_.empty()) return;
    const std::size_t which = script.byte() % kept_.size();
    IncomingCall call = std::move(kept_[which]);
    kept_.erase(kept_.begin() + static_cast<std::ptrdiff_t>(which));
    const bool only_tells = script.one_in(3);
    if (!only_tells && moves(call.operation())) moving_ = false;
    lock.unlock();
    if (!only_tells) return answer(std::move(call), script.byte());
    call.progress(static_cast<double>(script.byte()) / 200, script.bytes(16));
    lock.lock();
    kept_.push_back(std::move(call));
  }
  void drop_kept() {
    std::vector<IncomingCall> dropped;
    const std::lock_guard lock(mutex_);
    moving_ = false;
    dropped.swap(kept_);
  }

 private:
  static void answer(IncomingCall call, std::uint64_t how) {
    switch (how % 4) {
      case 0:
        return call.fail(Fault::rejected("no").failure());
      case 1:
        return call.fail(Fault(probe::Jammed{}).failure());
      case 2:
        return call.finish(Bytes(3000));  // more than the line carries
      case 3:
        return call.finish(Bytes(4));
    }
  }

  std::mutex mutex_;
  std::vector<IncomingCall> kept_;
  std::set<std::uint64_t> started_;
  std::set<std::uint64_t> granted_;
  bool moving_ = false;
};

std::shared_ptr<media::Acceptor> the_acceptor() {
  static const auto medium = media::make_inproc();
  static const std::shared_ptr<media::Acceptor> acceptor = medium->listen("FUZZED", false).value();
  return acceptor;
}

class Client {
 public:
  Client(std::shared_ptr<ObjectHost> object, Servant& servant, bool reliable)
      : object_(std::move(object)), servant_(servant) {
    auto connection = std::make_unique<ScriptedConnection>(reliable);
    connection_ = connection.get();
    session_ = std::make_shared<ServerSession>(std::move(connection), object_);
    connection_->heard = [this](const wire::PacketView& packet) { hear(packet); };
    greet("probe::Probe");
  }
  ~Client() { connection_->heard = nullptr; }

  const std::shared_ptr<ServerSession>& session() const { return session_; }

  void act(Script& script, const Client& other, std::uint64_t& serial) {
    switch (script.below(16)) {
      case 0:
        return take(script.bytes(120));
      case 1: {
        const Bytes name = script.bytes(30);
        if (script.one_in(2)) return greet("probe::Device");
        return greet({reinterpret_cast<const char*>(name.data()), name.size()});
      }
      case 2:
        connection_->full = !connection_->full;
        return;
      case 3:
        session_->sender().flush();
        return;
      case 4:
        ++connection_->beats;
        return;
      case 5:
        connection_->age_of_packets = Duration(script.number() >> 1);
        return;
      default:
        return send(script, other, serial);
    }
  }
  void depart(ObjectHost::Departure how) { object_->depart(session_, how); }

 private:
  void take(ByteView packet) {
    object_->take(session_, packet);
    object_->run_ready(Starter::Poller);
    expect(session_->intake.aside() <= ObjectQueue::most_of_object,
           "what came too early is bounded");
  }
  void greet(std::string interface_name) {
    Hello hello;
    hello.user = "mallory";
    hello.interface_name = std::move(interface_name);
    hello.accept_within = std::chrono::seconds(1);
    wire::PacketHeader header;
    header.kind = wire::PacketKind::Hello;
    take(wire::encode_packet(header, wire::to_bytes(hello)));
  }

  void send(Script& script, const Client& other, std::uint64_t& serial) {
    static constexpr std::array usual = {Kind::Call,   Kind::Call,  Kind::Call,   Kind::Call,
                                         Kind::Cancel, Kind::Query, Kind::Goodbye};
    static constexpr std::array codes = {probe::read_code,   probe::move_code,
                                         probe::set_code,    probe::urgent_code,
                                         probe::finish_code, probe::missing_code};
    wire::PacketHeader header;
    header.kind =
        script.one_in(16) ? static_cast<Kind>(script.byte()) : usual[script.below(usual.size())];
    if (script.one_in(32)) header.version = static_cast<std::int8_t>(script.byte());
    header.flags = static_cast<std::int8_t>(script.byte());
    const std::size_t which = script.below(codes.size() + 11);
    const auto builtin = static_cast<std::uint32_t>(which - codes.size());
    header.code = which < codes.size() ? codes[which] : FunctionCode{builtin};
    header.session = script.one_in(16)   ? SessionId{script.number()}
                     : script.one_in(16) ? other.session_->id()
                                         : session_->id();
    header.counter = script.one_in(16)  ? script.number()
                     : script.one_in(2) ? ++newest_
                                        : newest_ + script.below(5) - 2;
    header.acknowledged = script.one_in(4)   ? newest_ - script.below(4)
                          : script.one_in(8) ? script.number()
                                             : 0;
    header.epoch = script.one_in(8) ? Epoch{script.number()} : epoch_;
    header.deadline = script.one_in(4) ? Duration(script.number() >> 1) : Duration{};
    if (header.kind == Kind::Goodbye && !script.one_in(4)) return;  // it would be over too soon
    if (header.kind != Kind::Call) return take(bent(script, header, script.bytes(20)));
    Bytes body(8);
    if (is_builtin(header.code)) {
      body = builtin_body(script, other, header.code);
      if (header.code == GecosObjectInterface::acquire.code) asked_.insert(header.counter);
    } else {
      // Whoever repeats a call repeats it as it was; then it may arrive any number of times.
      auto& as = serials_[{number(header.session), header.counter}];
      if (as == 0 || connection_->capabilities().reliable) as = ++serial;
      wire::Encoder(body).put(as);
    }
    take(wire::encode_packet(header, body));
  }

  Bytes builtin_body(Script& script, const Client& other, FunctionCode which) {
    if (script.one_in(8)) return script.bytes(40);
    Bytes body(24);
    wire::Encoder to(body);
    if (which == GecosObjectInterface::acquire.code) {
      to.put(static_cast<std::int32_t>(script.below(4)));
      to.put(script.one_in(4));
      to.put_string("pw");
    } else if (which == GecosObjectInterface::release.code) {
      to.put(number(epoch_));
      to.put(script.one_in(2));
    } else if (which == GecosObjectInterface::outcome.code) {
      to.put(script.one_in(8) ? script.number() : number(process_incarnation()));
      to.put(number(script.one_in(2) ? other.session_->id() : session_->id()));
      to.put(newest_ - script.below(4));
    } else {
      to.put(number(probe::level_code));
    }
    body.resize(to.written());
    return body;
  }

  void hear(const wire::PacketView& packet) {
    const auto detail = detail_from(static_cast<std::uint8_t>(packet.header.flags));
    switch (packet.header.kind) {
      case Kind::Welcome:
        expect(packet.header.session != SessionId{}, "a session has a number");
        return;
      case Kind::Refused:
      case Kind::Goodbye:
        return;
      case Kind::Progress:
        expect(detail && project(*detail) == State::Running, "what makes progress runs");
        return;
      case Kind::Reply: {
        expect(detail && project(*detail) != State::Running, "a reply is an end");
        expect(packet.header.session == session_->id(), "who asked is answered");
        Grant grant;
        wire::Decoder from(packet.body);
        if (detail != Detail::Done || !asked_.contains(packet.header.counter)) return;
        if (!wire::get_block(from, grant, "grant")) return;
        servant_.grant(session_->id());
        epoch_ = Epoch{grant.epoch};
        return;
      }
      default:
        expect(false, "a server says nothing else");
    }
  }

  const std::shared_ptr<ObjectHost> object_;
  Servant& servant_;
  ScriptedConnection* connection_ = nullptr;
  std::shared_ptr<ServerSession> session_;
  std::uint64_t newest_ = 0;
  Epoch epoch_{};
  std::set<std::uint64_t> asked_;  // counters of calls that ask for a status
  std::map<std::pair<std::uint64_t, std::uint64_t>, std::uint64_t> serials_;
};

}  // namespace

void try_served(Script script) {
  Servant servant;
  ObjectOptions options;
  options.thread_safe = script.one_in(2);
  const bool reliable = script.one_in(2);
  const auto object = std::make_shared<ObjectHost>(the_runtime(), "FUZZED", servant, options);
  object->streams().offer(the_acceptor());
  {
    Client first(object, servant, reliable);
    Client second(object, servant, reliable);
    std::uint64_t serial = 0;
    for (int step = 0; step < 300 && !script.over(); ++step) {
      switch (script.below(12)) {
        case 0:
          servant.go_on_with_one(script);
          break;
        case 1:
          the_clock().advance(std::chrono::milliseconds(script.byte() * 4));
          object->on_tick(the_clock().now());
          break;
        case 2:
          for (Client* client : {&first, &second}) {
            if (object->check_liveness(client->session()))
              client->depart(ObjectHost::Departure::Lost);
          }
          break;
        case 3:
          object->publish(probe::description().streams[0], script.bytes(4), 1);
          break;
        case 4:
          if (script.one_in(32)) object->close();
          break;
        case 5:
          if (script.one_in(32)) first.depart(ObjectHost::Departure::InOrder);
          break;
        case 6:
        case 7:
        case 8:
          second.act(script, first, serial);
          break;
        default:
          first.act(script, second, serial);
      }
    }
    first.depart(ObjectHost::Departure::InOrder);
    second.depart(ObjectHost::Departure::Lost);
    object->close();
    servant.drop_kept();
    object->join();
    for (const Client* client : {&first, &second}) {
      expect(client->session()->calls.size() == 0, "every call comes to an end");
      expect(client->session()->intake.aside() == 0, "nothing that came too early is left");
    }
  }
}

}  // namespace gecos::fuzz
