"""Node as a child process: started, monitored, stopped, with its last output kept."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Thread
from typing import IO, Final, cast

from spacecraft_gnc.launcher.environment import LOG, TELL_WHERE
from spacecraft_gnc.launcher.output import Output

_OUTPUT_TIMEOUT: Final = 0.3  # [s] wall
_TELL_PATIENCE: Final = 5.0  # [s] wall for the first word about threads, on a busy machine
_POLL: Final = 0.02  # [s] wall
_EXIT_CODE: Final = 48  # place in /proc/PID/stat after the state: proc(5)


class NodeProcess:
    """One process that hosts one node, or several.

    Its output comes through a pipe and goes to a log file. The end of its standard input tells it
    that the launcher has ended, so that no node outlives a killed launcher; what it then still has
    to say it writes to the log itself.

    Parameters
    ----------
    name
        Name shown to the user.
    arguments
        Command line after the interpreter.
    environment
        Complete environment variables.
    log
        File for stdout and stderr; appended to.
    inherited
        Descriptors of open files that it inherits.
    """

    def __init__(
        self,
        name: str,
        arguments: Sequence[str],
        environment: Mapping[str, str],
        log: Path,
        inherited: Sequence[int] = (),
    ) -> None:
        self.name = name
        self.log = log
        self._asked_at = 0.0  # [s] wall
        self._overdue = 0.0  # [s] wall after which it was killed; 0: not killed
        self._popen = subprocess.Popen(
            [sys.executable, *arguments],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            env={**environment, LOG: str(log.absolute())},
            pass_fds=inherited,
            start_new_session=True,  # Ctrl-C reaches only the launcher, which ends us in order
        )
        self._output = Output(cast("IO[bytes]", self._popen.stdout), log)

    @property
    def pid(self) -> int:
        """Process id."""
        return self._popen.pid

    @property
    def exit_code(self) -> int | None:
        """Exit code, or minus the number of the signal that killed it; None while it runs."""
        code = self._popen.poll()
        return _code_of_main_thread(self.pid) if code is None else code

    def end(self) -> None:
        """Request a clean shutdown."""
        self._asked_at = time.monotonic()
        if self.exit_code is None:
            self._popen.terminate()

    def join(self, patience: float) -> int:
        """Wait for its end; kill it after ``patience`` [s] of wall time; return the exit code."""
        try:
            code = self._popen.wait(patience)
        except subprocess.TimeoutExpired:
            ended = self.exit_code
            code = self._kill(patience) if ended is None else ended
            if ended is not None:  # but for its last threads
                Thread(target=self._popen.wait, daemon=True).start()
        if self._popen.stdin is not None:
            self._popen.stdin.close()
        return code

    def _kill(self, patience: float) -> int:
        """Let it log the stacks of its threads, then kill it; return the exit code."""
        self._overdue = time.monotonic() - self._asked_at if self._asked_at else patience
        title = f"{self.name}: did not end within {self._overdue:.1f} s; its threads:\n"
        self._output.write(title.encode())
        self._popen.send_signal(TELL_WHERE)  # ends a process that has not become a node yet
        if not self._output.await_more(_TELL_PATIENCE):
            self._output.write(b"none of Python: it has not become a node yet, or is one no more\n")
        self._popen.kill()
        return self._popen.wait()

    def describe_end(self) -> str:
        """Return a description of how it ended."""
        code = self.exit_code
        if code is None:
            return f"{self.name} (pid {self.pid}) is running"
        if self._overdue:
            waited = f"{self._overdue:.0f} s"
            return f"{self.name} (pid {self.pid}) did not end within {waited} and was killed"
        if code < 0:
            return f"{self.name} (pid {self.pid}) was killed by {_signal_name(-code)}"
        return f"{self.name} (pid {self.pid}) ended with exit code {code}"

    def last_output(self) -> list[str]:
        """Return the last lines of its output."""
        return self._ended_output().last_lines()

    def errors(self) -> list[str]:
        """Return the ``error:`` lines among the last lines of its output, without the prefix."""
        return self._ended_output().errors()

    def last_error(self) -> str:
        """Return the last line of its output that tells of an error; empty: there is none."""
        return self._ended_output().last_error()

    @property
    def log_trouble(self) -> str:
        """Why its log is not complete; empty: it is."""
        return self._output.trouble

    def _ended_output(self) -> Output:
        """Return its output, the whole if it has ended."""
        if self.exit_code is not None:
            self._output.wait(_OUTPUT_TIMEOUT)
        return self._output


def end_all(processes: Sequence[NodeProcess], patience: float) -> None:
    """Stop several processes together, and wait for all of them."""
    for process in processes:
        process.end()
    deadline = time.monotonic() + patience
    for process in processes:
        process.join(max(_POLL, deadline - time.monotonic()))


def _code_of_main_thread(pid: int) -> int | None:
    """Return the exit code of a process of which only other threads still end; else None.

    A process that was killed is waited for until its last thread has run once more: seconds on a
    busy machine.
    """
    try:
        words = Path(f"/proc/{pid}/stat").read_text(encoding="ascii", errors="replace")
        state, *numbers = words.rpartition(")")[2].split()
        status = int(numbers[_EXIT_CODE])
    except (OSError, ValueError, IndexError):
        return None
    return os.waitstatus_to_exitcode(status) if state in "ZX" else None


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:
        return f"signal {number}"
