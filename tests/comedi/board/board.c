// SPDX-License-Identifier: GPL-2.0
/* clang-format off: columns below */
/*
 * A Comedi board with the paper's motor behind it, for tests: analog in (um, ua, ia), analog out
 * (uc), relay lines, a counter with direction. Time passes in the motor as it does outside.
 *
 * digital  = 0  one port of 32 lines, direction for each line (as on NI boards)
 *            1  an 8255 of 24 lines by the kernel's own comedi_8255; its chip clears its latches
 *               when directions change
 *            2  three ports of 8 lines
 * commands = 0  the analog inputs have single reads only
 *            1  they take commands, whose first scan begins at once
 *            2  whose first scan begins a period later
 *
 * /proc/motor_bench tells what the terminals saw; written to, it takes
 *   mark    the times begin anew
 *   fail    every instruction and command fails with EIO (works: no longer)
 *   unplug  the device goes while it is open, as one on USB (plug: it is back)
 */
/* clang-format on */
#include <linux/comedi/comedi_8255.h>
#include <linux/comedi/comedidev.h>
#include <linux/device.h>
#include <linux/hrtimer.h>
#include <linux/ktime.h>
#include <linux/module.h>
#include <linux/proc_fs.h>
#include <linux/random.h>
#include <linux/seq_file.h>
#include <linux/spinlock.h>

#include "motor.h"

static int digital;
module_param(digital, int, 0444);
static int commands;
module_param(commands, int, 0444);
static int reverses; /* the amplifier's supply has both signs */
module_param(reverses, int, 0444);

enum { AI, AO, COUNTER, DIGITAL }; /* subdevices; the ports come last */
enum { BOARD_R12 = 2, BOARDS = 4 };

#define AI_CHANNELS 8
#define MIDDLE_CHANNEL 1 /* of um, ua, ia */
#define CONVERT_MIN_NS 5000
#define COUNTER_MAX 0xffffff
#define COUNTER_START 0xfffff0 /* wraps soon */
#define CODE_ZERO 32768
#define UV_PER_CODE(code) (((s64)(code)-CODE_ZERO) * 20000000 / 65535)

static struct {
  spinlock_t lock; /* also taken by the scans' timer, in a softirq */
  struct motor motor;
  u64 at_ns; /* of the motor */
  u32 latch, outputs;
  u8 chip_control;
  int failing, armed;
  s64 pulses_at_reset;
  const char* first; /* instruction after the device was opened */
  u32 born_low;      /* lines whose latch was 0 when they became outputs */
  u64 mark_ns, zero_ns, drive_writes;
  u64 edge_ns; /* of the newest write of the drive */
  /* from there to the conversions of MIDDLE_CHANNEL, since the mark */
  u64 deltas, delta_sum_ns, delta_min_ns, delta_max_ns;
  u64 crowded_since, crowded_ns; /* longest time that R1, R9 or C8 had two contacts */
  u64 open_since, open_ns;       /* longest time that R12 had none */
} bench = {.lock = __SPIN_LOCK_UNLOCKED(bench.lock), .first = ""};

/* The command of the analog inputs. */
static struct {
  struct hrtimer timer;
  struct comedi_device* dev;
  struct comedi_subdevice* s;
  u64 at_ns;            /* of the next conversion */
  unsigned int channel; /* of the channel list */
  u64 begin_ns;         /* of the scan */
  u64 taken;            /* commands since the module was loaded */
} scan;

static struct class* bench_class;
static struct device* bench_device;
static int plugged;

/* Contacts as the lines are now: inputs are pulled up. */
static void follow_lines(u64 now) {
  int i, crowded = 0;

  motor_switch(&bench.motor, bench.latch | ~bench.outputs);
  for (i = 0; i < BOARDS; ++i)
    if (i != BOARD_R12 && motor_contacts(bench.motor.levels, i) > 1) crowded = 1;
  if (crowded && !bench.crowded_since) bench.crowded_since = now;
  if (bench.crowded_since && !crowded) {
    bench.crowded_ns = max(bench.crowded_ns, now - bench.crowded_since);
    bench.crowded_since = 0;
  }
  if (motor_contacts(bench.motor.levels, BOARD_R12) == 0) {
    if (!bench.open_since) bench.open_since = now;
  } else if (bench.open_since) {
    bench.open_ns = max(bench.open_ns, now - bench.open_since);
    bench.open_since = 0;
  }
}

static u64 advance_to(u64 now) {
  if (now <= bench.at_ns) return bench.at_ns;
  motor_advance(&bench.motor, min_t(u64, now - bench.at_ns, 2 * NSEC_PER_SEC));
  bench.at_ns = now;
  return now;
}

