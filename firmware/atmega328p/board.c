/* An ATmega328P at 16 MHz as the core's board; pins: README.md. */
#include "core/board.h"

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <avr/wdt.h>

#include "board_config.h"
#include "core/device.h"

#define DAC_SELECT _BV(PB2)
#define DAC_DATA _BV(PB3)
#define DAC_CLOCK _BV(PB5)
#define RELAY_DATA _BV(PC3)
#define RELAY_CLOCK _BV(PC4)
#define RELAY_LATCH _BV(PC5)
#define RELAY_OFF _BV(PD4) /* /OE: the board pulls it up */
#define RELAY_LOAD _BV(PD5)
#define RELAY_READ _BV(PD6)
#define ENCODER_BACKWARDS _BV(PD3)

/* MCP4921: no buffer, gain 1, on. */
#define DAC_COMMAND 0x3000u
#define HALF_US 2u /* timer 1 runs at 2 MHz */

/* ---- uc ---------------------------------------------------------------------------------------- */

void board_drive(int16_t code) {
  uint16_t word = DAC_COMMAND | (uint16_t)code;
  const uint8_t before = board_lock();
  PORTB &= (uint8_t)~DAC_SELECT;
  for (uint8_t i = 0; i < 16; ++i) {
    if (word & 0x8000u) {
      PORTB |= DAC_DATA;
    } else {
      PORTB &= (uint8_t)~DAC_DATA;
    }
    PORTB |= DAC_CLOCK;
    word = (uint16_t)(word << 1);
    PORTB &= (uint8_t)~DAC_CLOCK;
  }
  PORTB |= DAC_SELECT;
  board_unlock(before);
}

/* ---- relays ------------------------------------------------------------------------------------ */

/* Level 0 connects. Line 31 is shifted first. */
void board_relays_write(uint32_t lines) {
  uint32_t levels = ~lines;
  for (uint8_t i = 0; i < 32; ++i) {
    if (levels & 0x80000000UL) {
      PORTC |= RELAY_DATA;
    } else {
      PORTC &= (uint8_t)~RELAY_DATA;
    }
    PORTC |= RELAY_CLOCK;
    levels <<= 1;
    PORTC &= (uint8_t)~RELAY_CLOCK;
  }
  PORTC |= RELAY_LATCH;
  PORTC &= (uint8_t)~RELAY_LATCH;
}

uint32_t board_relays_read(void) {
  uint32_t levels = 0;
  PORTD &= (uint8_t)~RELAY_LOAD;
  PORTD |= RELAY_LOAD;
  for (uint8_t i = 0; i < 32; ++i) {
    levels = levels << 1 | ((PIND & RELAY_READ) != 0);
    PORTC |= RELAY_CLOCK;
    PORTC &= (uint8_t)~RELAY_CLOCK;
  }
  return ~levels & RELAY_LINES;
}

/* ---- encoder ------------------------------------------------------------------------------------
 * Rising edges of A. The sense is B at that edge, held by a flip-flop until the next one: B itself
 * has changed again a quarter of a pulse later, which is shorter than other interrupts take.
 * Those that take long let this one in (ISR_NOBLOCK). */

static volatile int16_t pulses;
static volatile uint16_t edge_at; /* of timer 1 */

struct encoder {
  int16_t pulses;
  uint16_t edge_at;
  uint16_t now;
};

static struct encoder encoder(void) {
  const uint8_t before = board_lock();
  const struct encoder seen = {pulses, edge_at, TCNT1};
  board_unlock(before);
  return seen;
}

ISR(INT0_vect) {
  edge_at = TCNT1;
  if (PIND & ENCODER_BACKWARDS) {
    --pulses;
  } else {
    ++pulses;
  }
}

/* ---- the tick and its conversions -------------------------------------------------------------- */

