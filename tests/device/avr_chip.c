#include "avr_chip.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

#include <avr_adc.h>
#include <avr_extint.h>
#include <avr_ioport.h>
#include <avr_uart.h>
#include <sim_avr.h>
#include <sim_core.h>
#include <sim_cycle_timers.h>
#include <sim_elf.h>
#include <sim_io.h>

enum { kUbrr0l = 0xc4, kUartBuffer = 3 };

struct avr_chip {
  avr_t* avr;
  avr_uart_t* uart;
  avr_irq_t* uart_input;
  avr_irq_t* adc;
  struct avr_chip_wiring wiring;
  void (*core_reset)(struct avr_t* avr);
  uint64_t slept;
  uint64_t overruns;
  struct port {
    struct avr_chip* chip;
    avr_irq_t* irqs;
    char name;
    uint8_t value;
    uint8_t direction;
  } ports[3];
};

/* The only one of a process: two of simavr's callbacks carry no parameter. */
static struct avr_chip* the_chip;

static void be_quiet(avr_t* avr, const int level, const char* format, va_list arguments) {
  (void)avr, (void)level, (void)format, (void)arguments;
}

/* simavr would wait for the wall clock. */
static void sleep_without_waiting(avr_t* avr, avr_cycle_count_t cycles) {
  (void)avr;
  if (the_chip != NULL) the_chip->slept += cycles;
}

static void on_sent(avr_irq_t* irq, uint32_t value, void* param) {
  (void)irq;
  struct avr_chip* chip = param;
  chip->wiring.sent(chip->wiring.context, (uint8_t)value);
}

static avr_cycle_count_t feed(avr_t* avr, avr_cycle_count_t when, void* param) {
  (void)avr;
  struct avr_chip* chip = param;
  const avr_cycle_count_t byte_time =
      chip->uart->cycles_per_byte > 0 ? chip->uart->cycles_per_byte : 1000;
  const bool listens = (chip->avr->data[chip->uart->r_ucsrb] & 0x10) != 0;
  if (listens) {
    const int byte = chip->wiring.receive(chip->wiring.context);
    if (byte >= 0) {
      const unsigned unread = (unsigned)(chip->uart->input.write - chip->uart->input.read) & 63u;
      if (unread >= kUartBuffer) {
        ++chip->overruns;
      } else {
        avr_raise_irq(chip->uart_input, (uint32_t)byte);
      }
    }
  }
  return when + byte_time;
}

/* simavr counts 11 bits for a byte. */
static void on_baud(avr_t* avr, avr_io_addr_t addr, uint8_t value, void* param) {
  (void)avr, (void)addr, (void)value;
  struct avr_chip* chip = param;
  chip->uart->cycles_per_byte = chip->uart->cycles_per_byte / 11 * 10;
}

static void on_port(avr_irq_t* irq, uint32_t value, void* param) {
  struct port* port = param;
  if (irq == port->irqs + IOPORT_IRQ_REG_PORT) {
    port->value = (uint8_t)value;
  } else {
    port->direction = (uint8_t)value;
  }
  port->chip->wiring.port(port->chip->wiring.context, port->name, port->value, port->direction);
}

static void on_convert(avr_irq_t* irq, uint32_t value, void* param) {
  (void)irq, (void)value;
  struct avr_chip* chip = param;
  chip->wiring.convert(chip->wiring.context);
}

static avr_cycle_count_t on_wake(avr_t* avr, avr_cycle_count_t when, void* param) {
  (void)avr;
  struct avr_chip* chip = param;
  chip->wiring.woken(chip->wiring.context, when);
  return 0;
}

/* avr_reset has cancelled all timers and announces no pins. */
static void on_reset(avr_t* avr) {
  struct avr_chip* chip = the_chip;
  if (chip->core_reset != NULL) chip->core_reset(avr);
  for (int i = 0; i < 3; ++i) chip->ports[i].value = chip->ports[i].direction = 0;
  avr_extint_set_strict_lvl_trig(avr, 0, 0);
  avr_extint_set_strict_lvl_trig(avr, 1, 0);
  avr_cycle_timer_register(avr, 1000, feed, chip);
  chip->wiring.reset(chip->wiring.context);
}

