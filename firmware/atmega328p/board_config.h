#pragma once

/* One bench: what its owner edits. The lines are those of the paper's bench (hardware/README.md). */

#define FIRMWARE_VERSION 0x0100
#define CAPABILITIES                                                                 \
  (CAPABILITY_UM | CAPABILITY_UA | CAPABILITY_IA | CAPABILITY_ENCODER |              \
   CAPABILITY_DIRECTION | CAPABILITY_EDGE_TIME)

/* Bit i is line Do<i>; 1 connects its part. R1 17 16 1 0, R9 19 18 3 2, C8 21 20 5 4, R12 6 7 22 23;
 * the first of each is nominal. */
#define RELAY_LINES 0x00ff00ffUL
#define SAFE_LINES (1UL << 17 | 1UL << 19 | 1UL << 21 | 1UL << 6)
/* R12 closes the amplifier's feedback: it makes before it breaks. */
#define MAKE_FIRST_LINES (1UL << 6 | 1UL << 7 | 1UL << 22 | 1UL << 23)

/* uc: MCP4921, 12 bit, 0 to 5 V. */
#define UC_STEP_NV 1220703UL
#define UC_OFFSET 0
#define UC_MIN 0
#define UC_MAX 4095

/* um, ua, ia: the ATmega's own converter, 10 bit, 0 to 5 V; four readings are added. */
#define ADC_READINGS 4
#define ADC_STEP_NV (4882812UL / ADC_READINGS)
#define UM_STEP_NV ADC_STEP_NV
#define UM_OFFSET 0
#define UM_BITS 10
#define UA_STEP_NV ADC_STEP_NV
#define UA_OFFSET 0
#define UA_BITS 10
#define IA_STEP_NV ADC_STEP_NV
#define IA_OFFSET 0
#define IA_BITS 10

/* Of the UART. 115200 is really 117647 with a crystal of 16 MHz; 250000, 500000, 1000000 are
 * exact. */
#ifndef BAUD
#define BAUD 250000UL
#endif

/* Three channels at 52 us and the interrupts between them. */
#define CONVERT_US (3 * ADC_READINGS * 56)
/* Between the conversions and the ticks beside them. */
#define TICK_MARGIN_US 100
#define PERIOD_MIN_US 2000
#define PERIOD_MAX_US 32000 /* 16 bits of half microseconds */

#define PLAN_VALUES 128
#define HISTORY_SAMPLES 12
#define RELAY_ENTRIES 8