static struct board_reading reading;
static int16_t sums[3];
static uint8_t conversion; /* of 3 ADC_READINGS */
static uint8_t channel;    /* of the conversion; a division would take longer than an encoder pulse */
static uint16_t started_at;
static struct encoder gate; /* at the first conversion */
static bool gate_edge_known;
static int16_t pulses_before;
static volatile bool ticked;

void board_timer_start(uint32_t period_us, uint32_t delta_us) {
  const uint8_t before = board_lock();
  TCCR1A = 0;
  TCCR1B = _BV(WGM12);
  TCNT1 = 0;
  OCR1A = (uint16_t)(period_us * HALF_US - 1u);
  OCR1B = (uint16_t)((delta_us - CONVERT_US / 2) * HALF_US);
  TIFR1 = _BV(OCF1A) | _BV(OCF1B);
  TIMSK1 = _BV(OCIE1A) | _BV(OCIE1B);
  pulses_before = pulses;
  ticked = false;
  TCCR1B = _BV(WGM12) | _BV(CS11);
  board_unlock(before);
}

void board_timer_stop(void) {
  TCCR1B = 0;
  TIMSK1 = 0;
  ticked = false;
}

ISR(TIMER1_COMPA_vect, ISR_NOBLOCK) {
  ticked = true;
  device_on_tick();
}

static void convert(void) {
  ADMUX = (uint8_t)(_BV(REFS0) | channel);
  ADCSRA |= _BV(ADSC);
}

ISR(TIMER1_COMPB_vect, ISR_NOBLOCK) {
  if (!ticked) return;
  ticked = false;
  sums[0] = sums[1] = sums[2] = 0;
  conversion = 0;
  channel = 0;
  convert();
  gate = encoder();
  started_at = gate.now;
  gate_edge_known = gate.pulses != pulses_before; /* else it may be older than a period */
}

/* Between two times of timer 1, less than a period apart. */
static uint16_t ticks_between(uint16_t from, uint16_t to) {
  return to >= from ? to - from : (uint16_t)(to + (OCR1A + 1u) - from);
}

static void latch_gate(const struct encoder* seen) {
  const int16_t counted = (int16_t)(seen->pulses - gate.pulses);
  const uint16_t ticks = ticks_between(gate.edge_at, seen->edge_at);
  const bool known = gate_edge_known && counted != 0 && ticks < 0xffffu / 5u;
  reading.gate_count = known ? counted : 0;
  reading.gate_tenth_us = known ? (uint16_t)(ticks * 5u) : 0;
}

static void latch_encoder(void) {
  const struct encoder seen = encoder();
  const int16_t counted = (int16_t)(seen.pulses - pulses_before);
  pulses_before = seen.pulses;
  reading.count += counted;
  reading.edge_age_us = EDGE_NONE;
  if (counted != 0) {
    reading.edge_age_us = ticks_between(seen.edge_at, seen.now) / HALF_US;
  }
}

ISR(ADC_vect, ISR_NOBLOCK) {
  /* The value before the next channel is chosen. */
  const int16_t value = (int16_t)ADC;
  const uint8_t done = channel;
  ++conversion;
  channel = done == 2 ? 0 : (uint8_t)(done + 1);
  if (conversion < 3 * ADC_READINGS) convert();
  sums[done] += value;
  if (conversion == 3 * ADC_READINGS / 2) latch_encoder();
  if (conversion < 3 * ADC_READINGS) return;
  const struct encoder end = encoder();
  latch_gate(&end);
  reading.um = sums[0];
  reading.ua = sums[1];
  reading.ia = sums[2];
  reading.converted_us = ((uint32_t)started_at + end.now) / (2 * HALF_US);
  device_on_reading(&reading);
}

/* ---- time, line, locks ------------------------------------------------------------------------- */

static volatile uint16_t time_steps;

ISR(TIMER2_COMPA_vect) {
  ++time_steps;
}

uint8_t board_lock(void) {
  const uint8_t before = SREG;
  cli();
  return before;
}

void board_unlock(uint8_t before) {
  SREG = before;
}

