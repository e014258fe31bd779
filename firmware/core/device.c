#include "device.h"

#include <string.h>

#include "board_config.h"
#include "bytes.h"
#include "frame.h"
#include "relays.h"

#define SAMPLE_LENGTH 36
#define ACK_LENGTH 20
#define INFO_LENGTH 64

struct relay_entry {
  uint32_t at;
  uint32_t lines;
};

static struct frame_reader reader;

/* Shared with interrupts. */
static volatile uint8_t state;
static volatile uint8_t fault;
static volatile uint32_t next;   /* the sample whose tick comes next */
static volatile bool go_safe;    /* the relays are still to follow */
static volatile bool converting; /* a tick waits for its reading */
static volatile bool reading_full;
static volatile struct board_reading reading;
static volatile int16_t driven; /* the code that is out */
static int16_t driven_at_tick;
static volatile int16_t driven_at_reading;
static int16_t plan[PLAN_VALUES];
static volatile uint32_t received; /* values of the plan */
static uint32_t samples;

/* Of the main loop alone. */
static uint32_t period_us;
static uint32_t delta_us;
static uint16_t watchdog; /* steps */
static uint16_t heard_at;
static uint16_t drops;
static uint8_t cause;
static uint32_t history_end; /* samples that were composed */
static uint8_t history[HISTORY_SAMPLES][SAMPLE_LENGTH];
static struct relay_entry entries[RELAY_ENTRIES];
static uint8_t entries_first;
static uint8_t entries_count;
static struct relay_entry newest_entry;
static bool has_newest_entry;

static void drive(int16_t code) {
  driven = code;
  board_drive(code);
}

/* Interrupts are off, or this is one. */
static void stop_driving(uint8_t into, uint8_t why) {
  board_timer_stop();
  drive(UC_OFFSET);
  converting = false;
  state = into;
  fault = why;
  go_safe = true;
}

static void stop(uint8_t into, uint8_t why) {
  const uint8_t before = board_lock();
  stop_driving(into, why);
  board_unlock(before);
  entries_count = 0;
  has_newest_entry = false;
}

static uint32_t next_sample(void) {
  const uint8_t before = board_lock();
  const uint32_t now = next;
  board_unlock(before);
  return now;
}

static bool send(uint8_t type, uint8_t seq, const uint8_t* payload, uint8_t length) {
  uint8_t wire[FRAME_WIRE_MAX];
  return board_send(wire, frame_write(wire, type, seq, payload, length));
}

static void send_info(uint8_t seq) {
  uint8_t payload[INFO_LENGTH];
  uint8_t* at = payload;
  at = put_u8(at, PROTOCOL_VERSION);
  at = put_u16(at, FIRMWARE_VERSION);
  at = put_u8(at, cause);
  at = put_u16(at, CAPABILITIES);
  at = put_u8(at, state);
  at = put_u8(at, fault);
  at = put_u32(at, PERIOD_MIN_US);
  at = put_u32(at, PERIOD_MAX_US);
  at = put_u16(at, CONVERT_US);
  at = put_u16(at, PLAN_VALUES);
  at = put_u8(at, RELAY_ENTRIES);
  at = put_u32(at, UC_STEP_NV);
  at = put_u16(at, (uint16_t)UC_OFFSET);
  at = put_u16(at, (uint16_t)UC_MIN);
  at = put_u16(at, (uint16_t)UC_MAX);
  at = put_u32(at, UM_STEP_NV);
  at = put_u16(at, (uint16_t)UM_OFFSET);
  at = put_u8(at, UM_BITS);
  at = put_u32(at, UA_STEP_NV);
  at = put_u16(at, (uint16_t)UA_OFFSET);
  at = put_u8(at, UA_BITS);
  at = put_u32(at, IA_STEP_NV);
  at = put_u16(at, (uint16_t)IA_OFFSET);
  at = put_u8(at, IA_BITS);
  at = put_u32(at, RELAY_LINES);
  at = put_u32(at, SAFE_LINES);
  at = put_u32(at, MAKE_FIRST_LINES);
  (void)send(MESSAGE_INFO, seq, payload, (uint8_t)(at - payload));
}

static void send_ack(uint8_t type, uint8_t seq, uint8_t error) {
  uint8_t payload[ACK_LENGTH];
  uint8_t* at = payload;
  at = put_u8(at, type);
  at = put_u8(at, error);
  at = put_u8(at, state);
  at = put_u8(at, fault);
  at = put_u8(at, relays_settled() && !go_safe ? FLAG_RELAYS_SETTLED : 0);
  at = put_u8(at, reader.bad_frames);
  at = put_u32(at, received);
  at = put_u32(at, next_sample());
  at = put_u32(at, board_relays_read());
  at = put_u16(at, drops);
  (void)send(MESSAGE_ACK, seq, payload, (uint8_t)(at - payload));
}

/* ---- messages of the host: each returns an ack_error ----------------------------------------- */

