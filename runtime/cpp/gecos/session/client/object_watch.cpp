#include "gecos/object_watch.hpp"

#include <algorithm>
#include <deque>
#include <utility>

#include "gecos/binding.hpp"
#include "gecos/session/client/broker_client.hpp"
#include "gecos/session/client/broker_news.hpp"
#include "gecos/session/client/list_view.hpp"

namespace gecos {

tl::expected<std::vector<Entry>, std::string> find_objects(const Lab& lab,
                                                           std::string_view interface_name,
                                                           Duration patience) {
  const session::LabOrWhyNot& context = session::LabAccess::context(lab);
  if (!context) return tl::unexpected(context.error().text);
  return session::query(**context, std::string(interface_name), deadline_after(patience));
}

/// Asks the broker for the changes of its list whenever `news_` reports that the list may have
/// changed.
class ObjectWatch::Impl {
 public:
  Impl(const session::LabOrWhyNot& lab, std::string interface_name)
      : lab_(lab.value_or(nullptr)), view_(std::move(interface_name)) {
    if (lab_) news_.emplace(lab_);
  }

  std::optional<Registration> next(Duration patience) {
    if (!lab_) return std::nullopt;
    const Clock& clock = lab_->runtime()->clock();
    const TimePoint deadline =
        patience < TimePoint::max() - clock.now() ? clock.now() + patience : TimePoint::max();
    while (unread_.empty()) {
      if (lab_->closed()) return std::nullopt;
      if (must_ask_) ask();
      if (!unread_.empty()) break;
      const auto check = view_.next_check();
      if (news_->wait(check ? std::min(*check, deadline) : deadline)) must_ask_ = true;
      add(view_.missing(clock.now()));
      if (!must_ask_ && unread_.empty() && clock.now() >= deadline) return std::nullopt;
    }
    Registration first = std::move(unread_.front());
    unread_.pop_front();
    return first;
  }
  std::uint64_t skipped() const { return view_.skipped(); }
  bool closed() const { return !lab_ || lab_->closed(); }

 private:
  void ask() {
    // If the broker does not answer, `news_` later reports the next broker or asks for another try.
    must_ask_ = false;
    const auto answer =
        session::list_changes(*lab_, view_.revision(), deadline_after(std::chrono::seconds(2)));
    if (!answer) return;
    add(view_.take(*answer, lab_->runtime()->clock().now()));
  }
  void add(std::vector<Registration> news) { std::ranges::move(news, std::back_inserter(unread_)); }

  const std::shared_ptr<session::Context> lab_;
  session::ListView view_;
  std::optional<session::BrokerNews> news_;
  std::deque<Registration> unread_;
  bool must_ask_ = false;
};

ObjectWatch::ObjectWatch(const Lab& lab, std::string interface_name)
    : impl_(std::make_unique<Impl>(session::LabAccess::context(lab), std::move(interface_name))) {}
ObjectWatch::~ObjectWatch() = default;
std::optional<Registration> ObjectWatch::next(Duration patience) { return impl_->next(patience); }
std::uint64_t ObjectWatch::skipped() const { return impl_->skipped(); }
bool ObjectWatch::closed() const { return impl_->closed(); }

}  // namespace gecos
