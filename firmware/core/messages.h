#pragma once

/* The numbers of the device protocol: hardware/device/PROTOCOL.md, sections 3 to 6. */
#define PROTOCOL_VERSION 1

enum message_type {
  /* from the host */
  MESSAGE_HELLO = 0x01,
  MESSAGE_PLAN = 0x02,
  MESSAGE_DATA = 0x03,
  MESSAGE_ARM = 0x04,
  MESSAGE_START = 0x05,
  MESSAGE_HEARTBEAT = 0x06,
  MESSAGE_SAFE = 0x07,
  MESSAGE_RELAY = 0x08,
  MESSAGE_CLEAR = 0x09,
  MESSAGE_RESEND = 0x0a,
  /* from the device */
  MESSAGE_INFO = 0x81,
  MESSAGE_ACK = 0x82,
  MESSAGE_SAMPLE = 0x83,
};

enum device_state { STATE_SAFE = 0, STATE_ARMED = 1, STATE_RUN = 2, STATE_FAULT = 3 };

enum ack_error {
  ERROR_NONE = 0,
  ERROR_LENGTH = 1,
  ERROR_TYPE = 2,
  ERROR_STATE = 3,
  ERROR_RANGE = 4,
  ERROR_OFFSET = 5,
  ERROR_FULL = 6,
  ERROR_LATE = 7,
  ERROR_VERSION = 8,
};

enum device_fault {
  FAULT_NONE = 0,
  FAULT_COMMUNICATION = 1,
  FAULT_UNDERRUN = 2,
  FAULT_RELAY = 3,
  FAULT_TIMING = 4,
};

enum reset_cause { RESET_UNKNOWN = 0, RESET_POWER = 1, RESET_PIN = 2, RESET_BROWNOUT = 3, RESET_WATCHDOG = 4 };

enum capability {
  CAPABILITY_UM = 1 << 0,
  CAPABILITY_UA = 1 << 1,
  CAPABILITY_IA = 1 << 2,
  CAPABILITY_ENCODER = 1 << 3,
  CAPABILITY_DIRECTION = 1 << 4,
  CAPABILITY_EDGE_TIME = 1 << 5,
};

#define FLAG_RELAYS_SETTLED 0x01
#define RELAY_NOW 0xffffffffUL
#define EDGE_NONE 0xffffu
#define DATA_VALUES_MAX 24
