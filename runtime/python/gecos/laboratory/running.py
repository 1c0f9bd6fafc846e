"""Starts the programs of a laboratory one after the other, and ends them together."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from queue import Empty, SimpleQueue

from gecos.laboratory.description import LaboratoryDescription, Program

READY_WITHIN = 60.0  # s
END_WITHIN = 5.0  # s after SIGTERM, before SIGKILL
_FIRST_PAUSE = 0.5  # s before a program is started again; doubles each time
_LONGEST_PAUSE = 30.0  # s
_LONG_RUN = 60.0  # s after which a program that ends is started again after the first pause


class LaboratoryError(RuntimeError):
    """A program of the laboratory is missing, or did not get ready."""


class _Process:
    """One run of a program. Its lines are passed on, after the name of the program."""

    def __init__(
        self,
        program: Program,
        command: Sequence[str],
        environment: Mapping[str, str],
        folder: Path,
        ended: Callable[[_Process], None],
    ) -> None:
        self.program = program
        self.since = time.monotonic()
        self._ready = threading.Event()
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
            start_new_session=True,  # Ctrl-C is for this process, which ends the others in order
        )
        self._reader = threading.Thread(target=self._pass_on, daemon=True)
        self._reader.start()

    def _pass_on(self) -> None:
        assert self._process.stdout is not None
        if not self.program.ready:
            self._ready.set()
        for line in self._process.stdout:
            print(f"  [{self.program.name}] {line}", end="", flush=True)
            if _says(line, self.program.ready):
                self._ready.set()
        self._process.wait()
        self._ready.set()
        self._ended(self)

    def await_ready(self) -> None:
        """Raises LaboratoryError if the program ends, or is not ready in time."""
        in_time = self._ready.wait(READY_WITHIN)
        if not in_time:
            raise LaboratoryError(f"{self.program.name} is not ready after {READY_WITHIN:g} s")
        if self.program.ready and self.status is not None:
            raise LaboratoryError(f"{self.program.name} {self.how_ended()} before it was ready")

    @property
    def status(self) -> int | None:
        return self._process.poll()

    def how_ended(self) -> str:
        status = self._process.wait()
        return f"was ended by signal {-status}" if status < 0 else f"ended with status {status}"

    def ask_to_end(self) -> None:
        if self.status is None:
            self._process.terminate()

    def end(self) -> None:
        """Waits for the end, and insists on it."""
        self.ask_to_end()
        try:
            self._process.wait(END_WITHIN)
        except subprocess.TimeoutExpired:
            print(f"{self.program.name} does not end: killed", file=sys.stderr)
            self._process.kill()
        self._process.wait()
        self._reader.join(END_WITHIN)


class RunningLaboratory:
    """The processes of a laboratory, which run in `folder`."""

    def __init__(self, environment: Mapping[str, str], folder: Path) -> None:
        self._environment = dict(environment)
        self._folder = folder
        self._processes: dict[str, _Process] = {}
        self._commands: dict[str, tuple[str, ...]] = {}
        self._events: SimpleQueue[_Process] = SimpleQueue()
        self._pauses: dict[str, float] = {}

    def start(self, program: Program, command: Sequence[str]) -> None:
        """Starts a program and returns when it is ready."""
        self._commands[program.name] = tuple(command)
        process = _Process(program, command, self._environment, self._folder, self._events.put)
        self._processes[program.name] = process
        process.await_ready()

    def watch(self, timeout: float | None = None) -> None:
        """Starts programs again that end and are to be restarted; says so of the others. Returns
        after `timeout` s, otherwise only by an exception such as KeyboardInterrupt."""
        end = None if timeout is None else time.monotonic() + timeout
        while end is None or time.monotonic() < end:
            try:
                ended = self._events.get(timeout=None if end is None else end - time.monotonic())
            except (Empty, ValueError):
                return
            if self._processes.get(ended.program.name) is ended:
                self._after(ended)

    def _after(self, ended: _Process) -> None:
        program = ended.program
        if not program.restart:
            print(f"{program.name} {ended.how_ended()}; the others go on", flush=True)
            return
        ran = time.monotonic() - ended.since
        before = self._pauses.get(program.name, 0.0) if ran < _LONG_RUN else 0.0
        pause = min(max(_FIRST_PAUSE, 2 * before), _LONGEST_PAUSE)
        self._pauses[program.name] = pause
        print(f"{program.name} {ended.how_ended()}; starts again in {pause:g} s", flush=True)
        time.sleep(pause)
        try:
            self.start(program, self._commands[program.name])
        except LaboratoryError as error:
            print(error, flush=True)

    def end(self) -> None:
        """Ends all programs, the last one first."""
        for process in reversed(self._processes.values()):
            process.end()


@contextmanager
def running(
    laboratory: LaboratoryDescription,
    environment: Mapping[str, str] | None = None,
    folders: Sequence[Path] = (),
    restart: bool = False,
) -> Iterator[RunningLaboratory]:
    """Starts a laboratory, and ends all its programs when the block ends. Programs are looked up in
    `folders`, beside this command and in PATH. With `restart`, each program is started again when
    it ends by itself. If a program is missing or does not get ready, all programs that run are
    ended, and LaboratoryError is raised."""
    commands = [(p, _command(laboratory, p, folders)) for p in laboratory.programs]
    variables = dict(os.environ if environment is None else environment)
    if laboratory.broker_address:
        variables["GECOS_BROKER"] = laboratory.broker_address
    started = RunningLaboratory(variables, laboratory.folder)
    try:
        if laboratory.starts_broker:
            started.start(*_broker(variables, restart))
        for program, command in commands:
            started.start(replace(program, restart=program.restart or restart), command)
        yield started
    finally:
        started.end()


def _broker(environment: Mapping[str, str], restart: bool) -> tuple[Program, Sequence[str]]:
    """The broker of this package, which an installed SDK has outside of the interpreter's path."""
    command = (sys.executable, "-m", "gecos.cli", "broker")
    packages = [str(Path(__file__).resolve().parents[2]), environment.get("PYTHONPATH", "")]
    path = os.pathsep.join(filter(None, packages))
    return Program("BROKER", command, restart, environment={"PYTHONPATH": path}), command


def _command(
    laboratory: LaboratoryDescription, program: Program, folders: Sequence[Path]
) -> tuple[str, ...]:
    """The program with its full path, and its arguments."""
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


def _says(line: str, words: str) -> bool:
    """Whether the line has the words as whole words: "already" does not say "ready"."""
    return re.search(rf"(?<!\w){re.escape(words)}(?!\w)", line) is not None


def _below(folder: Path, name: str) -> Iterator[Path]:
    for depth in ("", "*/", "*/*/"):
        yield from sorted(folder.glob(depth + name))


def _ends_with_us() -> list[str]:
    """Words before a command by which the kernel ends it when this process is killed."""
    setpriv = shutil.which("setpriv")
    return [setpriv, "--pdeathsig", "TERM", "--"] if setpriv else []
