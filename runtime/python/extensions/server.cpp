// The server classes of the module `_core`: Server, PulledServant, IncomingCall and Broker. Their
// methods take and return values as encoded bytes.
#include "gecos/server.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>
#include <stdexcept>
#include <vector>

#include "bind.hpp"
#include "buffer.hpp"
#include "bytes.hpp"
#include "dynamic_description.hpp"
#include "gecos/base/log.hpp"
#include "gecos/base/mutex.hpp"
#include "gecos/broker/broker.hpp"
#include "gecos/broker/others.hpp"
#include "handles.hpp"
#include "pulled_servant.hpp"

namespace gecos::python {
namespace {

namespace nb = nanobind;

/// A call that Python answers. Only the first answer counts: it moves the call out of `call_`, and
/// later answers are ignored. Answers in a child process that the handler forked are ignored, too,
/// because the parent must answer.
class CallHandle {
 public:
  explicit CallHandle(IncomingCall call) : code_(call.operation().code), call_(std::move(call)) {}
  CallHandle(CallHandle&&) = default;
  ~CallHandle() { static_cast<void>(answer()); }

  std::uint32_t code() const { return number(code_); }
  /// Returns false once the call was answered.
  bool open() const { return call_.has_value(); }
  /// Returns the call. The reference is valid only until this thread releases the GIL, because
  /// another thread may then answer the call. Throws if the call was answered.
  IncomingCall& call() {
    if (!open()) throw nb::value_error("the call was answered already");
    return *call_;
  }
  std::optional<IncomingCall> answer() {
    auto call = std::exchange(call_, std::nullopt);
    if (!owner_.inherited()) return call;
    static_cast<void>(new auto(std::move(call)));
    return std::nullopt;
  }

 private:
  const Owner owner_;
  FunctionCode code_;
  std::optional<IncomingCall> call_;
};

/// A loan that Python fills. A forked child inherits the loan but must not end it, because the
/// memory belongs to the parent.
class LoanHandle {
 public:
  LoanHandle(std::shared_ptr<PulledServant> servant, Loan loan)
      : servant_(std::move(servant)),
        memory_(loan.owner()),
        octets_(loan.octets()),
        loan_(std::make_unique<Loan>(std::move(loan))) {}
  LoanHandle(LoanHandle&&) = default;
  ~LoanHandle() { give_back(); }

  std::span<std::byte> buffer() const { return std::as_writable_bytes(octets_); }
  static constexpr bool writable = true;
  bool publish(std::optional<std::int64_t> stamp_ns) {
    owner_.demand("this loan");
    return loan_->publish(stamp_ns.value_or(measured_now));
  }
  void give_back() {
    if (loan_ == nullptr) return;
    if (owner_.inherited()) return static_cast<void>(loan_.release());
    *loan_ = Loan();
  }

 private:
  Owner owner_;
  std::shared_ptr<PulledServant> servant_;  ///< must outlive the loan
  std::shared_ptr<void> memory_;            ///< a view may use the memory after the end of the loan
  std::span<std::uint8_t> octets_;
  std::unique_ptr<Loan> loan_;
};

class ServantHandle {
 public:
  explicit ServantHandle(std::shared_ptr<PulledServant> servant) : servant_(std::move(servant)) {}
  const std::shared_ptr<PulledServant>& servant() const { return servant_; }

  /// Waits for the next task of a lane. Returns the call, or "stopped" if a client stopped the
  /// object. Returns None when the lane is closed, and in a forked child. Signals do not interrupt
  /// the wait: only the main thread handles signals, and the main thread never calls this method.
  nb::object next(int lane) {
    if (owner_.inherited()) return nb::none();
    auto task = without_gil([&] { return servant_->next(static_cast<Lane>(lane)); });
    if (!task) return nb::none();
    if (auto* const call = std::get_if<IncomingCall>(&*task)) {
      return nb::cast(CallHandle(std::move(*call)));
    }
    return nb::str("stopped");
  }

  nb::object next_inward(std::uint32_t code, bool only_commands) {
    nb::object given = nb::none();
    with_inward(code, [&](session::InwardCore& core) {
      session::RawInward raw;
      const auto unfed = only_commands ? session::Unfed::Refused : session::Unfed::Taken;
      if (!core.next(raw, unfed)) return;
      given = nb::make_tuple(to_python(raw.value), raw.sample.sequence, raw.sample.stamp_ns,
                             raw.age.count(), raw.session, raw.command);
    });
    return given;
  }

