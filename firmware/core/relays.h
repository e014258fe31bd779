#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Relay lines in two stages: lines that break first open, then the new ones close; lines that make
 * first do the opposite. Each stage is read back. */

void relays_begin(void);
void relays_set_times(uint16_t gap_us, uint16_t settle_us);
/* Starts switching to exactly these lines. */
void relays_go(uint32_t lines);
/* Does what is due. False: the lines read back otherwise than written; nothing is added then. */
bool relays_poll(void);
bool relays_settled(void);
/* Only of settled lines: they still read back as written. */
bool relays_hold(uint32_t read_back);
