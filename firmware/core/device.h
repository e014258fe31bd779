#pragma once

#include <stdint.h>

#include "board.h"
#include "messages.h"

/* The device side of hardware/device/PROTOCOL.md: states, plan, relays, watchdog. Knows no
 * register of any board. */

/* After the board is safe, before interrupts. */
void device_begin(uint8_t reset_cause);
/* From the main loop: a byte of the line. */
void device_take(uint8_t byte);
/* From the main loop, at least each 250 us: watchdog, relays, samples. */
void device_poll(void);

/* From the timer's interrupt, at t_k. */
void device_on_tick(void);
/* From an interrupt: the conversion of this tick is complete. */
void device_on_reading(const struct board_reading* reading);
