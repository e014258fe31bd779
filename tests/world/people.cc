#include "tests/world/people.h"

#include <array>

#include "tests/world/published_rules.h"

namespace faultlab::server::lab::rehearsal {
namespace {

using std::chrono::hours;
using std::chrono::minutes;
using std::chrono::seconds;

constexpr Milliseconds kSlot = minutes(30);
constexpr Milliseconds kCheck = seconds(20);
constexpr Milliseconds kGrain = minutes(1);

/// Only time within opening hours counts; at night the rigs cost nothing.
double OpenSeconds(WallTime from, WallTime to) {
  double open_s = 0.0;
  for (WallTime t = from; t < to; t += kGrain) {
    if (IsOpen(t)) open_s += Seconds(std::min<Milliseconds>(kGrain, to - t));
  }
  return open_s;
}

/// Wishes in the order in which `when` of them comes, until the end.
template <typename When, typename Serve>
void InOrder(int weeks, std::uint64_t seed, const When& when, const Serve& serve) {
  People people(seed);
  std::vector<Wish> wishes;
  for (int user = 0; user < kSemesterUsers; ++user) {
    wishes.push_back(people.Next(user, kWorldStart));
  }
  const WallTime end = kWorldStart + hours(24 * 7 * weeks);
  while (true) {
    auto next = std::min_element(wishes.begin(), wishes.end(), [&](const Wish& a, const Wish& b) {
      return when(a) < when(b);
    });
    const Wish wish = *next;
    if (when(wish) >= end) return;
    *next = people.Next(wish.user, serve(wish, end));
  }
}

WallTime Wanted(const Wish& wish) {
  return wish.ahead ? wish.at + wish.lead : wish.at;
}

}  // namespace

void Tally::Work(int user, WallTime from, WallTime to) {
  got_s[user] += Seconds(to - from);
  useful_open_s += OpenSeconds(from, to);
}

void Tally::Lose(WallTime from, WallTime to) {
  lost_s += OpenSeconds(from, to);
}

WeekFigures Tally::Figures(int weeks) {
  const double capacity_s = kSemesterRigs * 7.0 * weeks * Seconds(kCloses - kOpens);
  WeekFigures figures;
  figures.utilisation = useful_open_s / capacity_s;
  figures.no_show_loss = lost_s / capacity_s;
  figures.served = wishes == 0 ? 1.0 : static_cast<double>(served) / wishes;
  std::sort(waits_min.begin(), waits_min.end());
  if (!waits_min.empty()) {
    figures.median_wait_min = waits_min[waits_min.size() / 2];
    figures.p95_wait_min = waits_min[waits_min.size() * 95 / 100];
  }
  double sum = 0.0;
  double squares = 0.0;
  for (int user = 0; user < kSemesterUsers; ++user) {
    sum += got_s[user];
    squares += got_s[user] * got_s[user];
  }
  figures.jain = squares == 0.0 ? 1.0 : sum * sum / (kSemesterUsers * squares);
  return figures;
}

WeekFigures FirstInFirstOut(int weeks, std::uint64_t seed) {
  Tally tally;
  std::array<WallTime, kSemesterRigs> free{};
  InOrder(weeks, seed, Wanted, [&](const Wish& wish, WallTime end) {
    ++tally.wishes;
    if (wish.no_show) return Wanted(wish);  // does not come, and costs nothing
    WallTime& rig = *std::min_element(free.begin(), free.end());
    const WallTime start = std::max(Wanted(wish), rig);
    const WallTime over = start + wish.length;
    rig = over + kCheck;
    if (over >= end) return over;
    ++tally.served;
    tally.waits_min.push_back(Seconds(start - Wanted(wish)) / 60.0);
    tally.Work(wish.user, start, over);
    return over;
  });
  return tally.Figures(weeks);
}

WeekFigures FixedSlots(int weeks, std::uint64_t seed) {
  Tally tally;
  std::array<std::map<WallTime, bool>, kSemesterRigs> taken;  // slot start
  const auto asked = [](const Wish& wish) { return wish.at; };
  InOrder(weeks, seed, asked, [&](const Wish& wish, WallTime end) {
    ++tally.wishes;
    const WallTime wanted = Wanted(wish);
    const auto slots = (wish.length + kCheck + kSlot - Milliseconds{1}) / kSlot;
    WallTime start = kWorldStart + (wanted - kWorldStart + kSlot - Milliseconds{1}) / kSlot * kSlot;
    std::map<WallTime, bool>* rig = nullptr;
    for (; rig == nullptr; start += kSlot) {
      for (auto& candidate : taken) {
        bool free = true;
        for (int k = 0; k < slots; ++k) free = free && !candidate.contains(start + k * kSlot);
        if (free && rig == nullptr) rig = &candidate;
      }
      if (rig != nullptr) break;
    }
    for (int k = 0; k < slots; ++k) (*rig)[start + k * kSlot] = true;
    const WallTime over = start + wish.length;
    if (wish.no_show) {
      tally.Lose(start, start + slots * kSlot);
      return start + kSlot;
    }
    if (over < end) {
      ++tally.served;
      tally.waits_min.push_back(Seconds(start - wanted) / 60.0);
      tally.Work(wish.user, start, over);
    }
    return over;
  });
  return tally.Figures(weeks);
}

}  // namespace faultlab::server::lab::rehearsal
