"""Starts the programs of a laboratory one after the other, and ends them together."""

from __future__ import annotations

import os
import re
import sched
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue
from types import FrameType

from gecos.laboratory.description import CLOCK_VARIABLE, LaboratoryDescription, Program
from gecos.laboratory.events import Event, Report, What, show

READY_WITHIN = 60.0  # s
END_WITHIN = 5.0  # s after SIGTERM, before SIGKILL
_LAST_LINES_WITHIN = 0.5  # s to read the last lines of a program that has ended
_LONGEST_LINE = 65536  # characters; a longer line is printed in parts
# Longest wait in s. A signal that arrives just before Python begins to wait is handled only after
# the wait.
_LOOK_ANYWAY = 0.5
_FIRST_PAUSE = 0.5  # s before a program is started again; each further pause is twice as long
_LONGEST_PAUSE = 30.0  # s
_LONG_RUN = 60.0  # s; after a run of this length, the next pause is _FIRST_PAUSE again


class LaboratoryError(RuntimeError):
    """A program of the laboratory is missing, or did not become ready."""


class _Process:
    """One run of a program, in a session and process group of its own. Each line of its output is
    reported."""

    def __init__(
        self,
        program: Program,
        command: Sequence[str],
        environment: Mapping[str, str],
        folder: Path,
        ended: Callable[[_Process], None],
        report: Report,
    ) -> None:
        self.program = program
        self._report = report
        self.since = time.monotonic()
        self._is_ready = program.ready == ""
        self._ready_or_ended = threading.Event()
        self._over = threading.Event()
        self._status = 0  # as `Popen.returncode`; valid once `_over` is set
        self._reaped = False
        self._ended = ended
        self._process = subprocess.Popen(
            [*_ends_with_us(), *command],
            cwd=folder,
            env={**environment, **program.environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            # Ctrl-C reaches only this process, which then ends the others in order.
            start_new_session=True,
        )
        self._reader = threading.Thread(target=self._pass_on, daemon=True)
        self._reader.start()
        threading.Thread(target=self._await_end, daemon=True).start()

    def _pass_on(self) -> None:
        """Reports each line of the program's output until the output ends. Processes that the
        program has started may keep the output open for longer than the program runs."""
        assert self._process.stdout is not None
        if self._is_ready:
            self._tell_ready()
        with self._process.stdout as output:
            while line := output.readline(_LONGEST_LINE):
                self._report(Event(What.OUTPUT, line.rstrip(), self.program.name))
                if not self._is_ready and _is_ready(line, self.program):
                    self._is_ready = True
                    self._tell_ready()

    def _tell_ready(self) -> None:
        self._report(Event(What.READY, f"{self.program.name} is ready", self.program.name))
        self._ready_or_ended.set()

    def _await_end(self) -> None:
        # The process is not reaped before kill(), so that its process group keeps its number.
        ended = os.waitid(os.P_PID, self._process.pid, os.WEXITED | os.WNOWAIT)
        assert ended is not None
        self._status = ended.si_status if ended.si_code == os.CLD_EXITED else -ended.si_status
        self._over.set()
        self._reader.join(_LAST_LINES_WITHIN)
        self._ready_or_ended.set()
        self._ended(self)

    def await_ready(self) -> None:
        """Raises LaboratoryError if the program ends before it is ready, or is not ready in
        time."""
        end = time.monotonic() + READY_WITHIN
        while not self._ready_or_ended.wait(_LOOK_ANYWAY):
            if time.monotonic() >= end:
                raise LaboratoryError(self._not_ready())
        if not self._is_ready:
            raise LaboratoryError(f"{self.program.name} {self.how_ended()} before it was ready")

    def complain_if_not_ready(self) -> None:
        """Reports the program if it is neither ready nor ended. Is called READY_WITHIN s after the
        program was started again."""
        if not self._ready_or_ended.is_set():
            self._report(Event(What.NOT_READY, self._not_ready(), self.program.name))

    def _not_ready(self) -> str:
        ready = self.program.ready
        default = "that begins with 'serving ' or ends with 'is ready'"
        text = default if ready is None else f"with {ready!r}"
        return (
            f"{self.program.name} is not ready: within {READY_WITHIN:g} s it has printed no "
            f"line {text}; if it prints another one, name a part of that line as `ready` "
            "in lab.toml"
        )

    def status(self) -> int:
        """Waits for the end of the program. Returns its exit status, or the negative number of the
        signal that ended it."""
        self._over.wait()
        return self._status

    def how_ended(self) -> str:
        status = self.status()
        return f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"

    def end(self) -> None:
        """Asks the program, and all processes that it has started, to end, and waits for the end.
        Kills the processes that do not end in time."""
        self._signal(signal.SIGTERM)
        if self._over.wait(END_WITHIN):
            # A process that the program has started may still print its last lines.
            self._reader.join(END_WITHIN)
        else:
            text = f"{self.program.name} did not end after SIGTERM and was killed"
            self._report(Event(What.KILLED, text, self.program.name))
        self.kill()
        self._reader.join(END_WITHIN)

    def kill(self) -> None:
        """Kills the program, and those processes started by it that still run."""
        if self._reaped:
            return
        self._signal(signal.SIGKILL)
        self._over.wait()  # the thread of `_await_end` must see the end before it is reaped
        self._process.wait()
        self._reaped = True

    def _signal(self, number: signal.Signals) -> None:
        if not self._reaped:
            with suppress(ProcessLookupError, PermissionError):
                os.killpg(self._process.pid, number)


class RunningLaboratory:
    """The processes of a laboratory. They run in the working directory `folder`."""

    def __init__(self, environment: Mapping[str, str], folder: Path, report: Report) -> None:
        self._report = report
        self._environment = dict(environment)
        self._folder = folder
        self._processes: dict[str, _Process] = {}
        self._commands: dict[str, tuple[str, ...]] = {}
        self._events: SimpleQueue[_Process] = SimpleQueue()
        self._pauses: dict[str, float] = {}
        self._later = sched.scheduler(time.monotonic)

    def start(self, program: Program, command: Sequence[str]) -> None:
        """Starts a program, and returns when the program is ready."""
        self._commands[program.name] = tuple(command)
        self._launch(program).await_ready()

    def _launch(self, program: Program) -> _Process:
        command = self._commands[program.name]
        with _signals_held_back():  # a process that is not listed yet would not be ended
            process = _Process(
                program, command, self._environment, self._folder, self._events.put, self._report
            )
            self._processes[program.name] = process
        return process

    def watch(self, timeout: float | None = None) -> None:
        """Watches the programs. When a program ends, reports it, and starts it again if it is to be
        restarted. Returns after `timeout` s. Without `timeout`, ends only by an exception such as
        KeyboardInterrupt."""
        end = None if timeout is None else time.monotonic() + timeout
        while end is None or time.monotonic() < end:
            waits = (self._later.run(blocking=False), end and end - time.monotonic(), _LOOK_ANYWAY)
            wait = min(max(0.0, each) for each in waits if each is not None)
            try:
                ended = self._events.get(timeout=wait)
            except Empty:
                continue
            if self._processes.get(ended.program.name) is ended:
                self._after(ended)

    def _after(self, ended: _Process) -> None:
        program = ended.program
        told = Event(
            What.ENDED, f"{program.name} {ended.how_ended()}", program.name, ended.status()
        )
        if not program.restart:
            self._report(replace(told, text=f"{told.text}; the other programs continue"))
            return
        if time.monotonic() - ended.since >= _LONG_RUN:
            self._pauses.pop(program.name, None)
        self._start_later(program, told)

    def _start_later(self, program: Program, why: Event) -> None:
        pause = min(max(_FIRST_PAUSE, 2 * self._pauses.get(program.name, 0.0)), _LONGEST_PAUSE)
        self._pauses[program.name] = pause
        text = f"{why.text}; it is started again in {pause:g} s"
        self._report(replace(why, text=text, restarts_in=pause))
        self._later.enter(pause, 0, self._start_again, (program,))

    def _start_again(self, program: Program) -> None:
        self._processes[program.name].kill()  # processes that the program has left behind
        try:
            process = self._launch(program)
        except OSError as error:  # for example while the program's file is being replaced
            text = f"{program.name} cannot be started: {error}"
            self._start_later(program, Event(What.NOT_STARTED, text, program.name))
            return
        self._report(Event(What.RESTARTED, f"{program.name} is started again", program.name))
        self._later.enter(READY_WITHIN, 0, process.complain_if_not_ready)

    def end(self) -> None:
        """Ends all programs, the last one first. If an exception interrupts this method, kills all
        programs."""
        processes = [*reversed(self._processes.values())]
        try:
            self._report(Event(What.CLOSING, "ending"))
            for process in processes:
                process.end()
        except BaseException:
            for process in processes:
                process.kill()
            raise


@contextmanager
def running(
    laboratory: LaboratoryDescription,
    environment: Mapping[str, str] | None = None,
    folders: Sequence[Path] = (),
    restart: bool = False,
    report: Report = show,
) -> Iterator[RunningLaboratory]:
    """Starts a laboratory, and ends all its programs when the block ends. Programs are searched in
    `folders`, in the folder of this command, and in PATH. With `restart`, each program is started
    again when it ends by itself. `report` is called with each event, from several threads. Raises
    LaboratoryError if a program is missing or does not become ready, and if the programs would not
    use the broker that the laboratory starts. Before that, ends the programs that already run."""
    commands = [(p, _command(laboratory, p, folders)) for p in laboratory.programs]
    variables = dict(os.environ if environment is None else environment)
    variables["GECOS_BROKER"] = _broker_of(laboratory, variables.get("GECOS_BROKER", ""))
    if laboratory.tables_for_programs:
        variables["GECOS_LAB_FILE"] = str(Path(laboratory.file).resolve())
    if laboratory.clock_speed is not None:
        variables[CLOCK_VARIABLE] = f"{laboratory.clock_speed:.10g}"
    started = RunningLaboratory(variables, laboratory.folder, report)
    try:
        if laboratory.starts_broker:
            started.start(*_broker(variables, restart))
        for program, command in commands:
            started.start(replace(program, restart=program.restart or restart), command)
        yield started
    finally:
        started.end()


def _broker_of(laboratory: LaboratoryDescription, named: str) -> str:
    """Returns the address of the broker that the programs of `laboratory` must use. They are told
    this address, so that they do not use the broker that the lab file of the host names. `named` is
    the value of GECOS_BROKER. Raises LaboratoryError if this laboratory starts a broker, which is
    at the address `shm`, and `named` is another address."""
    if laboratory.broker_address:
        return laboratory.broker_address
    if laboratory.starts_broker and named not in ("", "shm"):
        raise LaboratoryError(
            f"GECOS_BROKER is {named!r}, so the programs would not use the broker that this "
            "laboratory starts; unset GECOS_BROKER, or write `start = false` below [broker] in "
            f"{laboratory.file or 'a lab.toml'} if the programs are to use the broker at {named!r}"
        )
    return named or "shm"


def _broker(environment: Mapping[str, str], restart: bool) -> tuple[Program, Sequence[str]]:
    """Returns the broker of this package as a Program, with the command that starts it. PYTHONPATH
    is set, because the package of an installed SDK is not in the interpreter's own path."""
    # The option -P prevents a module in the folder of the laboratory from hiding a module of the
    # interpreter.
    command = (sys.executable, "-P", "-m", "gecos.cli", "broker")
    packages = [str(Path(__file__).resolve().parents[2]), environment.get("PYTHONPATH", "")]
    path = os.pathsep.join(filter(None, packages))
    return Program("BROKER", command, restart, environment={"PYTHONPATH": path}), command


def _command(
    laboratory: LaboratoryDescription, program: Program, folders: Sequence[Path]
) -> tuple[str, ...]:
    """Returns the program with its full path, and its arguments."""
    name, *arguments = program.run
    if os.sep in name:
        found = [laboratory.folder / name]
    else:
        beside = Path(sys.argv[0]).resolve().parent
        below = [each for folder in folders for each in _below(folder, name)]
        in_path = shutil.which(name)
        found = [*below, beside / name, *([Path(in_path)] if in_path else [])]
    for path in found:
        if path.is_file() and os.access(path, os.X_OK):
            return (str(path.absolute()), *arguments)
    where = f"{laboratory.file}:{program.line}: " if laboratory.file else ""
    for path in found:
        if path.is_file():
            raise LaboratoryError(
                f"{where}{program.name}: {name} is no executable file; run `chmod +x {path}`, or "
                f'name its interpreter, for example run = ["python", "{name}"]'
            )
    raise LaboratoryError(
        f"{where}{program.name}: there is no program {name}; name the folder that has it by "
        "--programs, for example --programs <robcl>/build"
    )


def _is_ready(line: str, program: Program) -> bool:
    """Returns whether a program reports by this line that it is ready. Without `ready`, the usual
    lines of servers count: "serving RX90" and "robcl-rx90: RX90 is ready"."""
    if program.ready is None:
        return re.search(r"^serving |(^|: | is )ready$", line.rstrip()) is not None
    return _says(line, program.ready)


def _says(line: str, words: str) -> bool:
    """Returns whether `line` contains `words` as whole words. For example, "already" does not
    contain the word "ready"."""
    return re.search(rf"(?<!\w){re.escape(words)}(?!\w)", line) is not None


def _below(folder: Path, name: str) -> Iterator[Path]:
    for depth in ("", "*/", "*/*/"):
        yield from sorted(folder.glob(depth + name))


@contextmanager
def _signals_held_back() -> Iterator[None]:
    """Calls the handlers of signals that arrive in the block when the block ends. Such a handler
    may raise an exception, for example KeyboardInterrupt."""
    if threading.current_thread() is not threading.main_thread():
        yield  # Python calls handlers in the main thread only
        return
    came: list[tuple[int, FrameType | None]] = []
    with ExitStack() as restored:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            handler = signal.getsignal(number)
            if callable(handler):
                signal.signal(number, lambda number, frame: came.append((number, frame)))
                restored.callback(signal.signal, number, handler)
        yield
    for arrived, frame in came:
        handler = signal.getsignal(arrived)
        assert callable(handler)
        handler(arrived, frame)


def _ends_with_us() -> list[str]:
    """Returns words to put before a command, so that the kernel ends the command when this process
    is killed."""
    setpriv = shutil.which("setpriv")
    return [setpriv, "--pdeathsig", "TERM", "--"] if setpriv else []