static u64 advance(void) {
  return advance_to(ktime_get_ns());
}

/* Every instruction begins here: with the lock, the motor at the present time. */
static int begin(const char* what) {
  spin_lock_bh(&bench.lock);
  advance();
  if (!*bench.first) bench.first = what;
  if (!bench.failing) return 0;
  spin_unlock_bh(&bench.lock);
  return -EIO;
}

static void end(void) {
  spin_unlock_bh(&bench.lock);
}

static s64 noise_uv(s64 rms_uv) {
  const u32 r = get_random_u32(); /* the sum of four bytes: rms 147.8 */

  return ((s64)((r & 255) + (r >> 8 & 255) + (r >> 16 & 255) + (r >> 24)) - 510) * rms_uv / 148;
}

/* @counts: this conversion is one that the program wants, its time from the drive's edge matters.
 */
static u16 convert(unsigned int channel, int counts) {
  const struct motor* m = &bench.motor;
  const u64 delta_ns = bench.at_ns - bench.edge_ns;
  s64 uv = 0;

  switch (channel) {
    case 0:
      uv = m->um_uv / 2 + noise_uv(7500);
      break;
    case 1:
      uv = m->ua_uv / 2 + noise_uv(7500);
      break;
    case 2:
      uv = m->ia_ua * 5 + noise_uv(5000);
      break;
  }
  if (channel == MIDDLE_CHANNEL && counts) {
    if (!bench.deltas++ || delta_ns < bench.delta_min_ns) bench.delta_min_ns = delta_ns;
    bench.delta_max_ns = max(bench.delta_max_ns, delta_ns);
    bench.delta_sum_ns += delta_ns;
  }
  return clamp_t(s64, div64_s64(uv * 65535, 20000000) + CODE_ZERO, 0, 65535);
}

static int ai_read(struct comedi_device* dev,
                   struct comedi_subdevice* s,
                   struct comedi_insn* insn,
                   unsigned int* data) {
  unsigned int i;
  int status = begin("analog in");

  if (status) return status;
  for (i = 0; i < insn->n; ++i) data[i] = convert(CR_CHAN(insn->chanspec), 1);
  end();
  return insn->n;
}

/* One conversion of the command, by the board's timer: its time is the timer's, not that of the
 * processor which comes later. Of a command only the last scan is wanted. */
static enum hrtimer_restart convert_next(struct hrtimer* timer) {
  struct comedi_async* async = scan.s->async;
  struct comedi_cmd* cmd = &async->cmd;
  u16 code;

  spin_lock_bh(&bench.lock);
  advance_to(scan.at_ns);
  code = convert(CR_CHAN(cmd->chanlist[scan.channel]), async->scans_done + 1 == cmd->stop_arg);
  spin_unlock_bh(&bench.lock);
  comedi_buf_write_samples(scan.s, &code, 1);
  if (++scan.channel < cmd->chanlist_len) {
    scan.at_ns += cmd->convert_arg;
  } else {
    scan.channel = 0;
    scan.begin_ns += cmd->scan_begin_arg;
    scan.at_ns = scan.begin_ns;
    if (async->scans_done >= cmd->stop_arg) async->events |= COMEDI_CB_EOA;
  }
  if (async->events & COMEDI_CB_EOA) {
    comedi_handle_events(scan.dev, scan.s);
    return HRTIMER_NORESTART;
  }
  comedi_handle_events(scan.dev, scan.s);
  hrtimer_set_expires(timer, ns_to_ktime(scan.at_ns));
  return HRTIMER_RESTART;
}

static int ai_command_test(struct comedi_device* dev,
                           struct comedi_subdevice* s,
                           struct comedi_cmd* cmd) {
  int wrong = 0;

  wrong |= comedi_check_trigger_src(&cmd->start_src, TRIG_NOW);
  wrong |= comedi_check_trigger_src(&cmd->scan_begin_src, TRIG_TIMER);
  wrong |= comedi_check_trigger_src(&cmd->convert_src, TRIG_TIMER);
  wrong |= comedi_check_trigger_src(&cmd->scan_end_src, TRIG_COUNT);
  wrong |= comedi_check_trigger_src(&cmd->stop_src, TRIG_COUNT);
  if (wrong) return 1;
  wrong |= comedi_check_trigger_arg_is(&cmd->start_arg, 0);
  wrong |= comedi_check_trigger_arg_min(&cmd->convert_arg, CONVERT_MIN_NS);
  wrong |= comedi_check_trigger_arg_is(&cmd->scan_end_arg, cmd->chanlist_len);
  wrong |= comedi_check_trigger_arg_min(&cmd->scan_begin_arg, cmd->convert_arg * cmd->scan_end_arg);
  wrong |= comedi_check_trigger_arg_min(&cmd->stop_arg, 1);
  if (wrong) return 3;
  /* the timer has steps of a microsecond */
  wrong |= comedi_check_trigger_arg_is(&cmd->convert_arg, rounddown(cmd->convert_arg, 1000));
  wrong |= comedi_check_trigger_arg_is(&cmd->scan_begin_arg, rounddown(cmd->scan_begin_arg, 1000));
  return wrong ? 4 : 0;
}

