"""A virtual machine with Debian's kernel, the board of `board/` and the program under test in memory."""

import base64
import glob
import os
import re
import shutil
import socket
import subprocess
import threading
import time

HERE = os.path.dirname(os.path.abspath(__file__))
SUBJECT_TO_LOAD_S = 300.0  # a busy host is slow, not broken
# The machine's time passes with its instructions, 2 ns each: however busy the host is, the machine
# sees a processor of 500 MIPS and no delays.
STEADY = ("-icount", "shift=1,sleep=off")
GONE = "(the machine has ended)"
START = """#!/bin/busybox sh
/bin/busybox --install -s /bin
mount -t proc none /proc
mount -t sysfs none /sys
mount -t devtmpfs none /dev
mount -t tmpfs none /tmp
export PATH=/bin HOME=/tmp TZ=UTC
export ASAN_OPTIONS=quarantine_size_mb=16:malloc_context_size=1:detect_leaks=0
ip link set lo up
ip link set lo multicast on
ip route add 239.255.76.67/32 dev lo
for module in comedi comedi_8255 e1000; do insmod /modules/$module.ko; done
ip addr add 10.0.2.15/24 dev eth0
ip link set eth0 up
stty -echo
echo "the machine is up"
while true; do while IFS= read -r line; do eval "$line"; done; done
"""


class Failure(Exception):
    """Of a check; its text says what was seen."""


def build_module(cache, version):
    """The board as a module of Debian's kernel: cache/module/motor_bench.ko."""
    module = os.path.join(cache, "module")
    shutil.rmtree(module, ignore_errors=True)
    shutil.copytree(os.path.join(HERE, "board"), module)
    made = subprocess.run(
        ["make", "-s", "-C", f"{cache}/root/usr/src/linux-headers-{version}", f"M={module}", "modules"],
        capture_output=True,
        text=True,
    )
    if made.returncode != 0:
        raise Failure(f"the board's module does not build:\n{made.stdout}{made.stderr}")
    return os.path.join(module, "motor_bench.ko")


def libraries_of(program):
    """Paths of the shared libraries that a program is loaded with, and of libcomedi, loaded later."""
    named = subprocess.run(["ldd", program], check=True, capture_output=True, text=True).stdout
    found = set(re.findall(r"(/\S+) \(0x", named))
    known = subprocess.run(["/sbin/ldconfig", "-p"], check=True, capture_output=True, text=True).stdout
    comedi = re.search(r"libcomedi\.so\.0 .*=> (\S+)", known)
    if comedi is None:
        raise Failure("libcomedi.so.0 is not installed: deploy/setup")
    return found | {comedi.group(1)}


def memory_image(cache, version, program):
    """An archive of everything that the machine has: cache/memory.cpio."""
    tree = os.path.join(cache, "tree")
    shutil.rmtree(tree, ignore_errors=True)
    for folder in ("bin", "modules", "proc", "sys", "dev", "tmp", "etc"):
        os.makedirs(os.path.join(tree, folder))

    def put(source, target):
        target = tree + target
        os.makedirs(os.path.dirname(target), exist_ok=True)
        shutil.copy(source, target)

    busybox = f"{cache}/root/bin/busybox"
    put(busybox, "/bin/busybox")
    with open(os.path.join(HERE, "..", "..", "benches", "paper.toml"), encoding="utf8") as text:
        described = text.read()
    with open(f"{tree}/counted.toml", "w", encoding="utf8") as text:  # Comedi has a count and no frequency
        text.write(described.replace("[channel.n]\n", "[channel.n]\ncounted = true\n"))
    subprocess.run(["strip", "-o", f"{tree}/bin/faultlab", program], check=True)
    for library in libraries_of(program):
        put(os.path.realpath(library), library)
    kernel = f"{cache}/root/lib/modules/{version}/kernel/drivers"
    for module in ("comedi/comedi", "comedi/drivers/comedi_8255", "net/ethernet/intel/e1000/e1000"):
        put(f"{kernel}/{module}.ko", f"/modules/{os.path.basename(module)}.ko")
    put(build_module(cache, version), "/modules/motor_bench.ko")
    with open(f"{tree}/init", "w", encoding="utf8") as init:
        init.write(START)
    os.chmod(f"{tree}/init", 0o755)
    with open(f"{tree}/etc/passwd", "w", encoding="utf8") as users:
        users.write("root::0:0:root:/tmp:/bin/sh\n")
    image = os.path.join(cache, "memory.cpio")
    with open(image, "wb") as out:
        names = subprocess.run(["find", "."], cwd=tree, check=True, capture_output=True).stdout
        subprocess.run(
            [busybox, "cpio", "-o", "-H", "newc"],
            cwd=tree, check=True, input=names, stdout=out, stderr=subprocess.DEVNULL,
        )
    return image


