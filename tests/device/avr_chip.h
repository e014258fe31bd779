#pragma once

#include <stdint.h>

/* An ATmega328P in simavr, with the corrections that make its serial line as fast and as small as
 * the silicon's (README.md). In C, because simavr's headers are. Not thread-safe. */
#ifdef __cplusplus
extern "C" {
#endif

struct avr_chip;

/* What is connected to the pins. All are called during avr_chip_run. */
struct avr_chip_wiring {
  void* context;
  /* A byte has left the serial line. */
  void (*sent)(void* context, uint8_t byte);
  /* The next byte for the serial line, or -1. */
  int (*receive)(void* context);
  /* A port register or its direction was written: 'B', 'C' or 'D'. */
  void (*port)(void* context, char port, uint8_t value, uint8_t direction);
  /* A conversion begins: set the inputs with avr_chip_set_millivolts. */
  void (*convert)(void* context);
  /* At the cycle asked for by avr_chip_wake_at. */
  void (*woken)(void* context, uint64_t cycle);
  /* All ports are inputs again; the wake-up is cancelled. */
  void (*reset)(void* context);
};

/* NULL when the firmware cannot be read. */
struct avr_chip* avr_chip_open(const char* elf, const struct avr_chip_wiring* wiring);
void avr_chip_close(struct avr_chip* chip);

/* Runs until the cycle is reached. Returns 0 when the processor has crashed or stopped. */
int avr_chip_run(struct avr_chip* chip, uint64_t cycle);
uint64_t avr_chip_cycle(const struct avr_chip* chip);
/* As by the reset pin. */
void avr_chip_reset(struct avr_chip* chip);
void avr_chip_wake_at(struct avr_chip* chip, uint64_t cycle);
void avr_chip_set_pin(struct avr_chip* chip, char port, int bit, int level);
void avr_chip_set_millivolts(struct avr_chip* chip, int channel, int millivolts);
/* Cycles that the processor did not sleep. */
uint64_t avr_chip_busy_cycles(const struct avr_chip* chip);
/* Bytes that arrived while three were unread: the silicon loses them. */
uint64_t avr_chip_overruns(const struct avr_chip* chip);

#ifdef __cplusplus
}
#endif