static int ai_command(struct comedi_device* dev, struct comedi_subdevice* s) {
  int status = begin("analog command");

  if (status) return status;
  scan.dev = dev;
  scan.s = s;
  scan.channel = 0;
  scan.begin_ns = bench.at_ns + (commands == 2 ? s->async->cmd.scan_begin_arg : 0);
  scan.at_ns = scan.begin_ns;
  scan.taken++;
  end();
  hrtimer_start(&scan.timer, ns_to_ktime(scan.at_ns), HRTIMER_MODE_ABS_SOFT);
  return 0;
}

/* The timer itself calls this at the end of its command, and then does not begin again. */
static int ai_cancel(struct comedi_device* dev, struct comedi_subdevice* s) {
  if (!in_softirq()) hrtimer_cancel(&scan.timer);
  return 0;
}

static int ao_write(struct comedi_device* dev,
                    struct comedi_subdevice* s,
                    struct comedi_insn* insn,
                    unsigned int* data) {
  unsigned int i;
  int status = begin("analog out");

  if (status) return status;
  for (i = 0; i < insn->n; ++i) {
    const int was_driven = abs(bench.motor.uc_uv) > 1000;

    s->readback[CR_CHAN(insn->chanspec)] = data[i];
    bench.motor.uc_uv = UV_PER_CODE(data[i]);
    bench.drive_writes++;
    bench.edge_ns = bench.at_ns;
    if (was_driven && abs(bench.motor.uc_uv) <= 1000) bench.zero_ns = bench.at_ns;
  }
  end();
  return insn->n;
}

static void make_outputs(u32 lines) {
  bench.born_low |= lines & ~bench.outputs & ~bench.latch;
  bench.outputs = lines;
}

/* The first line of a port: ports of 8 stand behind one another. */
static int base_of(struct comedi_subdevice* s) {
  return 8 * (s->index - DIGITAL);
}

static int dio_bits(struct comedi_device* dev,
                    struct comedi_subdevice* s,
                    struct comedi_insn* insn,
                    unsigned int* data) {
  int status = begin(data[0] ? "digital write" : "digital read");

  if (status) return status;
  if (comedi_dio_update_state(s, data)) {
    const u32 mask = (s->n_chan < 32 ? (1u << s->n_chan) - 1 : ~0u) << base_of(s);

    bench.latch = (bench.latch & ~mask) | (s->state << base_of(s) & mask);
    follow_lines(bench.at_ns);
  }
  data[1] = (bench.latch | ~bench.outputs) >> base_of(s);
  if (s->n_chan < 32) data[1] &= (1u << s->n_chan) - 1;
  end();
  return insn->n;
}

static int dio_config(struct comedi_device* dev,
                      struct comedi_subdevice* s,
                      struct comedi_insn* insn,
                      unsigned int* data) {
  int status = begin("digital configuration");

  if (status) return status;
  status = comedi_dio_insn_config(dev, s, insn, data, 0);
  if (status == 0) {
    const u32 mask = (s->n_chan < 32 ? (1u << s->n_chan) - 1 : ~0u) << base_of(s);

    make_outputs((bench.outputs & ~mask) | s->io_bits << base_of(s));
    follow_lines(bench.at_ns);
    status = insn->n;
  }
  end();
  return status;
}

/* Registers of an 8255 in mode 0. A control word clears the latches of all ports. */
static int chip_io(struct comedi_device* dev, int write, int port, int data, unsigned long base) {
  int answer = 0;

  spin_lock_bh(&bench.lock);
  advance();
  if (!*bench.first) bench.first = "8255";
  if (port == I8255_CTRL_REG && write && (data & I8255_CTRL_CW)) {
    bench.latch = 0;
    make_outputs((data & I8255_CTRL_A_IO ? 0 : 0xff) | (data & I8255_CTRL_B_IO ? 0 : 0xff00) |
                 (data & I8255_CTRL_C_LO_IO ? 0 : 0xf0000) |
                 (data & I8255_CTRL_C_HI_IO ? 0 : 0xf00000));
  } else if (port < I8255_CTRL_REG && write) {
    bench.latch = (bench.latch & ~(0xffu << 8 * port)) | (u32)(data & 0xff) << 8 * port;
  } else if (port < I8255_CTRL_REG) {
    answer = (bench.latch | ~bench.outputs) >> 8 * port & 0xff;
  }
  follow_lines(bench.at_ns);
  spin_unlock_bh(&bench.lock);
  return answer;
}

