// SPDX-License-Identifier: GPL-2.0
/* Values and lines of benches/paper.toml. The current follows the voltage at once (La / R = 0.1
 * ms). */
#include <linux/kernel.h>
#include <linux/math64.h>

#include "motor.h"

#define STEP_NS 50000

#define RA_MOHM 7410
#define KE_UV_S_PER_RAD 25500 /* and KT: nNm per mA */
#define J_PNM_S2 143          /* 1e-8 kg m^2 */
#define B_NNM_S_X10 18        /* 0.1 uNm s/rad */
#define MC_PNM 330000000LL
#define MS_PNM 400000000LL
#define R5_OHM 1000
#define R10_OHM 10000
#define R14_R15_OHM 2000

enum board { R1, R9, R12, C8, BOARDS };

struct part {
  int line;
  s64 value; /* ohm, picofarad */
};

static const struct part parts[BOARDS][4] = {
    [R1] = {{17, 1}, {16, 10}, {1, 56}, {0, 100}},
    [R9] = {{19, 10000}, {18, 33000}, {3, 56000}, {2, 100000}},
    [R12] = {{6, 10000}, {7, 5600}, {22, 3300}, {23, 2000}},
    [C8] = {{21, 47}, {20, 1000000}, {5, 10000000}, {4, 47000000}},
};

int motor_contacts(u32 levels, int board) {
  int i, n = 0;

  for (i = 0; i < 4; ++i) n += !(levels >> parts[board][i].line & 1);
  return n;
}

/* Milliohm of the connected resistors in parallel; 0: none. */
static s64 parallel_mohm(u32 levels, int board) {
  s64 nano_siemens = 0;
  int i;

  for (i = 0; i < 4; ++i)
    if (!(levels >> parts[board][i].line & 1)) nano_siemens += 1000000000LL / parts[board][i].value;
  return nano_siemens ? div64_s64(1000000000000LL, nano_siemens) : 0;
}

static s64 sum_pf(u32 levels) {
  s64 pf = 0;
  int i;

  for (i = 0; i < 4; ++i)
    if (!(levels >> parts[C8][i].line & 1)) pf += parts[C8][i].value;
  return pf;
}

static void step(struct motor* m, s64 ns, s64 r1_mohm, s64 re1_ohm, s64 re2_ohm, s64 tau_ns) {
  s64 wanted_nv, torque_pnm, friction_pnm, before = m->speed_urad_s;

  if (re2_ohm)
    wanted_nv = div64_s64(m->uc_uv * re2_ohm, re1_ohm) * 1000;
  else /* open feedback */
    wanted_nv = m->uc_uv > 1000 ? m->rail_max_uv * 1000 : 0;
  if (tau_ns <= ns)
    m->lag_nv = wanted_nv;
  else
    m->lag_nv += div64_s64((wanted_nv - m->lag_nv) * (ns / 1000), tau_ns / 1000);
  m->ua_uv = m->lag_nv / 1000;
  if (re2_ohm) m->ua_uv += div64_s64((wanted_nv - m->lag_nv) / 1000 * R5_OHM, re2_ohm + R5_OHM);
  m->ua_uv = clamp(m->ua_uv, m->rail_min_uv, m->rail_max_uv);

  /* uV / mohm = mA, so times 1000 before */
  m->ia_ua = r1_mohm ? div64_s64((m->ua_uv - KE_UV_S_PER_RAD * m->speed_urad_s / 1000000) * 1000,
                                 r1_mohm + RA_MOHM)
                     : 0;
  m->um_uv = m->ua_uv - m->ia_ua * r1_mohm / 1000;
  if (!r1_mohm) m->um_uv = KE_UV_S_PER_RAD * m->speed_urad_s / 1000000;

  torque_pnm = KE_UV_S_PER_RAD * m->ia_ua;
  friction_pnm = before > 0 ? MC_PNM : before < 0 ? -MC_PNM : torque_pnm > 0 ? MC_PNM : -MC_PNM;
  if (before == 0 && abs(torque_pnm) <= MS_PNM) return;
  m->speed_urad_s += div64_s64(
      (torque_pnm - friction_pnm - before * B_NNM_S_X10 / 10) * 100 / J_PNM_S2 * (ns / 1000),
      1000000);
  if (before != 0 && (before > 0) != (m->speed_urad_s > 0)) m->speed_urad_s = 0;
  m->angle_nrad += div64_s64((before + m->speed_urad_s) / 2 * (ns / 1000), 1000);
}

void motor_switch(struct motor* m, u32 levels) {
  const s64 stays_pf = sum_pf(m->levels | levels), pf = sum_pf(levels);

  if (pf > stays_pf) m->lag_nv = m->lag_nv / 1000 * (stays_pf / 1000) / (pf / 1000 + 1) * 1000;
  m->levels = levels;
}

void motor_advance(struct motor* m, u64 ns) {
  const s64 r1_mohm = parallel_mohm(m->levels, R1);
  const s64 r9_ohm = parallel_mohm(m->levels, R9) / 1000;
  const s64 r12_ohm = parallel_mohm(m->levels, R12) / 1000;
  const s64 re1_ohm = r9_ohm ? div64_s64(r9_ohm * R10_OHM, r9_ohm + R10_OHM) : R10_OHM;
  const s64 re2_ohm = r12_ohm ? r12_ohm + R14_R15_OHM : 0;
  const s64 tau_ns = div64_s64((re2_ohm + R5_OHM) * sum_pf(m->levels), 1000);

  while (ns > 0) {
    const u64 part = min_t(u64, ns, STEP_NS);

    if (part >= 1000) step(m, part, r1_mohm, re1_ohm, re2_ohm, tau_ns);
    ns -= part;
  }
}

s64 motor_pulses(const struct motor* m) {
  s64 turns_x1000 = div64_s64(m->angle_nrad * 100, 628319); /* angle / 2 pi, in 1e-6 */

  /* 1 turn = 6.28319e9 nrad -> 1e6; a pulse is a thousandth of a turn */
  return turns_x1000 >= 0 ? turns_x1000 / 1000 : -((-turns_x1000 + 999) / 1000);
}