def free_port():
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


class Machine:
    """Boots in the constructor; a shell on its serial line."""

    def __init__(self, cache, version, image, log):
        root = os.path.join(cache, "root")
        qemu = shutil.which("qemu-system-x86_64")
        environment = dict(os.environ)
        shares = []
        if qemu is None:
            qemu = f"{root}/usr/bin/qemu-system-x86_64"
            environment["LD_LIBRARY_PATH"] = ":".join(
                glob.glob(f"{root}/usr/lib/x86_64-linux-gnu") + glob.glob(f"{root}/lib/x86_64-linux-gnu")
            )
            environment["QEMU_MODULE_DIR"] = f"{root}/usr/lib/x86_64-linux-gnu/qemu"
            shares = ["-L", f"{root}/usr/share/qemu", "-L", f"{root}/usr/share/seabios",
                      "-L", f"{root}/usr/lib/ipxe/qemu"]
        self.port = free_port()  # of the server in the machine, from outside
        self.log = open(log, "w", encoding="utf8")
        self.heard = ""
        self.news = threading.Condition()
        self.commands = 0
        began = time.monotonic()
        self.process = subprocess.Popen(
            [qemu, *shares, "-accel", "tcg", *STEADY, "-m", "2000", "-smp", "1",
             "-kernel", f"{root}/boot/vmlinuz-{version}", "-initrd", image,
             "-append", "console=ttyS0 panic=-1 quiet", "-display", "none", "-serial", "stdio",
             "-parallel", "null", "-monitor", "none", "-no-reboot",
             "-device", "e1000,netdev=net,romfile=",
             "-netdev", f"user,id=net,restrict=on,hostfwd=tcp:127.0.0.1:{self.port}-10.0.2.15:8080"],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, env=environment,
        )
        threading.Thread(target=self._listen, daemon=True).start()
        with self.news:
            self.news.wait_for(lambda: "the machine is up" in self.heard or GONE in self.heard,
                               SUBJECT_TO_LOAD_S)
        self.sh("true")
        self.boot_s = time.monotonic() - began

    def _listen(self):
        while data := os.read(self.process.stdout.fileno(), 4096):
            text = data.decode("utf8", "replace").replace("\r", "")
            self.log.write(text)
            self.log.flush()
            with self.news:
                self.heard += text
                self.news.notify_all()
        with self.news:
            self.heard += f"\n{GONE}\n"
            self.news.notify_all()

    def sh(self, command, patience_s=SUBJECT_TO_LOAD_S):
        """Runs a command of the shell, one line. @returns its output and its status"""
        self.commands += 1
        mark = f"#{self.commands}#"
        with self.news:
            begin = len(self.heard)
            self.process.stdin.write(f"{command}; echo '{mark}' $?\n".encode())
            self.process.stdin.flush()
            answer = None

            def answered():
                nonlocal answer
                answer = re.search(rf"{mark} (\d+)\n", self.heard[begin:])
                return answer or GONE in self.heard

            if not self.news.wait_for(answered, patience_s) or answer is None:
                raise Failure(f"no answer to {command!r}; heard last: {self.heard[-1500:]}")
            return self.heard[begin:begin + answer.start()].strip(), int(answer.group(1))

    def write(self, path, text):
        content = base64.b64encode(text.encode()).decode()
        self.sh(f"echo {content} | base64 -d > {path}")

    def processor_s(self):
        """Processor time of the host that the machine has used: no load of the host stretches it."""
        with open(f"/proc/{self.process.pid}/stat", encoding="utf8") as text:
            user, system = text.read().rsplit(")", 1)[1].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")

    def end(self):
        self.process.kill()
        self.process.wait()
        self.log.close()

    # ---- the board ----

    def load_board(self, digital=0, commands=0, reverses=0):
        self.sh("rmmod motor_bench 2>/dev/null")
        said, status = self.sh(
            f"insmod /modules/motor_bench.ko digital={digital} commands={commands} reverses={reverses}"
        )
        if status != 0 or self.sh("test -c /dev/comedi0")[1] != 0:
            raise Failure(f"the board does not come up: {said}")

    def tell_board(self, word):
        if self.sh(f"echo {word} > /proc/motor_bench")[1] != 0:
            raise Failure(f"the board refuses {word}")

    def board(self):
        """What the terminals see: name -> number (text of `first`)."""
        said = self.sh("cat /proc/motor_bench")[0]
        values = dict(line.split(" ", 1) for line in said.splitlines() if " " in line)
        return {name: text if name == "first" else int(text, 0) for name, text in values.items()}