static u32 count(void) {
  return (u32)(motor_pulses(&bench.motor) - bench.pulses_at_reset + COUNTER_START) & COUNTER_MAX;
}

static int counter_read(struct comedi_device* dev,
                        struct comedi_subdevice* s,
                        struct comedi_insn* insn,
                        unsigned int* data) {
  unsigned int i;
  int status = begin("counter");

  if (status) return status;
  for (i = 0; i < insn->n; ++i) data[i] = bench.armed ? count() : 0;
  end();
  return insn->n;
}

static int counter_config(struct comedi_device* dev,
                          struct comedi_subdevice* s,
                          struct comedi_insn* insn,
                          unsigned int* data) {
  int status = begin("counter configuration");

  if (status) return status;
  switch (data[0]) {
    case INSN_CONFIG_RESET:
      bench.armed = 0;
      bench.pulses_at_reset = motor_pulses(&bench.motor);
      break;
    case INSN_CONFIG_ARM:
      bench.armed = 1;
      break;
    default:
      status = -EINVAL;
  }
  end();
  return status ? status : insn->n;
}

static int bench_open(struct comedi_device* dev) {
  spin_lock_bh(&bench.lock);
  bench.first = "";
  spin_unlock_bh(&bench.lock);
  return 0;
}

static void analog(struct comedi_subdevice* s, int type, int channels) {
  s->type = type;
  s->subdev_flags =
      (type == COMEDI_SUBD_AI ? SDF_READABLE : SDF_WRITABLE) | SDF_GROUND | SDF_COMMON | SDF_DIFF;
  s->n_chan = channels;
  s->maxdata = 65535;
  s->range_table = &range_bipolar10;
}

static int bench_attach(struct comedi_device* dev, unsigned long context) {
  const int ports = digital == 2 ? 3 : 1;
  struct comedi_subdevice* s;
  int i, status;

  dev->board_name = "motor_bench";
  dev->open = bench_open;
  status = comedi_alloc_subdevices(dev, DIGITAL + ports);
  if (status) return status;

  s = &dev->subdevices[AI];
  analog(s, COMEDI_SUBD_AI, AI_CHANNELS);
  s->insn_read = ai_read;
  if (commands) {
    dev->read_subdev = s;
    s->subdev_flags |= SDF_CMD_READ;
    s->len_chanlist = AI_CHANNELS;
    s->do_cmdtest = ai_command_test;
    s->do_cmd = ai_command;
    s->cancel = ai_cancel;
  }

  s = &dev->subdevices[AO];
  analog(s, COMEDI_SUBD_AO, 2);
  s->insn_write = ao_write;
  status = comedi_alloc_subdev_readback(s);
  if (status) return status;

  s = &dev->subdevices[COUNTER];
  s->type = COMEDI_SUBD_COUNTER;
  s->subdev_flags = SDF_READABLE | SDF_LSAMPL;
  s->n_chan = 1;
  s->maxdata = COUNTER_MAX;
  s->insn_read = counter_read;
  s->insn_config = counter_config;

  for (i = 0; i < ports; ++i) {
    s = &dev->subdevices[DIGITAL + i];
    if (digital == 1) return subdev_8255_init(dev, s, chip_io, 0);
    s->type = COMEDI_SUBD_DIO;
    s->subdev_flags = SDF_READABLE | SDF_WRITABLE;
    s->n_chan = digital == 2 ? 8 : 32;
    s->maxdata = 1;
    s->range_table = &range_digital;
    s->insn_bits = dio_bits;
    s->insn_config = dio_config;
  }
  return 0;
}

static void bench_detach(struct comedi_device* dev) {}

static struct comedi_driver bench_driver = {
    .driver_name = "motor_bench",
    .module = THIS_MODULE,
    .auto_attach = bench_attach,
    .detach = bench_detach,
};