static avr_uart_t* find_uart(avr_t* avr) {
  for (avr_io_t* io = avr->io_port; io != NULL; io = io->next) {
    if (io->kind != NULL && strcmp(io->kind, "uart") == 0) return (avr_uart_t*)io;
  }
  return NULL;
}

struct avr_chip* avr_chip_open(const char* elf, const struct avr_chip_wiring* wiring) {
  avr_global_logger_set(be_quiet);
  elf_firmware_t firmware;
  memset(&firmware, 0, sizeof firmware);
  if (elf_read_firmware(elf, &firmware) != 0) return NULL;
  avr_t* avr = avr_make_mcu_by_name("atmega328p");
  if (avr == NULL) return NULL;
  struct avr_chip* chip = calloc(1, sizeof *chip);
  the_chip = chip;
  chip->avr = avr;
  chip->wiring = *wiring;
  avr_init(avr);
  avr->frequency = 16000000;
  avr_load_firmware(avr, &firmware);
  avr->frequency = 16000000;
  avr->vcc = avr->avcc = avr->aref = 5000;
  avr->sleep = sleep_without_waiting;

  uint32_t flags = 0;
  avr_ioctl(avr, AVR_IOCTL_UART_SET_FLAGS('0'), &flags);
  chip->uart = find_uart(avr);
  chip->uart_input = avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_INPUT);
  avr_irq_register_notify(
      avr_io_getirq(avr, AVR_IOCTL_UART_GETIRQ('0'), UART_IRQ_OUTPUT), on_sent, chip);
  avr_register_io_write(avr, kUbrr0l, on_baud, chip);
  chip->adc = avr_io_getirq(avr, AVR_IOCTL_ADC_GETIRQ, 0);
  avr_irq_register_notify(chip->adc + ADC_IRQ_OUT_TRIGGER, on_convert, chip);
  for (int i = 0; i < 3; ++i) {
    struct port* port = &chip->ports[i];
    port->chip = chip;
    port->name = (char)('B' + i);
    port->irqs = avr_io_getirq(avr, AVR_IOCTL_IOPORT_GETIRQ((uint32_t)port->name), 0);
    avr_irq_register_notify(port->irqs + IOPORT_IRQ_REG_PORT, on_port, port);
    avr_irq_register_notify(port->irqs + IOPORT_IRQ_DIRECTION_ALL, on_port, port);
  }
  chip->core_reset = avr->reset;
  avr->reset = on_reset;
  on_reset(avr);
  return chip;
}

void avr_chip_close(struct avr_chip* chip) {
  if (chip == NULL) return;
  avr_terminate(chip->avr);
  free(chip->avr);
  if (the_chip == chip) the_chip = NULL;
  free(chip);
}

int avr_chip_run(struct avr_chip* chip, uint64_t cycle) {
  while (chip->avr->cycle < cycle) {
    const int state = avr_run(chip->avr);
    if (state == cpu_Done || state == cpu_Crashed) return 0;
  }
  return 1;
}

uint64_t avr_chip_cycle(const struct avr_chip* chip) {
  return chip->avr->cycle;
}

void avr_chip_reset(struct avr_chip* chip) {
  avr_reset(chip->avr);
}

void avr_chip_wake_at(struct avr_chip* chip, uint64_t cycle) {
  const uint64_t now = chip->avr->cycle;
  avr_cycle_timer_register(chip->avr, cycle > now ? cycle - now : 1, on_wake, chip);
}

void avr_chip_set_pin(struct avr_chip* chip, char port, int bit, int level) {
  avr_raise_irq(chip->ports[port - 'B'].irqs + bit, (uint32_t)level);
}

void avr_chip_set_millivolts(struct avr_chip* chip, int channel, int millivolts) {
  avr_raise_irq(chip->adc + ADC_IRQ_ADC0 + channel, (uint32_t)millivolts);
}

uint64_t avr_chip_busy_cycles(const struct avr_chip* chip) {
  return chip->avr->cycle - chip->slept;
}

uint64_t avr_chip_overruns(const struct avr_chip* chip) {
  return chip->overruns;
}

/* simavr frees neither firmware nor irqs: no leaks of ours. Read by LeakSanitizer, if it is there. */
const char* __lsan_default_suppressions(void);
const char* __lsan_default_suppressions(void) {
  return "leak:libsimavr\n";
}
const char* __lsan_default_options(void);
const char* __lsan_default_options(void) {
  return "print_suppressions=0";
}