static uint8_t take_plan(const uint8_t* p) {
  const uint32_t period = get_u32(p + 4);
  const uint32_t delta = get_u32(p + 8);
  if (state != STATE_SAFE) return ERROR_STATE;
  if (get_u32(p) == 0 || period < PERIOD_MIN_US || period > PERIOD_MAX_US) return ERROR_RANGE;
  if (delta < CONVERT_US / 2 + TICK_MARGIN_US ||
      delta + CONVERT_US / 2 + TICK_MARGIN_US > period) {
    return ERROR_RANGE;
  }
  samples = get_u32(p);
  period_us = period;
  delta_us = delta;
  received = 0;
  next = 0;
  history_end = 0;
  drops = 0;
  return ERROR_NONE;
}

static uint8_t take_data(const uint8_t* p, uint8_t length) {
  const uint32_t first = get_u32(p);
  const uint8_t count = (uint8_t)((length - 4) / 2);
  if (state == STATE_FAULT) return ERROR_STATE;
  if (first > received) return ERROR_OFFSET;
  if (first + count > samples) return ERROR_RANGE;
  for (uint8_t i = 0; i < count; ++i) {
    const int16_t code = (int16_t)get_u16(p + 4 + 2 * i);
    if (code < UC_MIN || code > UC_MAX) return ERROR_RANGE;
  }
  if (first + count <= received) return ERROR_NONE; /* known */
  if (first + count - next_sample() > PLAN_VALUES) return ERROR_FULL;
  for (uint8_t i = (uint8_t)(received - first); i < count; ++i) {
    plan[(first + i) % PLAN_VALUES] = (int16_t)get_u16(p + 4 + 2 * i);
  }
  const uint8_t before = board_lock();
  received = first + count;
  board_unlock(before);
  return ERROR_NONE;
}

static uint8_t take_arm(const uint8_t* p) {
  const uint16_t watchdog_ms = get_u16(p);
  if (state != STATE_SAFE && state != STATE_ARMED) return ERROR_STATE;
  if (watchdog_ms < 20 || watchdog_ms > 10000) return ERROR_RANGE;
  watchdog = (uint16_t)(watchdog_ms * STEPS_PER_MS);
  relays_set_times(get_u16(p + 2), get_u16(p + 4));
  state = STATE_ARMED;
  return ERROR_NONE;
}

static uint8_t take_start(void) {
  if (state == STATE_RUN) return ERROR_NONE; /* the answer was lost */
  if (state != STATE_ARMED || samples == 0 || received == 0 || next_sample() != 0) {
    return ERROR_STATE;
  }
  converting = false;
  reading_full = false;
  state = STATE_RUN;
  board_timer_start(period_us, delta_us);
  return ERROR_NONE;
}

static uint8_t take_relay(const uint8_t* p) {
  const struct relay_entry entry = {.at = get_u32(p), .lines = get_u32(p + 4)};
  if ((entry.lines & ~RELAY_LINES) != 0) return ERROR_RANGE;
  if (entry.at == RELAY_NOW) {
    if (state != STATE_ARMED) return ERROR_STATE;
    relays_go(entry.lines);
    return ERROR_NONE;
  }
  if (state != STATE_ARMED && state != STATE_RUN) return ERROR_STATE;
  if (has_newest_entry) {
    if (entry.at == newest_entry.at && entry.lines == newest_entry.lines) return ERROR_NONE;
    if (entry.at <= newest_entry.at) return ERROR_OFFSET;
  }
  if (entry.at < next_sample()) return ERROR_LATE;
  if (entries_count == RELAY_ENTRIES) return ERROR_FULL;
  entries[(entries_first + entries_count) % RELAY_ENTRIES] = entry;
  ++entries_count;
  newest_entry = entry;
  has_newest_entry = true;
  return ERROR_NONE;
}

static uint8_t take_resend(const uint8_t* p) {
  const uint32_t k = get_u32(p);
  if (k >= history_end || history_end - k > HISTORY_SAMPLES) return ERROR_RANGE;
  (void)send(MESSAGE_SAMPLE, (uint8_t)k, history[k % HISTORY_SAMPLES], SAMPLE_LENGTH);
  return ERROR_NONE;
}

static bool length_fits(uint8_t type, uint8_t length) {
  switch (type) {
    case MESSAGE_HELLO:
      return length == 1;
    case MESSAGE_PLAN:
      return length == 12;
    case MESSAGE_DATA:
      return length >= 6 && length <= 4 + 2 * DATA_VALUES_MAX && length % 2 == 0;
    case MESSAGE_ARM:
      return length == 6;
    case MESSAGE_RELAY:
      return length == 8;
    case MESSAGE_RESEND:
      return length == 4;
    default:
      return length == 0;
  }
}

