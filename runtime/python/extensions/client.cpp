// The client classes of the module `_core`: Lab, Session, Command, Stream and Lease. Their methods
// take and return values as encoded bytes.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>

#include "bind.hpp"
#include "buffer.hpp"
#include "bytes.hpp"
#include "dynamic_description.hpp"
#include "gecos/binding.hpp"
#include "gecos/object_interface.hpp"  // generated from idl/gecos/object.gidl
#include "handles.hpp"
#include "waiting.hpp"

namespace gecos::python {
namespace {

namespace nb = nanobind;

/// A proxy that has no interface. It can call the built-in operations, which every object has.
struct AnyObject : Object {
  explicit AnyObject(std::shared_ptr<session::ClientSession> session)
      : Object(std::move(session)) {}
};

nb::tuple as_tuple(const Failure& failure) {
  return nb::make_tuple(static_cast<int>(failure.detail), failure.text, failure.exception,
                        to_python(failure.evidence));
}

// Lab --------------------------------------------------------------------------------------------

nb::list attempts_of(const CreateError& error) {
  nb::list attempts;
  for (const CreateError::Attempt& attempt : error.attempts) {
    attempts.append(nb::make_tuple(attempt.name, static_cast<int>(attempt.detail), attempt.reason));
  }
  return attempts;
}

/// The arguments `medium`, `in_` and `out` of `Lab.create`. Each is the name of a medium, or
/// absent.
using Channels =
    std::tuple<std::optional<std::string>, std::optional<std::string>, std::optional<std::string>>;

/// The quality that a program requests: class, reliability, deadline and lifespan in s, whether the
/// liveliness is MANUAL.
using Requested = std::tuple<int, int, double, double, bool>;

qos::RequestedQuality requested_quality(const Requested& requested) {
  const auto& [line, reliability, deadline, lifespan, manual] = requested;
  return {.line = static_cast<qos::Class>(line),
          .reliability = static_cast<qos::Reliability>(reliability),
          .deadline = patience_of(deadline),
          .lifespan = patience_of(lifespan),
          .liveliness = manual ? qos::Liveliness::Manual : qos::Liveliness::Automatic};
}

std::optional<media::Kind> medium_called(const std::optional<std::string>& name) {
  if (!name) return std::nullopt;
  if (const auto kind = media::kind_from(*name)) return kind;
  throw nb::value_error(("no medium is called '" + *name + "'; choose inproc, shm or lcm").c_str());
}

nb::object create(LabHandle& self, nb::handle interface, const std::vector<std::string>& names,
                  const Channels& channels, double latency, const Requested& quality,
                  double patience, std::uint64_t incarnation, double wait) {
  CreateOptions options;
  options.latency = patience_of(latency);
  options.quality = requested_quality(quality);
  options.incarnation = incarnation;
  options.patience = patience_of(patience);
  const Duration longest_wait = patience_of(wait);
  const auto& [medium, in, out] = channels;
  options.medium = medium_called(medium);
  options.in = medium_called(in);
  options.out = medium_called(out);
  const InterfaceDescription& wanted = description_of(interface);
  const auto attempt = [&] {
    return run_interruptibly([lab = self.get(), &wanted, names, options] {
      return session::try_create(session::LabAccess::context(*lab), wanted, names, options);
    });
  };
  auto created = attempt();
  if (!created && longest_wait > Duration::zero()) {
    const auto drop_it = [](session::CreateWait* it) { without_gil([it] { delete it; }); };
    const std::unique_ptr<session::CreateWait, decltype(drop_it)> waiting(
        new session::CreateWait(session::LabAccess::context(*self.get()), names, longest_wait),
        drop_it);
    while (!created && waiting->helps(created.error())) {
      wait_in_slices(std::nullopt, [&](TimePoint until) { return waiting->wait(until); });
      created = attempt();
    }
  }
  if (!created) return attempts_of(created.error());
  return nb::cast(self.keep(std::make_shared<SessionHandle>(std::move(created->session), wanted)));
}

nb::list terms_of(const std::vector<qos::Violation>& violations) {
  nb::list terms;
  for (const auto& [term, why] : violations) terms.append(nb::make_tuple(term, why));
  return terms;
}

nb::object explain(LabHandle& self, nb::handle interface, const std::string& name,
                   double patience) {
  CreateOptions options;
  options.patience = patience_of(patience);
  const InterfaceDescription& wanted = description_of(interface);
  const auto told = run_interruptibly([lab = self.get(), &wanted, name, options] {
    return session::explain(session::LabAccess::context(*lab), wanted, name, options);
  });
  if (!told) return attempts_of(told.error());
  nb::list media;
  for (const MediumVerdict& each : told->media) {
    nb::list members;
    for (const UnsuitedMember& member : each.members) {
      members.append(nb::make_tuple(member.name, terms_of(member.violations), member.samples_only));
    }
    media.append(nb::make_tuple(each.medium, each.address, each.unreachable,
                                terms_of(each.violations), members, each.real_time_by));
  }
  return nb::make_tuple(told->interface_name, told->hostname, told->simulated, media);
}

/// Returns the session of the Lab with its broker, or a text that says why there is none.
nb::object broker(LabHandle& self, nb::handle interface, double patience) {
  const InterfaceDescription& wanted = description_of(interface);
  auto opened =
      run_interruptibly([lab = self.get(), until = deadline_after(patience_of(patience))] {
        return session::broker_session(session::LabAccess::context(*lab), until);
      });
  if (!opened) return nb::str(opened.error().c_str());
  return nb::cast(self.keep(std::make_shared<SessionHandle>(std::move(*opened), wanted)));
}

/// Returns a session with the object at `address`, or a text that says why there is none.
nb::object session_at(LabHandle& self, nb::handle interface, const std::string& address,
                      double patience) {
  const InterfaceDescription& wanted = description_of(interface);
  auto opened =
      run_interruptibly([lab = self.get(), address, until = deadline_after(patience_of(patience))] {
        return session::session_at(session::LabAccess::context(*lab), address, until);
      });
  if (!opened) return nb::str(opened.error().c_str());
  return nb::cast(self.keep(std::make_shared<SessionHandle>(std::move(*opened), wanted)));
}

// Session ----------------------------------------------------------------------------------------

std::optional<Duration> deadline_of(std::optional<double> seconds) {
  if (!seconds) return std::nullopt;
  return *seconds > 0 ? std::max(patience_of(seconds), Duration{1}) : Duration{};
}

CommandHandle call(SessionHandle& self, std::uint32_t code, nb::bytes arguments,
                   std::optional<double> deadline) {
  const OperationDescription* operation = self.table().find(FunctionCode{code});
  if (operation == nullptr) operation = GecosObjectInterface::description.find(FunctionCode{code});
  if (operation == nullptr) {
    throw nb::key_error(
        ("no operation of " + std::string(self.table().name) + " has this code").c_str());
  }
  const ByteView body = from_python(arguments);
  return CommandHandle(self.get()->call(
      *operation, body.size(), [&](wire::Encoder& to) { to.put_bytes(body); },
      CallOptions{deadline_of(deadline)}));
}

nb::tuple reference(const SessionHandle& self) {
  const ObjectRef about = self.about().reference();
  return nb::make_tuple(about.name, about.interface_hash, about.boot, about.where);
}

CommandHandle outcome(SessionHandle& self, const std::string& command) {
  const auto id = command_id_from(command);
  if (!id) {
    throw nb::value_error(("'" + command +
                           "' is not the id of a command: give the three hexadecimal numbers, "
                           "joined by '-', that command.id returns")
                              .c_str());
  }
  return CommandHandle(gecos::outcome(AnyObject(self.get()), *id).core());
}

nb::object subscribe(SessionHandle& self, std::uint32_t code) {
  const StreamDescription* const stream = self.table().find_stream(FunctionCode{code});
  if (stream == nullptr) {
    throw nb::key_error(
        ("no stream of " + std::string(self.table().name) + " has this code").c_str());
  }
  auto opened =
      run_interruptibly([session = self.get(), stream] { return session->subscribe(*stream); });
  if (opened) return nb::cast(StreamHandle(std::move(*opened)));
  return nb::make_tuple(static_cast<int>(opened.error().detail), opened.error().text);
}

nb::object open_writer(SessionHandle& self, std::uint32_t code) {
  const InwardDescription* const stream = self.table().find_inward_stream(FunctionCode{code});
  if (stream == nullptr) {
    throw nb::key_error(
        ("no inward stream of " + std::string(self.table().name) + " has this code").c_str());
  }
  auto opened =
      run_interruptibly([session = self.get(), stream] { return session->open_writer(*stream); });
  if (opened) return nb::cast(WriterHandle(std::move(*opened)));
  return nb::make_tuple(static_cast<int>(opened.error().detail), opened.error().text);
}

/// Sends a sample. Returns None, or the detail and the text of the failure.
nb::object send(const WriterHandle& self, const nb::bytes& sample,
                std::optional<std::int64_t> stamp_ns) {
  const auto core = self.get();
  if (core == nullptr) {
    return nb::make_tuple(static_cast<int>(Detail::NotStarted),
                          "a sample was not sent: the writer is closed; open a new one");
  }
  const ByteView body = from_python(sample);
  const auto sent = core->send(
      body.size(), [&](wire::Encoder& to) { to.put_bytes(body); }, stamp_ns.value_or(measured_now));
  if (sent) return nb::none();
  return nb::make_tuple(static_cast<int>(sent.error().detail), sent.error().text);
}

void feeds(const WriterHandle& self, const std::optional<std::string>& command) {
  const auto core = self.get();
  if (core == nullptr) return;
  if (!command) return core->feeds(std::nullopt);
  core->feeds(command_id_from(*command).value_or(CommandId{}));
}

CommandHandle ask_for_status(SessionHandle& self, int status, const std::string& password,
                             double timeout) {
  return CommandHandle(session::ask_for_status(*self.get(), static_cast<Status>(status), password,
                                               patience_of(timeout)));
}

/// Returns the lease that the command `asked` acquired, or the failure of that command. The command
/// must have ended.
nb::object lease(SessionHandle& self, const CommandHandle& asked) {
  auto got = session::lease_from(self.get(), asked.core());
  if (got) return nb::cast(LeaseHandle(std::move(*got)));
  return as_tuple(got.error().failure);
}

// Command and stream -----------------------------------------------------------------------------

nb::tuple as_tuple(const Progress& progress) {
  return nb::make_tuple(static_cast<int>(progress.detail), progress.position, progress.fraction);
}

/// Returns the progress of a command, for `repr` and warnings. Unlike `progress`, does not mark the
/// command as observed.
nb::tuple peek(const CommandHandle& self) { return as_tuple(self.awaited().progress()); }

nb::tuple progress(const CommandHandle& self) {
  const Progress progress = self.awaited().progress();
  self.core().observe();
  self.core().note_look(progress.detail);
  return as_tuple(progress);
}

bool wait(const CommandHandle& self, std::optional<double> timeout) {
  std::optional<session::WaitsHere> endless;
  if (!timeout) endless.emplace(self.awaited());
  return wait_in_slices(timeout, [&](TimePoint until) { return self.awaited().wait_until(until); });
}

/// Waits for the end of the command, at most for `timeout`. Returns the encoded result, or the
/// number of the detail if there is no result.
nb::object answer(const CommandHandle& self, std::optional<double> timeout) {
  wait(self, timeout);
  const Detail detail = self.core().progress().detail;
  self.core().note_look(detail);
  if (detail == Detail::Done) return to_python(self.core().result());
  return nb::int_(static_cast<int>(detail));
}

nb::tuple as_tuple(const session::RawSample& sample) {
  return nb::make_tuple(to_python(sample.bytes), sample.sequence, sample.stamp_ns,
                        sample.measured.time_since_epoch().count());
}

/// Returns why a stream is lost; an empty text if its Lab is closed.
nb::str loss_text(const StreamHandle& self) {
  const auto core = self.get();
  return nb::str(core == nullptr ? "" : core->loss_text().c_str());
}

nb::tuple as_tuple(session::RawLent sample) {
  const auto sequence = sample.sequence;
  const auto stamp_ns = sample.stamp_ns;
  const auto measured = sample.measured.time_since_epoch().count();
  return nb::make_tuple(nb::cast(LentHandle{std::move(sample)}), sequence, stamp_ns, measured);
}

/// Calls `read` and returns the newest sample as a tuple. Returns None if there is no sample, and
/// the text "lost" or "revoked" if the stream is lost.
nb::object latest_by(StreamHandle& self, FunctionRef<nb::object(session::StreamCore&)> read) {
  const auto core = self.get();
  if (core == nullptr) return nb::none();
  nb::object sample = read(*core);
  if (sample.is_none() && core->lost()) return nb::str(core->revoked() ? "revoked" : "lost");
  return sample;
}

nb::object latest(StreamHandle& self) {
  return latest_by(self, [&](session::StreamCore& core) -> nb::object {
    if (!self.position().latest(core)) return nb::none();
    return as_tuple(self.position().sample());
  });
}

nb::object latest_in_place(StreamHandle& self) {
  return latest_by(self, [&](session::StreamCore& core) -> nb::object {
    session::RawLent lent;
    if (!self.position().lend_latest(core, lent)) return nb::none();
    return as_tuple(std::move(lent));
  });
}

/// Returns the samples that are kept now as tuples, oldest first.
nb::list history(const StreamHandle& self) {
  nb::list samples;
  const auto core = self.get();
  if (core == nullptr) return samples;
  for (const auto& sample : without_gil([&] { return core->history(); })) {
    samples.append(as_tuple(sample));
  }
  return samples;
}

using Got = tl::expected<void, StreamEnd>;

/// Waits for the next sample of a stream. `read` reads the sample without the GIL, and `given` then
/// converts it to a tuple. Returns this tuple, or one word that says why no sample came: "closed",
/// "nothing" after `timeout`, "lost", "revoked" or "late".
nb::object next_by(StreamHandle& self, std::optional<double> timeout,
                   FunctionRef<Got(session::StreamCore&, TimePoint)> read,
                   FunctionRef<nb::tuple()> given) {
  auto core = self.get();
  if (core == nullptr) return nb::str("closed");
  Got got = tl::unexpected(StreamEnd::Nothing);
  wait_in_slices(
      timeout,
      [&](TimePoint until) {
        got = read(*core, until);
        return got || got.error() != StreamEnd::Nothing;
      },
      [&] { return self.get() == nullptr; });  // another thread closed the stream
  if (self.get() == nullptr) {
    without_gil([last = std::move(core)]() mutable { last.reset(); });
    return nb::str("closed");
  }
  if (got) return given();
  switch (got.error()) {
    case StreamEnd::Nothing:
      return nb::str("nothing");
    case StreamEnd::Lost:
      return nb::str("lost");
    case StreamEnd::Revoked:
      return nb::str("revoked");
    case StreamEnd::Late:
      return nb::str("late");
  }
  return nb::str("lost");
}

nb::object next(StreamHandle& self, std::optional<double> timeout) {
  return next_by(
      self, timeout,
      [&](session::StreamCore& core, TimePoint until) { return self.position().next(core, until); },
      [&] { return as_tuple(self.position().sample()); });
}

nb::object next_in_place(StreamHandle& self, std::optional<double> timeout) {
  session::RawLent lent;
  return next_by(
      self, timeout,
      [&](session::StreamCore& core, TimePoint until) {
        return self.position().lend_next(core, lent, until);
      },
      [&] { return as_tuple(std::move(lent)); });
}

double seconds(Duration duration) { return std::chrono::duration<double>(duration).count(); }

nb::tuple as_tuple(const LineState& line) {
  nb::object took = nb::none();
  if (line.round_trip) took = nb::float_(seconds(*line.round_trip));
  return nb::make_tuple(line.medium, seconds(line.bound), took, line.degraded, line.changes,
                        line.moved_from, line.why);
}

/// Waits until the number of changes of the session's connection exceeds `changes`, which is the
/// number that the caller last read. Returns the state of the connection after the change. Returns
/// True if there was no change within `timeout`, and False if the session is lost or closed.
nb::object next_line_change(SessionHandle& self, std::uint64_t changes,
                            std::optional<double> timeout) {
  LineState line;
  bool ended = false;
  wait_in_slices(timeout, [&, session = self.get()](TimePoint until) {
    line = session->await_line_change(changes, until);
    ended = line.changes <= changes && SystemClock().now() < until;
    return line.changes > changes || ended;
  });
  if (line.changes > changes) return as_tuple(line);
  return nb::bool_(!ended);
}

nb::tuple counts(const StreamHandle& self) {
  const qos::StreamCounts counts = self.counts();
  return nb::make_tuple(counts.received, counts.lost, counts.skipped, counts.expired,
                        counts.missed_deadlines);
}

// Objects ----------------------------------------------------------------------------------------

WatchHandle watch(LabHandle& self, const std::string& interface_name) {
  return WatchHandle(std::make_shared<ObjectWatch>(*self.get(), interface_name));
}

/// Returns the encoded objects online, or a text that says why the broker gave no answer.
nb::object objects(LabHandle& self, const std::string& interface_name, double patience) {
  auto found = run_interruptibly([lab = self.get(), interface_name, patience] {
    return find_objects(*lab, interface_name, patience_of(patience));
  });
  if (!found) return nb::str(found.error().c_str());
  nb::list encoded;
  for (const Entry& entry : *found) encoded.append(to_python(wire::to_bytes(entry)));
  return encoded;
}

/// Waits for the next change of the broker's list and returns the change as an encoded
/// Registration. Returns True if there was no change within `timeout`, and False if the watch or
/// its Lab was closed.
nb::object next_change(WatchHandle& self, std::optional<double> timeout) {
  auto watch = self.get();
  if (watch == nullptr) return nb::bool_(false);
  std::optional<Registration> change;
  bool ended = false;
  wait_in_slices(
      timeout,
      [&](TimePoint until) {
        change = watch->next(std::max(until - SystemClock().now(), Duration::zero()));
        ended = watch->closed();
        return change.has_value() || ended;
      },
      [&] { return self.get() == nullptr; });  // another thread closed the watch
  without_gil([last = std::move(watch)]() mutable { last.reset(); });
  if (!change) return nb::bool_(!ended && self.get() != nullptr);
  return to_python(wire::to_bytes(*change));
}

}  // namespace

void bind_client(nb::module_& module) {
  nb::class_<LabHandle>(module, "Lab")
      .def(
          "__init__",
          [](LabHandle* self, const std::string& broker, const std::string& program) {
            LabOptions options;
            options.broker = broker;
            options.program = program;
            new (self) LabHandle(std::move(options));
          },
          nb::arg("broker"), nb::arg("program"))
      .def("explain", &explain, nb::arg("interface"), nb::arg("name"), nb::arg("patience"))
      .def("create", &create, nb::arg("interface"), nb::arg("names"), nb::arg("channels"),
           nb::arg("latency"), nb::arg("quality"), nb::arg("patience"), nb::arg("incarnation"),
           nb::arg("wait"))
      .def("broker", &broker, nb::arg("interface"), nb::arg("patience"))
      .def("session_at", &session_at, nb::arg("interface"), nb::arg("address"), nb::arg("patience"))
      .def("objects", &objects, nb::arg("interface_name"), nb::arg("patience"))
      .def("watch", &watch, nb::arg("interface_name"))
      .def("close", &LabHandle::close);

  nb::class_<WatchHandle>(module, "ObjectWatch")
      .def("next", &next_change, nb::arg("timeout").none())
      .def("skipped",
           [](const WatchHandle& self) {
             const auto watch = self.get();
             return watch ? watch->skipped() : 0;
           })
      .def("close", &WatchHandle::close);

  nb::class_<SessionHandle>(module, "Session")
      .def_prop_ro("object_name", [](const SessionHandle& s) { return s.about().object_name(); })
      .def_prop_ro("interface_name",
                   [](const SessionHandle& s) { return s.about().interface_name(); })
      .def_prop_ro(
          "medium",
          [](const SessionHandle& s) { return std::string(s.about().capabilities().name); })
      .def("reference", &reference)
      .def("line", [](SessionHandle& self) { return as_tuple(self.get()->line()); })
      .def("next_line_change", &next_line_change, nb::arg("changes"), nb::arg("timeout").none())
      .def("call", &call, nb::arg("code"), nb::arg("arguments"), nb::arg("deadline").none())
      .def("subscribe", &subscribe, nb::arg("code"))
      .def("open_writer", &open_writer, nb::arg("code"))
      .def("outcome", &outcome, nb::arg("command"))
      .def("ask_for_status", &ask_for_status, nb::arg("status"), nb::arg("password"),
           nb::arg("timeout"))
      .def("lease", &lease, nb::arg("asked"))
      .def(
          "decline_status",
          [](SessionHandle& self, const CommandHandle& asked) {
            session::decline_status(self.get(), asked.shared());
          },
          nb::arg("asked"))
      .def("close", &SessionHandle::close);

  nb::class_<CommandHandle>(module, "Command")
      .def("id", [](const CommandHandle& c) { return to_string(c.core().id()); })
      .def("about", [](const CommandHandle& c) { return c.core().about(); })
      .def("ignore_outcome", [](const CommandHandle& c) { c.core().ignore_outcome(); })
      .def("observe", [](const CommandHandle& c) { c.core().observe(); })
      .def("inherited", &CommandHandle::inherited)
      .def("observed", [](const CommandHandle& c) { return c.core().observed(); })
      .def("peek", &peek)
      .def("progress", &progress)
      .def("feedback", [](const CommandHandle& c) { return to_python(c.awaited().feedback()); })
      .def("wait", &wait, nb::arg("timeout").none())
      .def("cancel", [](const CommandHandle& c) { c.awaited().cancel(); })
      .def("answer", &answer, nb::arg("timeout").none())
      .def("failure",
           [](const CommandHandle& c) {
             c.core().observe();
             c.core().note_look(c.core().progress().detail);
             return as_tuple(c.core().failure());
           })
      .def("peek_failure", [](const CommandHandle& c) { return as_tuple(c.core().failure()); })
      .def("descriptor", [](const CommandHandle& c) { return c.awaited().descriptor(); });

  nb::class_<StreamHandle>(module, "Stream")
      .def_prop_ro("after", [](const StreamHandle& self) { return self.get()->after(); })
      .def("latest", &latest)
      .def("next", &next, nb::arg("timeout").none())
      .def("latest_in_place", &latest_in_place)
      .def("next_in_place", &next_in_place, nb::arg("timeout").none())
      .def("history", &history)
      .def("counts", &counts)
      .def("alive",
           [](const StreamHandle& self) {
             const auto core = self.get();
             return core != nullptr && core->alive();
           })
      .def("loss_text", &loss_text)
      .def("close", &StreamHandle::close);

  nb::class_<LentHandle>(module, "LentSample", nb::type_slots(BufferSlots<LentHandle>::slots))
      .def("intact", [](const LentHandle& self) { return self.sample.intact(); });

  nb::class_<WriterHandle>(module, "Writer")
      .def("send", &send, nb::arg("sample"), nb::arg("stamp_ns").none())
      .def("feeds", &feeds, nb::arg("command").none())
      .def("lost",
           [](const WriterHandle& self) {
             const auto core = self.get();
             return core == nullptr || core->lost();
           })
      .def("close", &WriterHandle::close);

  nb::class_<LeaseHandle>(module, "Lease")
      .def_prop_ro("status", &LeaseHandle::status)
      .def_prop_ro("epoch", &LeaseHandle::epoch)
      .def("fresh", &LeaseHandle::fresh)
      .def("lost", &LeaseHandle::lost)
      .def("release", &LeaseHandle::release)
      .def("release_now", &LeaseHandle::release_now);
}

}  // namespace gecos::python
