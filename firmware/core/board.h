#pragma once

#include <stdbool.h>
#include <stdint.h>

/* What a board gives to the core, and what it calls. board_config.h, beside the board's sources,
 * has its constants:
 *   PLAN_VALUES, HISTORY_SAMPLES, RELAY_ENTRIES   sizes of the buffers
 *   PERIOD_MIN_US, PERIOD_MAX_US, CONVERT_US      what its timer and its converters can do
 *   UC_*, UM_*, UA_*, IA_*                        codes, as INFO tells them
 *   RELAY_LINES, SAFE_LINES, MAKE_FIRST_LINES     bit i is line Do<i>, 1 connects
 *   CAPABILITIES, FIRMWARE_VERSION */

/* Puts the code of uc out, at once. From the tick and from the main loop. */
void board_drive(int16_t code);
/* Connects exactly these lines. */
void board_relays_write(uint32_t lines);
/* The lines as they are behind the drivers, not as they were written. */
uint32_t board_relays_read(void);

/* The first tick comes within a millisecond, the next ones each `period_us`. Each is followed,
 * `delta_us` later, by a conversion whose middle lies there. */
void board_timer_start(uint32_t period_us, uint32_t delta_us);
void board_timer_stop(void);

/* Steps of 250 us; wraps. */
uint16_t board_time(void);
#define STEPS_PER_MS 4u
#define STEP_US 250u

/* All or nothing; false when there is no room now. */
bool board_send(const uint8_t* bytes, uint8_t length);

/* Keeps interrupts off between the two. */
uint8_t board_lock(void);
void board_unlock(uint8_t before);

struct board_reading {
  int16_t um;
  int16_t ua;
  int16_t ia;
  int32_t count;         /* of encoder pulses, signed */
  uint16_t edge_age_us;  /* from the newest pulse to the count; EDGE_NONE: none in this period */
  int16_t gate_count;    /* pulses during the conversions, and the time between the newest pulse */
  uint16_t gate_tenth_us; /* before them and the newest of them; 0: not known */
  uint32_t converted_us; /* from the tick to the middle of the conversions */
};
