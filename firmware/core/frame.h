#pragma once

#include <stdbool.h>
#include <stdint.h>

/* Frames of the device protocol (hardware/device/PROTOCOL.md, section 2): 0x00 COBS(body) 0x00,
 * body = type, seq, payload, CRC. */
#define FRAME_PAYLOAD_MAX 64
#define FRAME_BODY_MAX (FRAME_PAYLOAD_MAX + 4)
/* Two zeros and the one code byte that COBS adds below 254 bytes. */
#define FRAME_WIRE_MAX (FRAME_BODY_MAX + 3)

/* CRC-16/CCITT-FALSE: start with 0xffff; over a body with its CRC it is 0. */
uint16_t crc16(uint16_t crc, uint8_t byte);

struct frame_reader {
  uint8_t body[FRAME_BODY_MAX];
  uint8_t length;
  uint8_t left;    /* bytes that the block still has */
  bool zero_next;  /* the block before ended with a zero, if another block follows */
  bool bad;        /* until the next 0x00 */
  uint8_t bad_frames; /* refused so far; stops at 255 */
};

/* Takes one byte of the line. Returns the length of the body without CRC (2 or more) when it
 * completes a frame that is whole, else 0. The body is valid until the next call. */
uint8_t frame_take(struct frame_reader* reader, uint8_t byte);

/* Writes a whole frame to `wire`, which has FRAME_WIRE_MAX bytes; returns its length. */
uint8_t frame_write(uint8_t* wire,
                    uint8_t type,
                    uint8_t seq,
                    const uint8_t* payload,
                    uint8_t payload_length);
