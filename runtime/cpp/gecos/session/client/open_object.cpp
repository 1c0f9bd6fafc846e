#include <algorithm>
#include <utility>

#include "gecos/session/client/connect.hpp"
#include "gecos/session/client/context.hpp"
#include "gecos/session/client/select.hpp"

namespace gecos::session {
namespace {

using Attempt = CreateError::Attempt;
using Opened = tl::expected<std::shared_ptr<ClientConnection>, Attempt>;

/// Maximum time for measuring the latency of one medium.
constexpr Duration longest_measurement = std::chrono::seconds(2);
/// Maximum time of a search for another medium, in which a session must be opened. The time is
/// short, because the calls that wait for another server also wait for the end of this search.
constexpr Duration longest_search = std::chrono::seconds(1);

/// Returns the name of a channel for messages, such as "RX90 (in=lcm)"; only "RX90" when the
/// program did not choose a medium for the channel.
std::string channel_name(const std::string& object, std::string_view channel,
                         std::optional<media::Kind> named) {
  if (!named) return object;
  return object + " (" + std::string(channel) + "=" + std::string(media::to_string(*named)) + ")";
}

/// Opens the session for one call of `create`, over the best medium that meets the demands of the
/// interface and of the program.
class ObjectConnector {
 public:
  ObjectConnector(Context& lab, const InterfaceDescription& wanted, const Entry& entry,
                  const std::string& name, const CreateOptions& options, StatedMedia stated)
      : lab_(lab),
        wanted_(wanted),
        entry_(entry),
        name_(name),
        options_(options),
        stated_(std::move(stated)) {}

  /// Makes a later failover use `options` instead of the options of this session.
  void set_options_of_successors(const CreateOptions& options) { later_options_ = &options; }

  /// Opens a session over the medium `only`, or over the best medium if `only` has no value.
  /// `channel` names the object and the channel in the text of a failure, for example "RX90
  /// (in=lcm)". `without`: a medium that must not be used.
  Opened over(std::optional<media::Kind> only, const std::string& channel, TimePoint deadline,
              std::optional<media::Kind> without = {}) const {
    Selection selection(*lab_.runtime(), entry_, demanded(), stated_, only, without);
    const std::vector<Route> routes = selection.best_first();
    Attempt failed{name_, Detail::NoServer, {}};
    bool unsuitable = routes.empty();
    for (Route route : routes) {
      auto session = connect(*lab_.runtime(), route.address, wanted_, deadline, &failed.detail,
                             [this](ClientConnection& opened) { prepare(opened); });
      if (!session) {
        failed.reason += (failed.reason.empty() ? "" : "; ") + session.error();
        selection.not_reached(route, session.error());
        if (failed.detail == Detail::Refused) return tl::unexpected(std::move(failed));
        continue;
      }
      if (!suits(**session, route, selection)) {
        unsuitable = true;
        continue;
      }
      if (lab_.keep(*session)) return *std::move(session);
      return tl::unexpected(closed_lab(name_));  // the lab was closed meanwhile
    }
    if (unsuitable) {
      return tl::unexpected(
          Attempt{name_, Detail::QosUnavailable, channel + " " + selection.why_none()});
    }
    const std::string& left_out = selection.left_out();
    failed.reason = channel + " cannot be reached" + (without ? " over another medium (" : " (") +
                    failed.reason + (left_out.empty() ? "" : "; " + left_out) + ")";
    return tl::unexpected(std::move(failed));
  }

 private:
  /// Returns the quality that the interface as a whole and the program demand of the medium. The
  /// latency that the program demands also applies to a simulated device.
  qos::Quality demanded() const {
    qos::Quality demanded = demanded_of(wanted_.quality, entry_.simulated, options_.quality);
    if (options_.latency <= Duration{}) return demanded;
    demanded.line = std::max(demanded.line, qos::Class::SoftRealtime);
    const bool stricter = demanded.latency <= Duration{} || options_.latency < demanded.latency;
    if (stricter) demanded.latency = options_.latency;
    return demanded;
  }
  /// Returns the bound of the latency that LineProbe checks while the session is open; zero if
  /// there is no bound.
  Duration bound() const {
    const Duration of_interface = smallest_latency(wanted_, options_.quality);
    if (options_.latency <= Duration{}) return of_interface;
    if (of_interface <= Duration{}) return options_.latency;
    return std::min(of_interface, options_.latency);
  }
  bool measures() const {
    const bool by_interface =
        !entry_.simulated && smallest_latency(wanted_, options_.quality) > Duration{};
    return by_interface || options_.latency > Duration{};
  }
  void prepare(ClientConnection& session) const {
    session.failover().set(lab_.failover(), {name_, wanted_, *later_options_});
    session.request(options_.quality);
    session.line_probe().bound_by(bound(), wanted_, entry_.simulated);
  }
  /// Measures the latency of `session` if the interface or the program demands a latency. If the
  /// connection is too slow, closes the session and returns false.
  bool suits(ClientConnection& session, Route& route, Selection& selection) const {
    if (measures()) {
      route.line.latency =
          session.line_probe().measure(std::min(longest_measurement, options_.patience));
    }
    if (!selection.measured(route)) {
      session.close(Duration{});
      return false;
    }
    session.check_quality(wanted_, route.line, entry_.simulated);
    return true;
  }

  Context& lab_;
  const InterfaceDescription& wanted_;
  const Entry& entry_;
  const std::string& name_;
  const CreateOptions& options_;
  const StatedMedia stated_;
  const CreateOptions* later_options_ = &options_;
};

}  // namespace

StatedMedia stated_media(Context& lab, const InterfaceDescription& wanted, const Entry& entry,
                         TimePoint deadline, const qos::RequestedQuality& requested) {
  if (!demands_hard_real_time(wanted, entry.simulated, requested)) return {};
  return lab.lab_media(deadline);
}

Opened open_object(Context& lab, const InterfaceDescription& wanted, const std::string& name,
                   const CreateOptions& options) {
  const TimePoint deadline = deadline_after(options.patience);
  const auto entry = find_entry(lab, wanted, name, options);
  if (!entry) return tl::unexpected(entry.error());
  const ObjectConnector connector(lab, wanted, *entry, name, options,
                                  stated_media(lab, wanted, *entry, deadline, options.quality));
  const auto in = options.in ? options.in : options.medium;
  auto session = connector.over(options.out ? options.out : options.medium,
                                channel_name(name, "out", options.out), deadline);
  if (!session || !in || *in == media::kind_of((*session)->place())) return session;
  auto inbound = connector.over(in, channel_name(name, "in", options.in), deadline);
  if (!inbound) return inbound;
  (*session)->receive_over(*std::move(inbound));
  return session;
}

Opened open_elsewhere(Context& lab, ClientConnection& slow) {
  const ConnectTarget& target = slow.failover().connect_target();
  CreateOptions options = target.options;
  options.patience = std::min(options.patience, longest_search);
  options.latency = slow.line().bound;
  options.incarnation = slow.welcome().incarnation;
  const TimePoint deadline = deadline_after(options.patience);
  const auto entry = find_entry(lab, target.wanted, target.name, options);
  if (!entry) return tl::unexpected(entry.error());
  ObjectConnector connector(lab, target.wanted, *entry, target.name, options,
                            stated_media(lab, target.wanted, *entry, deadline, options.quality));
  connector.set_options_of_successors(target.options);
  return connector.over({}, target.name, deadline, media::kind_of(slow.place()));
}

}  // namespace gecos::session