  void unreadable(std::uint32_t code, std::uint64_t session, const std::string& why) {
    session::RawInward raw;
    raw.session = session;
    with_inward(code, [&](session::InwardCore& core) { core.unreadable(raw, why); });
  }

  bool inward_expired(std::uint32_t code) {
    bool expired = true;
    with_inward(code, [&](session::InwardCore& core) { expired = core.expired(); });
    return expired;
  }

  nb::bytes inward_report(std::uint32_t code) {
    FeedReport report;
    with_inward(code, [&](session::InwardCore& core) { report = core.report(); });
    return to_python(wire::to_bytes(report));
  }

  std::uint64_t begin_feeding(std::uint32_t code, CallHandle& call) {
    std::uint64_t feeding = 0;
    with_inward(
        code, [&](session::InwardCore& core) { feeding = core.begin_feeding(call.call().core()); });
    return feeding;
  }
  void end_feeding(std::uint32_t code, std::uint64_t feeding) {
    with_inward(code, [&](session::InwardCore& core) { core.end_feeding(feeding); });
  }

  void publish(std::uint32_t code, const nb::bytes& sample, std::optional<std::int64_t> stamp_ns) {
    owner_.demand("this servant");
    if (!servant_->publish(FunctionCode{code}, from_python(sample),
                           stamp_ns.value_or(measured_now))) {
      throw nb::key_error("no stream of the interface has this code");
    }
  }

  /// Returns the loan, or None if the servant is no longer served.
  nb::object lend(std::uint32_t code, const nb::bytes& head, std::size_t octets,
                  const nb::bytes& tail) {
    owner_.demand("this servant");
    if (head.size() < 4) throw nb::value_error("the head has no count");
    auto lent = servant_->lend(FunctionCode{code}, from_python(head), octets, from_python(tail));
    if (!lent) throw nb::value_error(lent.error().c_str());
    if (!*lent) return nb::none();
    return nb::cast(LoanHandle(servant_, *std::move(lent)));
  }

 private:
  void with_inward(std::uint32_t code, FunctionRef<void(session::InwardCore&)> use) const {
    owner_.demand("this servant");
    if (!servant_->with_inward(FunctionCode{code}, use)) {
      throw nb::key_error("no inward stream of the interface has this code");
    }
  }

  const Owner owner_;
  std::shared_ptr<PulledServant> servant_;
};

class ServerHandle {
 public:
  ServerHandle(const LabHandle& lab, bool insecure)
      : lab_(lab.get()),
        server_(
            std::make_shared<Server>(*lab_, insecure ? Admission::Insecure : Admission::Listed)) {}
  ServerHandle(const ServerHandle&) = delete;
  ServerHandle& operator=(const ServerHandle&) = delete;
  ~ServerHandle() { close(); }

  /// Makes a servant, which `add` can serve. Python takes the calls from its lanes. If this server
  /// is closed, the lanes of the servant are closed, too.
  ServantHandle prepare(nb::handle interface) {
    owner_.demand("this Server");
    auto servant = std::make_shared<PulledServant>(description_of(interface));
    if (server_ == nullptr) servant->close();
    return ServantHandle(servants_.emplace_back(std::move(servant)));
  }

  /// Serves a servant that `prepare` made. Returns None, or a text that says why the servant is not
  /// served.
  nb::object add(const ServantHandle& prepared, const std::string& name, bool simulated,
                 const std::vector<std::string>& media) {
    owner_.demand("this Server");
    auto server = server_;  // another thread may call `close` meanwhile
    if (server == nullptr) return nb::str((name + " is not served: the server is closed").c_str());
    ObjectOptions options;
    options.simulated = simulated;
    options.thread_safe = true;  // gecos_dispatch only queues the call
    // gecos/server.py has called await_broker before, so there was a broker. If this broker is
    // restarting now, the patience gives it time to start.
    options.patience = std::chrono::seconds(2);
    for (const std::string& medium : media) {
      const auto kind = media::kind_from(medium);
      if (!kind) {
        throw nb::value_error(
            ("no medium is called '" + medium + "'; choose inproc, shm or lcm").c_str());
      }
      options.media.push_back(*kind);
    }
    const auto servant = prepared.servant();
    options.on_stop = [servant = servant.get()] { servant->stopped(); };
    const auto added = without_gil([&, server = std::move(server)]() mutable {
      const MutexLock lock(serving_);
      auto result = server->add(name, *servant, std::move(options));
      server.reset();  // drops the last reference if `close` was called meanwhile
      return result;
    });
    if (!added) return nb::str(added.error().text.c_str());
    if (server_ != nullptr) return nb::none();
    return nb::str(("the object " + name + " is not served: its server was closed").c_str());
  }

