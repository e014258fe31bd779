/* SPDX-License-Identifier: GPL-2.0 */
/* The paper's bench in whole numbers: amplifier, R1, motor, encoder, with the relays as switched.
 */
#ifndef MOTOR_H
#define MOTOR_H

#include <linux/types.h>

#define MOTOR_LINES 24

struct motor {
  /* inputs, held */
  s64 uc_uv;
  u32 levels; /* of the relay lines, 0 connects a part; set by motor_switch */
  s64 rail_min_uv, rail_max_uv;
  /* state */
  s64 lag_nv; /* voltage of the amplifier that C8 delays */
  s64 speed_urad_s;
  s64 angle_nrad;
  /* outputs */
  s64 ua_uv, um_uv, ia_ua;
};

/* The relays connect other parts. A capacitor is uncharged when it is connected. */
void motor_switch(struct motor* m, u32 levels);
/* Advances by `ns` nanoseconds, in steps of at most 50 us. */
void motor_advance(struct motor* m, u64 ns);
/* Pulses of an encoder of 1000 a revolution, backwards negative. */
s64 motor_pulses(const struct motor* m);
/* Parts that the relays of a board connect: 0 R1, 1 R9, 2 R12, 3 C8. */
int motor_contacts(u32 levels, int board);

#endif
