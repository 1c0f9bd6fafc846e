"""The C++ runtime, which takes and returns values as encoded bytes. The modules of `gecos` add the
types."""

from collections.abc import Sequence
from typing import Literal

from gecos.interface import Interface

_Violations = list[tuple[str, str]]

class Lab:
    def __init__(self, broker: str, program: str) -> None: ...
    def create(
        self,
        interface: Interface,
        names: Sequence[str],
        channels: tuple[str | None, str | None, str | None],
        latency: float,
        quality: tuple[int, int, float, float, bool],
        patience: float,
        incarnation: int,
        wait: float,
    ) -> Session | list[tuple[str, int, str]]:
        """Returns a session, or the name, detail and reason of each failed attempt. `channels` are
        the arguments `medium`, `in_` and `out` of `Lab.create`. `quality` has the numbers of the
        QualityClass and the Reliability, the deadline and the lifespan in s (0: none), and whether
        the liveliness is MANUAL."""
    def explain(
        self, interface: Interface, name: str, patience: float
    ) -> (
        tuple[
            str,
            str,
            bool,
            list[tuple[str, str, str, _Violations, list[tuple[str, _Violations, bool]], str]],
        ]
        | list[tuple[str, int, str]]
    ):
        """Returns the members of an Explanation without its name. Each MediumVerdict is a tuple of
        its members. On failure, returns the failed attempts as `create` does."""
    def broker(self, interface: Interface, patience: float) -> Session | str:
        """Returns the session of this Lab with its broker, or the reason why there is none."""
    def session_at(self, interface: Interface, address: str, patience: float) -> Session | str:
        """Returns a session with the object at an address, or the reason why there is none."""
    def objects(self, interface_name: str, patience: float) -> list[bytes] | str:
        """Returns the encoded entries, or the reason why the broker gave no answer."""
    def watch(self, interface_name: str) -> ObjectWatch: ...
    def close(self) -> None: ...

class ObjectWatch:
    def next(self, timeout: float | None) -> bytes | bool:
        """Returns an encoded Registration; True after the timeout, False after `close`."""
    def skipped(self) -> int: ...
    def close(self) -> None: ...

class Session:
    @property
    def object_name(self) -> str: ...
    @property
    def interface_name(self) -> str: ...
    @property
    def medium(self) -> str: ...
    def reference(self) -> tuple[str, int, int, str]:
        """Returns a reference to the object, as the members of an ObjectRef."""
    def call(self, code: int, arguments: bytes, deadline: float | None) -> Command:
        """Calls an operation of the object's interface or a built-in operation."""
    def line(self) -> tuple[str, float, float | None, bool, int, str, str]:
        """Returns the members of LineState, in order."""
    def next_line_change(
        self, changes: int, timeout: float | None
    ) -> tuple[str, float, float | None, bool, int, str, str] | bool:
        """Waits until the state of the connection changes. Returns the members of
        LineState, True if there was no change within `timeout`, or False if the session is lost or
        closed. `changes` is the number of changes that the caller knows."""
    def subscribe(self, code: int) -> Stream | tuple[int, str]: ...
    def open_writer(self, code: int) -> Writer | tuple[int, str]: ...
    def outcome(self, command: str) -> Command: ...
    def ask_for_status(self, status: int, password: str, timeout: float) -> Command:
        """Requests a status. While the request waits for other clients, the command is QUEUED."""
    def lease(self, asked: Command) -> Lease | tuple[int, str, str, bytes]:
        """Waits until the request `asked` for a status has ended. Returns the lease that the server
        has granted, or the reason why the request failed."""
    def decline_status(self, asked: Command) -> None:
        """Withdraws a request for a status. Releases the status if it is granted nevertheless."""
    def close(self) -> None: ...

