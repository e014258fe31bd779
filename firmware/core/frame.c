#include "frame.h"

uint16_t crc16(uint16_t crc, uint8_t byte) {
  /* Polynomial 0x1021, four table-free steps for eight bits. */
  crc = (uint16_t)((uint16_t)(crc >> 8) | (uint16_t)(crc << 8));
  crc ^= byte;
  crc ^= (uint8_t)((uint8_t)crc >> 4);
  crc ^= (uint16_t)(crc << 12);
  crc ^= (uint16_t)((crc & 0xffu) << 5);
  return crc;
}

static void begin(struct frame_reader* reader) {
  reader->length = 0;
  reader->left = 0;
  reader->zero_next = false;
  reader->bad = false;
}

static void append(struct frame_reader* reader, uint8_t byte) {
  if (reader->length == FRAME_BODY_MAX) {
    reader->bad = true;
    return;
  }
  reader->body[reader->length++] = byte;
}

static uint8_t finish(struct frame_reader* reader) {
  const bool empty = reader->length == 0 && !reader->bad && !reader->zero_next && reader->left == 0;
  const bool whole = !reader->bad && reader->left == 0 && reader->length >= 4;
  uint8_t length = 0;
  if (whole) {
    uint16_t crc = 0xffff;
    for (uint8_t i = 0; i < reader->length; ++i) crc = crc16(crc, reader->body[i]);
    if (crc == 0) length = (uint8_t)(reader->length - 2);
  }
  if (!empty && length == 0 && reader->bad_frames < 255) ++reader->bad_frames;
  begin(reader);
  return length;
}

uint8_t frame_take(struct frame_reader* reader, uint8_t byte) {
  if (byte == 0) return finish(reader);
  if (reader->bad) return 0;
  if (reader->left > 0) {
    --reader->left;
    append(reader, byte);
    return 0;
  }
  /* `byte` begins a block: its length + 1. */
  if (reader->zero_next) append(reader, 0);
  reader->left = (uint8_t)(byte - 1);
  reader->zero_next = byte != 0xff;
  return 0;
}

struct encoder {
  uint8_t* wire;
  uint8_t length;
  uint8_t code_at;
  uint16_t crc;
};

static void put(struct encoder* encoder, uint8_t byte) {
  encoder->crc = crc16(encoder->crc, byte);
  if (byte != 0) {
    encoder->wire[encoder->length++] = byte;
    return;
  }
  encoder->wire[encoder->code_at] = (uint8_t)(encoder->length - encoder->code_at);
  encoder->code_at = encoder->length++;
}

uint8_t frame_write(uint8_t* wire,
                    uint8_t type,
                    uint8_t seq,
                    const uint8_t* payload,
                    uint8_t payload_length) {
  struct encoder encoder = {.wire = wire, .length = 2, .code_at = 1, .crc = 0xffff};
  wire[0] = 0;
  put(&encoder, type);
  put(&encoder, seq);
  for (uint8_t i = 0; i < payload_length; ++i) put(&encoder, payload[i]);
  const uint16_t crc = encoder.crc;
  put(&encoder, (uint8_t)(crc >> 8));
  put(&encoder, (uint8_t)crc);
  wire[encoder.code_at] = (uint8_t)(encoder.length - encoder.code_at);
  wire[encoder.length++] = 0;
  return encoder.length;
}