  /// Names the users and hosts that may connect, in addition to the user of this process.
  void allow(std::vector<std::string> users, std::vector<std::string> hosts) {
    owner_.demand("this Server");
    if (server_ != nullptr) server_->allow(std::move(users), std::move(hosts));
  }

  /// Waits for a broker. Returns None if the broker answers. Otherwise returns a text that says why
  /// there is no answer, and where the broker was expected.
  nb::object await_broker(double patience) {
    owner_.demand("this Server");
    std::string why = "the server is closed";
    const auto closed = [this] { return server_ == nullptr; };
    bool found = false;
    const auto wait = [&, held = std::weak_ptr(server_)](TimePoint until) {
      const auto server = held.lock();  // another thread may call `close` meanwhile
      if (server == nullptr) return true;
      const auto answers = server->await_broker(until - SystemClock().now());
      if (!answers) why = answers.error().text;
      found = answers.has_value();
      return found;
    };
    wait_in_slices(patience, wait, closed);
    if (found) return nb::none();
    return nb::str(closed() ? "the server is closed" : why.c_str());
  }

  /// Closes the lanes of a servant that `prepare` made and that will not be served. The servant
  /// itself is kept until the server ends, because the threads of the server may use it until then.
  void forget(const ServantHandle& prepared) {
    without_gil([this, servant = prepared.servant()] {
      const MutexLock lock(serving_);
      servant->close();
      servant->gecos_detach();
    });
  }

  void close() {
    if (owner_.inherited()) {
      static_cast<void>(new auto(std::exchange(server_, nullptr)));
      static_cast<void>(new auto(std::move(servants_)));
      drop(lab_, owner_);
      return;
    }
    without_gil([this, servants = servants_, server = std::exchange(server_, nullptr)]() mutable {
      for (const auto& servant : servants) servant->close();
      const MutexLock lock(serving_);  // waits while another thread adds a servant
      server.reset();
      // `servants_` keeps the servants alive after the server has closed. A servant must not keep
      // the Lab and the Lab's thread alive, so it drops its publisher here.
      for (const auto& servant : servants) servant->gecos_detach();
    });
    drop(lab_, owner_);
  }

 private:
  const Owner owner_;
  std::shared_ptr<Lab> lab_;
  /// This mutex is held while a servant is added or all servants are released. Threads lock it
  /// without the GIL. It guards no member; the GIL guards the members below.
  Mutex serving_;
  std::vector<std::shared_ptr<PulledServant>> servants_;
  std::shared_ptr<Server> server_;  // last member: destroyed before the servants it serves
};

/// A broker in this process, with a server of its own.
class BrokerHandle {
 public:
  BrokerHandle(const LabHandle& lab, double name_hold) : lab_(lab.get()) {
    auto serving = std::make_shared<Serving>(*lab_, broker::BrokerOptions{patience_of(name_hold)});
    const auto added = without_gil([&] { return serving->broker.serve(serving->server); });
    if (!added) throw std::runtime_error(added.error().text);
    serving_ = std::move(serving);
  }
  BrokerHandle(const BrokerHandle&) = delete;
  BrokerHandle& operator=(const BrokerHandle&) = delete;
  ~BrokerHandle() { close(); }

  void close() {
    drop(serving_, owner_);
    drop(lab_, owner_);
  }