static int show(struct seq_file* out, void* unused) {
  u64 now;

  spin_lock_bh(&bench.lock);
  now = advance();
  seq_printf(out, "drive_uv %lld\n", bench.motor.uc_uv);
  seq_printf(out, "since_mark_us %llu\n", div_u64(now - bench.mark_ns, 1000));
  /* from the mark to the write that ended the last drive; -1: not since the mark */
  seq_printf(
      out,
      "zero_after_us %lld\n",
      bench.zero_ns > bench.mark_ns ? (s64)div_u64(bench.zero_ns - bench.mark_ns, 1000) : -1);
  seq_printf(out, "drive_writes %llu\n", bench.drive_writes);
  seq_printf(out, "commands %llu\n", scan.taken);
  seq_printf(out, "deltas %llu\n", bench.deltas);
  seq_printf(out, "delta_min_ns %llu\n", bench.delta_min_ns);
  seq_printf(out, "delta_max_ns %llu\n", bench.delta_max_ns);
  seq_printf(
      out, "delta_mean_ns %llu\n", bench.deltas ? div64_u64(bench.delta_sum_ns, bench.deltas) : 0);
  seq_printf(out, "lines 0x%08x\n", bench.motor.levels);
  seq_printf(out, "outputs 0x%08x\n", bench.outputs);
  seq_printf(out, "born_low 0x%08x\n", bench.born_low);
  seq_printf(out, "crowded_us %llu\n", div_u64(bench.crowded_ns, 1000));
  seq_printf(out, "open_us %llu\n", div_u64(bench.open_ns, 1000));
  seq_printf(out, "um_uv %lld\n", bench.motor.um_uv);
  seq_printf(out, "ia_ua %lld\n", bench.motor.ia_ua);
  seq_printf(out, "speed_mrad_s %lld\n", bench.motor.speed_urad_s / 1000);
  seq_printf(out, "first %s\n", bench.first);
  spin_unlock_bh(&bench.lock);
  return 0;
}

static int open_proc(struct inode* inode, struct file* file) {
  return single_open(file, show, NULL);
}

static ssize_t take_word(struct file* file, const char __user* user, size_t length, loff_t* at) {
  char word[16] = "";

  if (length == 0 || length >= sizeof(word) || copy_from_user(word, user, length)) return -EINVAL;
  if (word[length - 1] == '\n') word[length - 1] = 0;
  if (!strcmp(word, "unplug")) {
    if (plugged) comedi_auto_unconfig(bench_device);
    plugged = 0;
    return length;
  }
  if (!strcmp(word, "plug")) {
    if (!plugged && comedi_auto_config(bench_device, &bench_driver, 0)) return -EIO;
    plugged = 1;
    return length;
  }
  spin_lock_bh(&bench.lock);
  if (!strcmp(word, "mark")) {
    bench.mark_ns = ktime_get_ns();
    bench.crowded_ns = bench.open_ns = 0;
    bench.deltas = bench.delta_sum_ns = bench.delta_max_ns = 0;
    if (bench.crowded_since) bench.crowded_since = bench.mark_ns;
    if (bench.open_since) bench.open_since = bench.mark_ns;
  } else if (!strcmp(word, "fail")) {
    bench.failing = 1;
  } else if (!strcmp(word, "works")) {
    bench.failing = 0;
  } else {
    length = -EINVAL;
  }
  spin_unlock_bh(&bench.lock);
  return length;
}

static const struct proc_ops proc_ops = {
    .proc_open = open_proc,
    .proc_read = seq_read,
    .proc_lseek = seq_lseek,
    .proc_release = single_release,
    .proc_write = take_word,
};

static int __init bench_init(void) {
  int status;

  bench.at_ns = bench.mark_ns = ktime_get_ns();
  bench.motor.rail_max_uv = 15000000;
  bench.motor.rail_min_uv = reverses ? -15000000 : 0;
  bench.motor.levels = ~0u;
  hrtimer_init(&scan.timer, CLOCK_MONOTONIC, HRTIMER_MODE_ABS_SOFT);
  scan.timer.function = convert_next;
  status = comedi_driver_register(&bench_driver);
  if (status) return status;
  bench_class = class_create(THIS_MODULE, "motor_bench");
  bench_device = device_create(bench_class, NULL, MKDEV(0, 0), NULL, "motor_bench");
  proc_create("motor_bench", 0600, NULL, &proc_ops);
  plugged = comedi_auto_config(bench_device, &bench_driver, 0) == 0;
  return 0;
}

static void __exit bench_exit(void) {
  remove_proc_entry("motor_bench", NULL);
  if (plugged) comedi_auto_unconfig(bench_device);
  device_destroy(bench_class, MKDEV(0, 0));
  class_destroy(bench_class);
  comedi_driver_unregister(&bench_driver);
}

module_init(bench_init);
module_exit(bench_exit);
MODULE_LICENSE("GPL");
MODULE_DESCRIPTION("A Comedi board with a motor behind it");