class Command:
    def id(self) -> str: ...
    def about(self) -> str:
        """Returns the name of the called operation, for example "RX90.move", while the command
        runs, and after a failure that the program had not observed; else an empty text."""
    def ignore_outcome(self) -> None:
        """Declares that the program does not need the outcome. A failure is then not logged, and
        does not prevent commands that are issued later."""
    def peek(self) -> tuple[int, int, float]:
        """Does the same as progress(), but does not mark the command as observed."""
    def progress(self) -> tuple[int, int, float]: ...
    def feedback(self) -> bytes: ...
    def wait(self, timeout: float | None) -> bool: ...
    def cancel(self) -> None: ...
    def answer(self, timeout: float | None) -> bytes | int:
        """Waits for the end of the command. Returns the encoded result, or the detail if there is
        no result."""
    def failure(self) -> tuple[int, str, str, bytes]: ...
    def observe(self) -> None:
        """Marks the command as observed, so that its failure is not logged. The server is not told
        that the program has seen a failure, as it is after `progress` or `failure`."""
    def observed(self) -> bool: ...
    def inherited(self) -> bool:
        """Returns True in a forked child, if the parent has issued the command. `peek`, `progress`,
        `feedback`, `wait`, `cancel`, `answer` and `descriptor` then raise RuntimeError."""
    def peek_failure(self) -> tuple[int, str, str, bytes]:
        """Does the same as failure(), but does not mark the command as observed."""
    def descriptor(self) -> int: ...

class Stream:
    @property
    def after(self) -> int | None:
        """For an event, the sequence number of the last sample before the subscription. None for a
        stream, because its reader begins with the newest sample."""
    # Both methods return the encoded sample, its sequence number, its time stamp (Unix time in ns),
    # and its time of measurement (ns of this host's CLOCK_BOOTTIME).
    def latest(self) -> tuple[bytes, int, int, int] | str | None: ...
    def next(self, timeout: float | None) -> tuple[bytes, int, int, int] | str: ...
    def latest_in_place(self) -> tuple[LentSample, int, int, int] | str | None: ...
    def next_in_place(self, timeout: float | None) -> tuple[LentSample, int, int, int] | str: ...
    def history(self) -> list[tuple[bytes, int, int, int]]: ...
    def counts(self) -> tuple[int, int, int, int, int]:
        """Returns the members of StreamCounts, in order; after close(), the counts at that time."""
    def alive(self) -> bool: ...
    def loss_text(self) -> str:
        """Returns why the stream is lost; an empty text if its Lab was closed."""
    def close(self) -> None: ...

class LentSample:
    """An encoded sample in the memory of its medium; a read-only buffer."""

    def __buffer__(self, flags: int, /) -> memoryview: ...
    def intact(self) -> bool: ...

class Loan:
    """The octets of a sample that is not yet published; a writable buffer."""

    def __buffer__(self, flags: int, /) -> memoryview: ...
    def publish(self, stamp_ns: int | None) -> bool: ...
    def give_back(self) -> None: ...

class Lease:
    @property
    def status(self) -> int: ...
    @property
    def epoch(self) -> int: ...
    def fresh(self) -> bool:
        """Whether the lease was acquired less than 100 ms ago and no call was issued under it."""
    def lost(self) -> bool:
        """Whether the session has ended, or has acquired another status since."""
    def release(self) -> None: ...
    def release_now(self) -> None: ...

class Writer:
    def send(self, sample: bytes, stamp_ns: int | None) -> tuple[int, str] | None: ...
    def feeds(self, command: str | None) -> None: ...
    def lost(self) -> bool: ...
    def close(self) -> None: ...

class PulledServant:
    def next(self, lane: int) -> IncomingCall | Literal["stopped"] | None:
        """Waits without limit for the next task of a lane (0 safety, 1 sensor, 2 FIFO). Returns a
        call, "stopped" (lane 0 only) if a client stopped the object, or None if the lane is
        closed."""
    def publish(self, code: int, sample: bytes, stamp_ns: int | None) -> None: ...
    def lend(self, code: int, head: bytes, octets: int, tail: bytes) -> Loan | None:
        """Lends the memory of the next sample: `head`, `octets` octets, `tail`. Returns None if the
        servant is no longer served. Raises ValueError with the reason if the sample is refused."""
    def next_inward(
        self, code: int, only_commands: bool
    ) -> tuple[bytes, int, int, int, int, int] | None:
        """Returns the oldest unread sample of an inward stream: value, sequence, stamp_ns, age_ns,
        session, command."""
    def unreadable(self, code: int, session: int, why: str) -> None:
        """Counts the sample that next_inward() returned last as refused."""
    def inward_expired(self, code: int) -> bool: ...
    def inward_report(self, code: int) -> bytes: ...
    def begin_feeding(self, code: int, call: IncomingCall) -> int: ...
    def end_feeding(self, code: int, feeding: int) -> None: ...