uint16_t board_time(void) {
  const uint8_t before = board_lock();
  const uint16_t now = time_steps;
  board_unlock(before);
  return now;
}

/* Indices wrap at the sizes, which are powers of 2. */
#define RX_BYTES 128u
static volatile uint8_t rx[RX_BYTES];
static volatile uint8_t rx_in;
static uint8_t rx_out;
static volatile uint8_t tx[256];
static volatile uint8_t tx_in;
static volatile uint8_t tx_out;

ISR(USART_RX_vect) {
  const uint8_t byte = UDR0;
  const uint8_t after = (uint8_t)((rx_in + 1u) % RX_BYTES);
  if (after == rx_out) return; /* a frame is lost; its CRC tells */
  rx[rx_in] = byte;
  rx_in = after;
}

ISR(USART_UDRE_vect) {
  UDR0 = tx[tx_out++];
  if (tx_out == tx_in) UCSR0B &= (uint8_t)~_BV(UDRIE0);
}

bool board_send(const uint8_t* bytes, uint8_t length) {
  const uint8_t room = (uint8_t)(tx_out - tx_in - 1u);
  if (room < length) return false;
  for (uint8_t i = 0; i < length; ++i) tx[(uint8_t)(tx_in + i)] = bytes[i];
  const uint8_t before = board_lock();
  tx_in = (uint8_t)(tx_in + length);
  UCSR0B |= _BV(UDRIE0);
  board_unlock(before);
  return true;
}

/* ---- start ------------------------------------------------------------------------------------- */

static uint8_t reset_cause(uint8_t flags) {
  if (flags & _BV(WDRF)) return RESET_WATCHDOG;
  if (flags & _BV(BORF)) return RESET_BROWNOUT;
  if (flags & _BV(EXTRF)) return RESET_PIN;
  return flags & _BV(PORF) ? RESET_POWER : RESET_UNKNOWN;
}

/* The drive first: the converter holds its code through a reset. Then the lines, then /OE. */
static void make_safe(void) {
  PORTB = DAC_SELECT;
  DDRB = DAC_SELECT | DAC_DATA | DAC_CLOCK;
  board_drive(UC_OFFSET);
  DDRC = RELAY_DATA | RELAY_CLOCK | RELAY_LATCH;
  PORTD = RELAY_OFF | RELAY_LOAD;
  board_relays_write(SAFE_LINES);
  DDRD = RELAY_OFF | RELAY_LOAD;
  PORTD = RELAY_LOAD;
}

int main(void) {
  const uint8_t flags = MCUSR;
  MCUSR = 0;
  wdt_disable();
  make_safe();
  wdt_enable(WDTO_120MS);

  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS1); /* 250 kHz */
  TCCR2A = _BV(WGM21);
  OCR2A = 124;
  TIMSK2 = _BV(OCIE2A);
  TCCR2B = _BV(CS21) | _BV(CS20); /* 500 kHz: 250 us */
  EICRA = _BV(ISC01) | _BV(ISC00);
  EIMSK = _BV(INT0);
  UCSR0A = _BV(U2X0);
  UBRR0H = 0;
  UBRR0L = (uint8_t)(F_CPU / 8 / BAUD - 1);
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXCIE0) | _BV(RXEN0) | _BV(TXEN0);

  device_begin(reset_cause(flags));
  set_sleep_mode(SLEEP_MODE_IDLE);
  sei();
  uint16_t time_before = 0;
  for (;;) {
    /* A main loop for which no time passes (an encoder input that rings) is not alive. */
    const uint16_t time = board_time();
    if (time != time_before) wdt_reset();
    time_before = time;
    /* Not more than a frame in one turn. */
    for (uint8_t i = 0; i < 64 && rx_out != rx_in; ++i) {
      const uint8_t byte = rx[rx_out];
      rx_out = (uint8_t)((rx_out + 1u) % RX_BYTES);
      device_take(byte);
    }
    device_poll();
    if (rx_out == rx_in) sleep_mode(); /* at most until the next step of time */
  }
}