 private:
  struct Serving {
    Serving(Lab& lab, const broker::BrokerOptions& options) : broker(options), server(lab) {}
    broker::Broker broker;
    Server server;  // last member: destroyed before the broker, its servant
  };
  const Owner owner_;
  std::shared_ptr<Lab> lab_;
  std::shared_ptr<Serving> serving_;
};

nb::tuple caller(CallHandle& self) {
  const Caller& caller = self.call().caller();
  return nb::make_tuple(caller.user, caller.host, caller.program, caller.pid, caller.session);
}

/// Raises ValueError if another thread answers the call during the wait.
bool wait_interrupted(CallHandle& self, double seconds) {
  auto call = self.call().core();  // `self` drops its call when it is answered
  const bool interrupted = wait_in_slices(
      seconds, [&](TimePoint until) { return call->wait_interrupted_until(until); },
      [&] { return !self.open(); });
  without_gil([last = std::move(call)]() mutable { last.reset(); });
  if (!interrupted) static_cast<void>(self.call());  // throws if the call was answered
  return interrupted;
}

void finish(CallHandle& self, const nb::bytes& result) {
  if (auto call = self.answer()) call->finish(from_python(result));
}

void fail(CallHandle& self, int detail, std::string text, std::string exception,
          const nb::bytes& evidence) {
  const auto known = detail_from(static_cast<std::uint8_t>(detail));
  const ByteView bytes = from_python(evidence);
  if (auto call = self.answer()) {
    call->fail({known.value_or(Detail::Fault), std::move(text), std::move(exception),
                Bytes(bytes.begin(), bytes.end())});
  }
}

}  // namespace

void bind_server(nb::module_& module) {
  nb::class_<ServantHandle>(module, "PulledServant")
      .def("next", &ServantHandle::next, nb::arg("lane"))
      .def("publish", &ServantHandle::publish, nb::arg("code"), nb::arg("sample"),
           nb::arg("stamp_ns").none())
      .def("lend", &ServantHandle::lend, nb::arg("code"), nb::arg("head"), nb::arg("octets"),
           nb::arg("tail"))
      .def("next_inward", &ServantHandle::next_inward, nb::arg("code"), nb::arg("only_commands"))
      .def("unreadable", &ServantHandle::unreadable, nb::arg("code"), nb::arg("session"),
           nb::arg("why"))
      .def("inward_expired", &ServantHandle::inward_expired, nb::arg("code"))
      .def("inward_report", &ServantHandle::inward_report, nb::arg("code"))
      .def("begin_feeding", &ServantHandle::begin_feeding, nb::arg("code"), nb::arg("call"))
      .def("end_feeding", &ServantHandle::end_feeding, nb::arg("code"), nb::arg("feeding"));

  nb::class_<LoanHandle>(module, "Loan", nb::type_slots(BufferSlots<LoanHandle>::slots))
      .def("publish", &LoanHandle::publish, nb::arg("stamp_ns").none())
      .def("give_back", &LoanHandle::give_back);

  nb::class_<CallHandle>(module, "IncomingCall")
      .def_prop_ro("code", &CallHandle::code)
      .def_prop_ro("arguments", [](CallHandle& self) { return to_python(self.call().arguments()); })
      .def("caller", &caller)
      .def_prop_ro("marked_ns",
                   [](CallHandle& self) {
                     const auto at = self.call().marked_at().value_or(TimePoint{});
                     return static_cast<std::int64_t>(at.time_since_epoch().count());
                   })
      .def("interrupted", [](CallHandle& self) { return self.call().interrupted(); })
      .def("wait_interrupted", &wait_interrupted, nb::arg("seconds"))
      .def(
          "progress",
          [](CallHandle& self, double fraction, const nb::bytes& feedback) {
            self.call().progress(fraction, from_python(feedback));
          },
          nb::arg("fraction"), nb::arg("feedback"))
      .def("finish", &finish, nb::arg("result"))
      .def("fail", &fail, nb::arg("detail"), nb::arg("text"), nb::arg("exception"),
           nb::arg("evidence"));

  nb::class_<ServerHandle>(module, "Server")
      .def(nb::init<const LabHandle&, bool>(), nb::arg("lab"), nb::arg("insecure"))
      .def("allow", &ServerHandle::allow, nb::arg("users"), nb::arg("hosts"))
      .def("await_broker", &ServerHandle::await_broker, nb::arg("patience"))
      .def("prepare", &ServerHandle::prepare, nb::arg("interface"))
      .def("add", &ServerHandle::add, nb::arg("prepared"), nb::arg("name"), nb::arg("simulated"),
           nb::arg("media"))
      .def("forget", &ServerHandle::forget, nb::arg("prepared"))
      .def("close", &ServerHandle::close);

  nb::class_<BrokerHandle>(module, "Broker")
      .def(nb::init<const LabHandle&, double>(), nb::arg("lab"), nb::arg("name_hold"))
      .def("close", &BrokerHandle::close);
  module.def("warn_of_other_brokers", [] { without_gil(broker::warn_of_other_brokers); });

  module.def(
      "log_error",
      [](const std::string& component, const std::string& text) { log_error(component, text); },
      nb::arg("component"), nb::arg("text"));
}

}  // namespace gecos::python