class IncomingCall:
    @property
    def code(self) -> int: ...
    @property
    def arguments(self) -> bytes: ...
    def caller(self) -> tuple[str, str, str, int, int]: ...
    @property
    def marked_ns(self) -> int: ...
    def interrupted(self) -> bool: ...
    def wait_interrupted(self, seconds: float) -> bool: ...
    def progress(self, fraction: float, feedback: bytes) -> None: ...
    def finish(self, result: bytes) -> None: ...
    def fail(self, detail: int, text: str, exception: str, evidence: bytes) -> None: ...

class Server:
    def __init__(self, lab: Lab, insecure: bool) -> None: ...
    def allow(self, users: Sequence[str], hosts: Sequence[str]) -> None:
        """Names the users and hosts that may connect, in addition to the user of this process."""
    def await_broker(self, patience: float) -> str | None:
        """Waits for a broker. Returns None when a broker answers, or after `patience` seconds the
        reason and the address."""
    def prepare(self, interface: Interface) -> PulledServant:
        """Makes a servant to pass to `add`. Threads of Python fetch the calls of the servant."""
    def add(
        self, prepared: PulledServant, name: str, simulated: bool, media: Sequence[str]
    ) -> str | None:
        """Serves a prepared servant. Returns None, or the reason why it is not served."""
    def forget(self, prepared: PulledServant) -> None:
        """Ends the lanes of a prepared servant that will not be served."""
    def close(self) -> None: ...

def warn_of_other_brokers() -> None:
    """Warns about brokers in other processes that programs on this host may reach."""

class Broker:
    """A broker in this process, at this host's well-known address."""

    def __init__(self, lab: Lab, name_hold: float) -> None: ...
    def close(self) -> None: ...

def audit_directory() -> str:
    """Returns the folder of the audit of this user's servers."""

def runtime_directory() -> str:
    """Returns the folder through which the programs of this user find each other over shm."""

def runtime_directory_problem() -> str | None:
    """Makes the runtime directory if it is missing. If the directory cannot be used, returns the
    reason and what to do."""

def lab_file_problem(text: str, file: str) -> str | None:
    """Returns what is wrong with the text of a lab file; None if nothing is wrong. `file` is the
    path of the file. The returned message begins with this path and the line."""

def broker_in_lab_file(patience: float) -> tuple[str, str]:
    """Returns the address of the broker that the lab file of this program names, and the place in
    the file, as "[broker] in lab.toml:4". Both are empty if the file names no broker, or if there
    is no lab file. Raises RuntimeError, which says what to do, if the file cannot be used, or if
    GECOS_LAB_FILE names a file that does not exist."""

def may_connect(
    text: str, file: str, server: tuple[str, str], who: tuple[str, str], object: str
) -> tuple[bool, str]:
    """Returns whether the server of the user and host `server` admits the user and host `who` to
    the object `object`, if `text` is the text of the server's lab file. Also returns the rule that
    decides this, as a sentence. Raises ValueError for a text in which lab_file_problem finds a
    mistake."""

def may_register(text: str, file: str, who: tuple[str, str], name: str) -> tuple[bool, str]:
    """Returns whether a server of the user and host `who` may register an object under `name`, if
    `text` is the text of the broker's lab file. Also returns the rule that decides this, as a
    sentence. Raises ValueError as may_connect does."""

def forbids_open_streams(text: str, file: str) -> str:
    """Returns the place at which the text of a lab file forbids sending the samples of open streams
    in clear, as "[streams] in lab.toml:3"; "" if the text does not forbid this. Raises ValueError
    as may_connect does."""

def key_directory() -> str:
    """Returns the folder of this user's keys."""

def own_key() -> str:
    """Returns this user's public key as 64 hexadecimal digits, and makes the key at first use.
    Raises RuntimeError, which says what is wrong with the folder or the file."""

def key_problem(key: str) -> str | None:
    """Returns the reason why the key folder does not admit `key`, or None if it does. Raises
    RuntimeError like own_key."""

def key_owner(key: str) -> str | None:
    """Returns the owner of the key `key`, such as "anna@desk", or None if the key folder names no
    owner. Raises RuntimeError like own_key, and if the file of the owner cannot be read or is
    damaged."""

def is_key_owner(text: str) -> bool:
    """Returns whether `text` has the form of an owner of a key, such as "anna@desk"."""

def public_key_in(text: bytes) -> str:
    """Returns the key in the text of a .public file. Raises ValueError, for example with the text
    "is cut short"."""

def log_error(component: str, text: str) -> None: ...
def detail_name(number: int) -> str: ...
