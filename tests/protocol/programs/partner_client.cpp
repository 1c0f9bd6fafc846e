// Does what each line of its input says, and prints what came of it; partner_client.py in C++.
//
//   open NAME [PATIENCE]    deadline SECONDS    acquire    release    follow    close
//   issue TAG OPERATION [ARGUMENT]    cancel TAG    look TAG    name TAG

#include "speaking/partner_client.hpp"

#include <algorithm>
#include <iostream>
#include <map>
#include <mutex>
#include <sstream>
#include <thread>

#include "gecos/gecos.hpp"

namespace {

using namespace std::chrono_literals;

void say(std::string text) {
  static std::mutex printing;
  std::replace(text.begin(), text.end(), '\n', ' ');
  const std::lock_guard lock(printing);
  std::cout << text << std::endl;
}

template <class... Parts>
std::string words(const Parts&... parts) {
  std::ostringstream out;
  const char* gap = "";
  ((out << std::exchange(gap, " ") << parts), ...);
  return out.str();
}

/// What the speaker's test writes by itself, too.
speaking::Things constants() {
  speaking::Things things;
  things.numbers = {true,       0xA5,      'g',        -7,   -30000, 60000,      INT32_MIN,
                    UINT32_MAX, INT64_MIN, UINT64_MAX, 0.5F, -1e300, "grüß Gott"};
  things.pace = speaking::Gear::RUN;
  things.grid = {{{1, -2, 3}, {4, 5, -6}}};
  things.words = {"", "two"};
  things.maybe = 2.25;
  things.marks = {{{1.0, 2.0}, "here"}, {{3.0, 4.0}, "there"}};
  things.counts = {{"b", 2}, {"a", -1}};
  things.carried = speaking::Load::make_name("sack");
  things.beside = {9, "beside", 4};
  return things;
}

gecos::Duration seconds(double number) {
  return gecos::Duration(static_cast<std::int64_t>(number * 1e9));
}

/// Byte i is 7 i.
std::vector<std::uint8_t> load_of(std::size_t size) {
  std::vector<std::uint8_t> load(size);
  for (std::size_t i = 0; i < size; ++i) load[i] = static_cast<std::uint8_t>(i * 7);
  return load;
}

std::string why(const gecos::Failure& failure) {
  const auto stuck = failure.as<speaking::Stuck>();
  return stuck ? words("Stuck", stuck->at, stuck->why) : failure.text;
}

class Client {
 public:
  void obey(const std::string& verb, std::istringstream& rest) {
    std::string first;
    rest >> first;
    if (verb == "open") open(first, rest);
    if (verb == "close") close();
    if (verb == "deadline") deadline_ = seconds(std::stod(first));
    if (verb == "acquire") acquire();
    if (verb == "release") release();
    if (verb == "follow") follow();
    if (verb == "issue") issue(first, rest);
    if (verb == "cancel") commands_.at(first)->cancel();
    if (verb == "name") say(words(first, "is", commands_.at(first)->id()));
    if (verb == "look") look(first);
  }

  void close() {
    commands_.clear();
    lease_.reset();
    partner_ = {};
    deadline_ = {};
    reader_ = {};
    say("closed");
  }

 private:
  void open(const std::string& name, std::istringstream& rest) {
    double patience = 2;
    rest >> patience;
    auto created = lab_.create<speaking::Partner>(name, {.patience = seconds(patience)});
    if (!created) return say(words("not opened:", created.error()));
    partner_ = *created;
    say("opened " + name);
  }

  speaking::Partner partner() const { return gecos::with(partner_, {.deadline = deadline_}); }

  void acquire() {
    auto lease = gecos::actor(partner_);
    if (!lease) return say(words("not acquired:", lease.error()));
    lease_.emplace(std::move(*lease));
    say(words("acquired", lease_->epoch()));
  }

  void release() {
    lease_->release();
    say("released");
  }

  void issue(const std::string& tag, std::istringstream& rest) {
    std::string operation;
    std::string argument;
    rest >> operation >> argument;
    const auto number = [&] { return static_cast<std::uint32_t>(std::stoul(argument)); };
    if (operation == "walk") keep(tag, partner().walk(number()));
    if (operation == "mark") keep(tag, partner().mark(number()));
    if (operation == "read") keep(tag, partner().read(number()));
    if (operation == "level") keep(tag, partner().level());
    if (operation == "stop") keep(tag, gecos::stop(partner()));
    if (operation == "ping") keep(tag, gecos::ping(partner()));
    if (operation == "describe") {
      keep(tag, gecos::describe(partner()), [](const auto& about) { return about.name; });
    }
    if (operation == "outcome") {
      keep(tag, gecos::outcome(partner(), *gecos::command_id_from(argument)),
           [](const auto& outcome) { return words(outcome.detail); });
    }
    if (operation == "mirror") {
      auto load = load_of(number());
      auto command = partner().mirror(load);
      std::reverse(load.begin(), load.end());
      keep(tag, command, [load](const auto& got) { return got == load ? "right" : "wrong"; });
    }
    if (operation == "exchange") {
      keep(tag, partner().exchange(things_, "ping"), [this](const auto& got) {
        things_ = got.result;
        return words(got.word, got.count);
      });
    }
  }

  template <class Feedback>
  void keep(const std::string& tag, const gecos::Command<void, Feedback>& command) {
    commands_[tag] = command.core();
    command.then([tag, command](const auto& got) {
      say(words(tag, "ended", command.state(), command.progress().detail,
                got ? "-" : why(got.error())));
    });
  }

  template <class T, class Feedback>
  void keep(const std::string& tag, const gecos::Command<T, Feedback>& command) {
    keep(tag, command, [](const T& got) { return words(got); });
  }

  template <class T, class Feedback, class Show>
  void keep(const std::string& tag, const gecos::Command<T, Feedback>& command, Show show) {
    commands_[tag] = command.core();
    command.then([tag, command, show](const auto& got) {
      say(words(tag, "ended", command.state(), command.progress().detail,
                got ? std::string(show(*got)) : why(got.error())));
    });
  }

  void look(const std::string& tag) {
    const auto& core = commands_.at(tag);
    const gecos::Progress at = core->progress();
    std::string told = words(tag, "stands", at.detail, at.position, at.fraction);
    const auto step = gecos::wire::from_bytes<speaking::Step>(core->feedback());
    say(step ? words(told, step->at, step->where) : told);
  }

  void follow() {
    auto stream = partner_.level(gecos::stream);
    if (!stream) return say(words("not followed:", stream.error()));
    say("follows");
    reader_ = std::jthread([stream](const std::stop_token& over) mutable {
      while (!over.stop_requested()) {
        const auto got = stream->next(20ms);
        if (got) {
          say(words("sample", got->sequence, got->lost, got->value));
        } else if (got.error() != gecos::StreamEnd::Nothing) {
          return say(words("stream", to_string(got.error())));
        }
      }
    });
  }

  gecos::Lab lab_;
  speaking::Partner partner_;
  std::optional<gecos::Duration> deadline_;
  std::optional<gecos::Lease> lease_;
  speaking::Things things_ = constants();
  std::map<std::string, std::shared_ptr<gecos::session::CommandCore>> commands_;
  std::jthread reader_;
};

}  // namespace

int main() {
  {
    Client client;
    say("ready");
    for (std::string line; std::getline(std::cin, line);) {
      std::istringstream rest(line);
      std::string verb;
      rest >> verb;
      client.obey(verb, rest);
    }
    client.close();
  }
  say("done");
}