static uint8_t obey(uint8_t type, const uint8_t* p, uint8_t length) {
  if (type < MESSAGE_HELLO || type > MESSAGE_RESEND) return ERROR_TYPE;
  if (!length_fits(type, length)) return ERROR_LENGTH;
  switch (type) {
    case MESSAGE_HELLO:
      return p[0] == PROTOCOL_VERSION ? ERROR_NONE : ERROR_VERSION;
    case MESSAGE_PLAN:
      return take_plan(p);
    case MESSAGE_DATA:
      return take_data(p, length);
    case MESSAGE_ARM:
      return take_arm(p);
    case MESSAGE_START:
      return take_start();
    case MESSAGE_SAFE:
      stop(state == STATE_FAULT ? STATE_FAULT : STATE_SAFE, fault);
      return ERROR_NONE;
    case MESSAGE_RELAY:
      return take_relay(p);
    case MESSAGE_CLEAR:
      if (state == STATE_FAULT) stop(STATE_SAFE, FAULT_NONE);
      return ERROR_NONE;
    case MESSAGE_RESEND:
      return take_resend(p);
    default: /* HEARTBEAT */
      return ERROR_NONE;
  }
}

void device_take(uint8_t byte) {
  const uint8_t length = frame_take(&reader, byte);
  if (length == 0) return;
  heard_at = board_time();
  const uint8_t type = reader.body[0];
  const uint8_t seq = reader.body[1];
  const uint8_t error = obey(type, reader.body + 2, (uint8_t)(length - 2));
  if (type == MESSAGE_HELLO && error != ERROR_LENGTH) {
    send_info(seq); /* of another version too: it names this one */
  } else {
    send_ack(type, seq, error);
  }
}

/* ---- the run ----------------------------------------------------------------------------------- */

/* Other interrupts may come in between. */
void device_on_tick(void) {
  if (state != STATE_RUN) return;
  if (converting) {
    stop_driving(STATE_FAULT, FAULT_TIMING);
  } else if (next == samples) {
    stop_driving(STATE_SAFE, FAULT_NONE);
  } else if (next == received) {
    stop_driving(STATE_FAULT, FAULT_UNDERRUN);
  } else {
    drive(plan[next % PLAN_VALUES]);
    driven_at_tick = driven;
    converting = true;
    ++next;
  }
}

void device_on_reading(const struct board_reading* now) {
  if (!converting) return;
  if (reading_full) {
    stop_driving(STATE_FAULT, FAULT_TIMING);
    return;
  }
  reading = *now;
  driven_at_reading = driven_at_tick;
  reading_full = true;
  converting = false;
}

static void compose_sample(void) {
  const struct board_reading now = reading;
  const uint32_t lines = board_relays_read();
  const uint32_t k = history_end;
  uint8_t* at = history[k % HISTORY_SAMPLES];
  at = put_u32(at, k);
  at = put_u32(at, k * period_us);
  at = put_u16(at, (uint16_t)driven_at_reading);
  at = put_u16(at, (uint16_t)now.um);
  at = put_u16(at, (uint16_t)now.ua);
  at = put_u16(at, (uint16_t)now.ia);
  at = put_u32(at, (uint32_t)now.count);
  at = put_u16(at, now.edge_age_us);
  at = put_u16(at, (uint16_t)now.gate_count);
  at = put_u16(at, now.gate_tenth_us);
  at = put_u32(at, now.converted_us);
  at = put_u32(at, lines);
  at = put_u8(at, state);
  at = put_u8(at, relays_settled() ? FLAG_RELAYS_SETTLED : 0);
  reading_full = false;
  history_end = k + 1;
  const uint8_t* payload = history[k % HISTORY_SAMPLES];
  if (!send(MESSAGE_SAMPLE, (uint8_t)k, payload, SAMPLE_LENGTH) && drops < 0xffff) ++drops;
  if (state == STATE_RUN && relays_settled() && !relays_hold(lines)) {
    stop(STATE_FAULT, FAULT_RELAY);
  }
}

static void switch_due_relays(void) {
  while (entries_count > 0 && entries[entries_first].at < next_sample()) {
    relays_go(entries[entries_first].lines);
    entries_first = (uint8_t)((entries_first + 1) % RELAY_ENTRIES);
    --entries_count;
  }
}

void device_poll(void) {
  if (state == STATE_ARMED || state == STATE_RUN) {
    if ((uint16_t)(board_time() - heard_at) > watchdog) stop(STATE_FAULT, FAULT_COMMUNICATION);
  }
  if (go_safe) {
    go_safe = false;
    entries_count = 0;
    has_newest_entry = false;
    relays_go(SAFE_LINES);
  } else if (state == STATE_RUN) {
    switch_due_relays();
  }
  if (!relays_poll() && (state == STATE_ARMED || state == STATE_RUN)) {
    stop(STATE_FAULT, FAULT_RELAY);
  }
  if (reading_full) compose_sample();
}

void device_begin(uint8_t reset_cause) {
  memset(&reader, 0, sizeof reader);
  cause = reset_cause;
  state = STATE_SAFE;
  fault = FAULT_NONE;
  samples = 0;
  driven = UC_OFFSET;
  relays_begin();
  send_info(0);
}
