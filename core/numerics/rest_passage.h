#pragma once

namespace faultlab::core {

/// The mean of the sign of a speed over a stretch of time, in which Coulomb friction acts against
/// it: between -1 and 1 where the motor comes to rest or reverses. `before`: the speed at the start
/// of the stretch; `free`: at its end, without friction; `held` >= 0: how much friction changes the
/// speed in the whole stretch; `kept`: the share of a speed that is left after it. While friction
/// acts one way the speed settles exponentially; each part of the stretch counts by what is left of
/// it at the end. For a double or several side by side (lanes.h), as all of this file.
template <class Lane>
[[gnu::always_inline]] inline Lane MeanDirection(Lane before, Lane free, Lane held, Lane kept) {
  const Lane zero{};
  const Lane one = zero + 1.0;
  const Lane drive = free - kept * before;  // what the drive alone adds
  const Lane lead = before == zero ? drive : before;
  const Lane way = lead < zero ? -one : one;
  const Lane after = free - way * held;
  // Passes through rest: before it friction acts along `way`, then against the drive.
  const Lane linear = before / (before - after);  // share of the time, if the speed were linear
  const Lane share = kept * linear / (one - linear * (one - kept));
  const Lane back = drive < zero ? -one : one;
  const Lane reversed = back + (way - back) * share;
  const Lane size = drive < zero ? -drive : drive;
  const Lane passing = held < size ? reversed : free / held;
  return after * way < zero ? passing : way;
}

/// How much of a whole passage through rest a stretch is: 0 for a motor that turns one way or
/// stands, 1 where it spends half of it on each side. Continuous. `s`: MeanDirection of the same.
template <class Lane>
[[gnu::always_inline]] inline Lane PassageShare(
    Lane before, Lane free, Lane held, Lane kept, Lane s) {
  const Lane zero{};
  const Lane drive = free - kept * before;
  const Lane size = drive < zero ? -drive : drive;
  const Lane leaves = held < size ? 1.0 - held / size : zero;
  return (1.0 - s * s) * leaves;
}

/// Both over a period in which the input changes once: a motor near rest may turn around twice.
/// `edge_free` and `edge_held`: the speed without friction, and what friction changes it by, at
/// that edge; `edge_kept` and `later_kept`: MeanDirection's, before and after it. `passage`:
/// PassageShare, as a variance.
template <class Lane>
[[gnu::always_inline]] inline void ActFriction(Lane before,
                                               Lane edge_free,
                                               Lane free,
                                               Lane edge_held,
                                               Lane held,
                                               Lane edge_kept,
                                               Lane later_kept,
                                               Lane& direction,
                                               Lane& passage) {
  const Lane zero{};
  const Lane first = MeanDirection(before, edge_free, edge_held, edge_kept);
  const Lane edge = edge_free - first * edge_held;
  const Lane first_held = later_kept * edge_held;  // at the end
  const Lane later_held = held > first_held ? held - first_held : zero;
  const Lane later_free = free - first * first_held;
  const Lane later = MeanDirection(edge, later_free, later_held, later_kept);
  const Lane share = held > first_held ? first_held / held : zero;
  direction = later + (first - later) * share;
  const Lane rest = 1.0 - share;
  passage = share * share * PassageShare(before, edge_free, edge_held, edge_kept, first) +
            rest * rest * PassageShare(edge, later_free, later_held, later_kept, later);
}

}  // namespace faultlab::core
