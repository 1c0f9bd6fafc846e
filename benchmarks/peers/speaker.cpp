#include "speaker.hpp"

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <exception>
#include <iostream>
#include <sstream>
#include <stdexcept>
#include <thread>
#include <vector>

namespace peers {

Nanoseconds quantile(std::vector<Nanoseconds>& times, double part) {
  const auto at =
      times.begin() + static_cast<std::ptrdiff_t>(static_cast<double>(times.size() - 1) * part);
  std::nth_element(times.begin(), at, times.end());
  return *at;
}

Nanoseconds of_the_clock() {
  std::vector<Nanoseconds> times;
  for (auto before = Clock::now(); times.size() < 10'000;) {
    const auto after = Clock::now();
    times.push_back(after - before);
    before = after;
  }
  return quantile(times, 0.5);
}

Summary time_bursts(Seconds how_long, const std::function<void()>& once) {
  constexpr int burst = 100;
  std::vector<Nanoseconds> times;
  for (const auto end = Clock::now() + how_long; Clock::now() < end;) {
    const auto before = Clock::now();
    for (int i = 0; i < burst; ++i) once();
    times.push_back((Clock::now() - before) / burst);
  }
  const auto clock = of_the_clock() / burst;
  return {times.size() * burst, (quantile(times, 0.5) - clock).count(),
          (quantile(times, 0.99) - clock).count()};
}

namespace {

void say(const Summary& what) { std::printf("%zu %.1f %.1f\n", what.count, what.p50, what.p99); }

void say(std::vector<Nanoseconds>& times) {
  const auto clock = of_the_clock();
  say(Summary{times.size(), (quantile(times, 0.5) - clock).count(),
              (quantile(times, 0.99) - clock).count()});
}

using Call = Sample (Client::*)(const Sample&);

/// One call with a number that the answer must carry.
void exchange(Client& client, Sample& sample, Call call = &Client::call) {
  sample.stamp += 1;
  if ((client.*call)(sample).stamp != sample.stamp)
    throw std::runtime_error("the answer belongs to another call");
}

void trips(Client& client, Seconds how_long, Call call) {
  std::vector<Nanoseconds> times;
  times.reserve(1 << 22);
  Sample sample;
  auto before = Clock::now();
  const auto end = before + how_long;
  while (before < end) {
    exchange(client, sample, call);
    const auto after = Clock::now();
    times.push_back(after - before);
    before = after;
  }
  say(times);
}

void silent(Client& client, Seconds rest, std::size_t count) {
  std::vector<Nanoseconds> times;
  Sample sample;
  while (times.size() < count) {
    std::this_thread::sleep_for(rest);
    const auto before = Clock::now();
    exchange(client, sample);
    times.push_back(Clock::now() - before);
  }
  say(times);
}

void late(Client& client, Seconds each, Seconds how_long) {
  Sample sample;
  std::size_t count = 0;
  for (const auto end = Clock::now() + how_long; Clock::now() < end; ++count) {
    client.call_late(sample, each);
  }
  std::printf("%zu\n", count);
}

void follow(Client& client, Seconds how_long) {
  std::size_t count = 0;
  for (const auto end = Clock::now() + how_long; Clock::now() < end; ++count) {
    client.look();
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  std::printf("%zu\n", count);
}

void outstanding(Client& client, unsigned number, Seconds how_long) {
  const auto begin = Clock::now();
  const auto calls =
      client.calls_until(begin + std::chrono::duration_cast<Clock::duration>(how_long), number);
  std::printf("%.1f\n", static_cast<double>(calls) / Seconds(Clock::now() - begin).count());
}

void answer(Client& client, const std::string& line) {
  std::istringstream words(line);
  std::string word;
  double first = 0;
  double second = 0;
  words >> word >> first >> second;
  if (word == "trips" && first > 0) {
    trips(client, Seconds(first), &Client::call);
  } else if (word == "unchecked" && first > 0) {
    trips(client, Seconds(first), &Client::call_unchecked);
  } else if (word == "silent" && second >= 1) {
    silent(client, Seconds(first), static_cast<std::size_t>(second));
  } else if (word == "late" && second > 0) {
    late(client, Seconds(first), Seconds(second));
  } else if (word == "look" && first > 0) {
    say(time_bursts(Seconds(first), [&] { client.look(); }));
  } else if (word == "follow" && first > 0) {
    follow(client, Seconds(first));
  } else if (word == "publish" && first > 0) {
    say(client.publish(Seconds(first)));
  } else if (word == "outstanding" && first >= 1 && second > 0) {
    outstanding(client, static_cast<unsigned>(first), Seconds(second));
  } else {
    throw std::invalid_argument("asked for \"" + line + "\"; speaker.hpp says what can be asked");
  }
}

}  // namespace

Sample Client::call_unchecked(const Sample& /*sample*/) {
  throw std::logic_error("this peer has no call that is not checked");
}

Sample Client::call_late(const Sample& /*sample*/, Seconds /*late*/) {
  throw std::logic_error("this peer has no call that is answered late");
}

void Client::look() { throw std::logic_error("this peer has no stream to look at"); }

Summary Client::publish(Seconds /*how_long*/) {
  throw std::logic_error("this peer has no stream that it publishes");
}

std::uint64_t PipeliningClient::calls_until(Clock::time_point end, unsigned outstanding) {
  Sample sample;
  std::uint64_t answered = 0;
  const auto next = [&] {
    sample.stamp += 1;
    issue(sample);
  };
  const auto take = [&] {
    if (collect().stamp != static_cast<double>(++answered))
      throw std::runtime_error("the answer belongs to another call");
  };
  for (unsigned i = 0; i < outstanding; ++i) next();
  while (Clock::now() < end) {
    take();
    next();
  }
  for (unsigned i = 0; i < outstanding; ++i) take();
  return answered;
}

std::uint64_t calls_of_threads(Clock::time_point end, unsigned threads,
                               const std::function<void()>& call) {
  std::atomic<std::uint64_t> answered{0};
  std::vector<std::thread> callers;
  for (unsigned i = 0; i < threads; ++i) {
    callers.emplace_back([&] {
      for (; Clock::now() < end; answered.fetch_add(1, std::memory_order_relaxed)) call();
    });
  }
  for (auto& caller : callers) caller.join();
  return answered;
}

void say_ready(const std::string& address) {
  std::printf("ready %s\n", address.c_str());
  std::fflush(stdout);
}

int speak_lines(int argc, char** argv, const std::function<void(const std::string&)>& serve,
                const std::function<Answer(const std::string&, const std::string&)>& connect) {
  const std::string what = argc > 1 ? argv[1] : "";
  try {
    if (what == "serve" && argc == 3) {
      serve(argv[2]);
    } else if (what == "call" && argc == 4) {
      const Answer answer = connect(argv[2], argv[3]);
      say_ready("");
      for (std::string line; std::getline(std::cin, line);) {
        answer(line);
        std::fflush(stdout);
      }
    } else {
      throw std::invalid_argument("usage: serve HOW | call HOW ADDRESS");
    }
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: %s\n", argv[0], error.what());
    return 1;
  }
  return 0;
}

int speak(
    int argc, char** argv, const std::function<void(const std::string&)>& serve,
    const std::function<std::unique_ptr<Client>(const std::string&, const std::string&)>& connect) {
  return speak_lines(argc, argv, serve, [&](const std::string& how, const std::string& address) {
    const std::shared_ptr<Client> client = connect(how, address);
    return [client](const std::string& line) { answer(*client, line); };
  });
}

}  // namespace peers
