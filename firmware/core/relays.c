#include "relays.h"

#include "board.h"
#include "board_config.h"

enum phase { SETTLED, GAP, SETTLING };

static struct {
  uint32_t written;
  uint32_t target;
  uint16_t since; /* board_time of the stage */
  uint16_t gap;   /* steps */
  uint16_t settle;
  uint8_t phase;
} relays;

/* One more, because the first step may be as good as over. */
static uint16_t steps(uint16_t us) {
  return (uint16_t)((us + STEP_US - 1u) / STEP_US + 1u);
}

static void write(uint32_t lines, uint8_t phase) {
  relays.written = lines;
  relays.phase = phase;
  relays.since = board_time();
  board_relays_write(lines);
}

void relays_set_times(uint16_t gap_us, uint16_t settle_us) {
  relays.gap = steps(gap_us);
  relays.settle = steps(settle_us);
}

void relays_begin(void) {
  relays_set_times(3000, 3000);
  relays.target = SAFE_LINES;
  write(SAFE_LINES, SETTLING);
}

void relays_go(uint32_t lines) {
  relays.target = lines;
  if (lines == relays.written && relays.phase == SETTLED) return;
  const uint32_t both = relays.written & lines;
  const uint32_t either = relays.written | lines;
  write((both & ~MAKE_FIRST_LINES) | (either & MAKE_FIRST_LINES), GAP);
}

bool relays_hold(uint32_t read_back) {
  return (read_back & RELAY_LINES) == relays.written;
}

bool relays_poll(void) {
  if (relays.phase == SETTLED) return true;
  const uint16_t wait = relays.phase == GAP ? relays.gap : relays.settle;
  if ((uint16_t)(board_time() - relays.since) < wait) return true;
  if (!relays_hold(board_relays_read())) {
    relays.phase = SETTLED;
    return false;
  }
  if (relays.phase == GAP) {
    write(relays.target, SETTLING);
  } else {
    relays.phase = SETTLED;
  }
  return true;
}

bool relays_settled(void) {
  return relays.phase == SETTLED;
}
