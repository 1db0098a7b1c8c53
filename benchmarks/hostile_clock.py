"""A wall clock that can be set back for some processes, without touching that of the machine.

A small library, compiled here and loaded first into the processes (LD_PRELOAD), answers for the C
library: what asks for wall time gets it minus an offset, which lies in a shared file; what waits
for a wall time waits for that. Waits that had begun are not prolonged, as those of a real clock
set back would be.
"""

from __future__ import annotations

import mmap
import shutil
import struct
import subprocess
from pathlib import Path
from typing import Final

_OFFSET: Final = struct.Struct("<q")  # [s]
_HOUR: Final = 3600  # [s]
_SOURCE: Final = """
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdint.h>
#include <stdlib.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>
static volatile int64_t *offset;
__attribute__((constructor)) static void begin(void) {
    const char *name = getenv("HOSTILE_CLOCK");
    int file = name ? open(name, O_RDONLY) : -1;
    if (file < 0) return;
    void *at = mmap(0, 8, PROT_READ, MAP_SHARED, file, 0);
    if (at != MAP_FAILED) offset = at;
    close(file);
}
int clock_gettime(clockid_t id, struct timespec *now) {
    int code = syscall(SYS_clock_gettime, id, now);
    if (!code && offset && (id == CLOCK_REALTIME || id == CLOCK_REALTIME_COARSE))
        now->tv_sec -= *offset;
    return code;
}
int gettimeofday(struct timeval *restrict now, void *restrict zone) {
    int code = syscall(SYS_gettimeofday, now, zone);
    if (!code && now && offset) now->tv_sec -= *offset;
    return code;
}
time_t time(time_t *at) {
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (at) *at = now.tv_sec;
    return now.tv_sec;
}
/* Deadlines of wall time, told from those of the clock since boot by their size. */
static struct timespec real(const struct timespec *until) {
    struct timespec moved = *until, boot;
    syscall(SYS_clock_gettime, CLOCK_MONOTONIC, &boot);
    if (offset && moved.tv_sec > boot.tv_sec + 1000000000L / 2) moved.tv_sec += *offset;
    return moved;
}
#define WAIT(NAME, TYPES, NAMES) \\
    int NAME TYPES { \\
        static int (*next) TYPES; \\
        if (!next) next = dlsym(RTLD_NEXT, #NAME); \\
        struct timespec moved = real(until); \\
        return next NAMES; \\
    }
WAIT(pthread_cond_timedwait, (pthread_cond_t *c, pthread_mutex_t *m, const struct timespec *until),
     (c, m, &moved))
WAIT(pthread_cond_clockwait,
     (pthread_cond_t *c, pthread_mutex_t *m, clockid_t k, const struct timespec *until),
     (c, m, k, &moved))
WAIT(pthread_mutex_timedlock, (pthread_mutex_t *m, const struct timespec *until), (m, &moved))
WAIT(pthread_mutex_clocklock, (pthread_mutex_t *m, clockid_t k, const struct timespec *until),
     (m, k, &moved))
WAIT(sem_timedwait, (sem_t *s, const struct timespec *until), (s, &moved))
WAIT(sem_clockwait, (sem_t *s, clockid_t k, const struct timespec *until), (s, k, &moved))
"""


class NoCompiler(Exception):
    """There is no C compiler here."""


class SetBack:
    """A clock that can be set back.

    Parameters
    ----------
    folder
        For the library and the offset.
    """

    def __init__(self, folder: Path) -> None:
        compiler = shutil.which("cc")
        if compiler is None:
            raise NoCompiler("no C compiler `cc` to build a clock that can be set back")
        source, library = folder / "clock.c", folder / "clock.so"
        source.write_text(_SOURCE)
        command = [compiler, "-shared", "-fPIC", "-O2", "-o", str(library), str(source)]
        subprocess.run(command, check=True, capture_output=True, timeout=60)
        self._file = folder / "offset"
        self._file.write_bytes(_OFFSET.pack(0).ljust(mmap.PAGESIZE, b"\0"))
        self.environment = {"LD_PRELOAD": str(library), "HOSTILE_CLOCK": str(self._file)}
        """Of the processes that are to believe it."""

    def set_back(self) -> None:
        """Set it back by an hour."""
        with self._file.open("r+b") as file:
            file.write(_OFFSET.pack(_HOUR))
