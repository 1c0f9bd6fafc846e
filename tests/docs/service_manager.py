"""Runs the units of /etc/systemd/system as systemd would, as far as docs/deploying.md needs it.

Takes the words of `systemctl` at a socket, and answers with what is wrong with them. Ends with its
input, and all units with it.
"""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import socket
import subprocess
import sys
import threading
from dataclasses import dataclass, field
from pathlib import Path

UNITS = Path("/etc/systemd/system")
JOURNAL = Path("/run/journal")
PLACE = Path("/run/service-manager.sock")


@dataclass(slots=True)
class Service:
    """A unit with its values, and its process, which is started again when it fails."""

    name: str  # "robcl@lds.service"
    values: dict[str, list[str]] = field(default_factory=dict)
    lock: threading.Lock = field(default_factory=threading.Lock)
    process: subprocess.Popen[bytes] | None = None  # None when the unit is stopped
    keeper: threading.Thread | None = None

    def read(self) -> None:
        prefix, _, rest = self.name.removesuffix(".service").partition("@")
        file = UNITS / (f"{prefix}@.service" if rest else self.name)
        text = file.read_text(encoding="utf-8").replace("%i", rest)
        self.values = {}
        for line in text.splitlines():
            key, equals, value = line.partition("=")
            if equals and not line.startswith(("#", ";")):
                self.values.setdefault(key, []).append(value)

    def environment(self) -> dict[str, str]:
        words = [word for line in self.values.get("Environment", []) for word in shlex.split(line)]
        for file in self.values.get("EnvironmentFile", []):
            path = Path(file.removeprefix("-"))
            if path.exists() or not file.startswith("-"):
                words += path.read_text(encoding="utf-8").splitlines()
        given = dict(word.split("=", 1) for word in words if "=" in word)
        ours = {name: os.environ[name] for name in ("PATH", "PYTHONUSERBASE")}
        return ours | given

    def command(self, environment: dict[str, str]) -> list[str]:
        words = []
        for word in shlex.split(self.values["ExecStart"][0]):
            several = word.startswith("$")
            words += environment.get(word[1:], "").split() if several else [word]
        return words

    def start(self) -> None:
        self.stop()
        self.read()
        for name in self.values.get("StateDirectory", []):
            (Path("/var/lib") / name).mkdir(mode=0o700, exist_ok=True)
        self.process = self._launched()
        self.keeper = threading.Thread(target=self._keep)
        self.keeper.start()

    def _launched(self) -> subprocess.Popen[bytes]:
        environment = self.environment()
        with (JOURNAL / self.name).open("ab") as journal:
            return subprocess.Popen(
                self.command(environment),
                env=environment,
                stdin=subprocess.DEVNULL,
                stdout=journal,
                stderr=subprocess.STDOUT,
                cwd="/",
            )

    def _keep(self) -> None:
        """Starts the process again whenever it fails, until the unit is stopped."""
        while (process := self.process) is not None:
            failed = process.wait() != 0
            with self.lock:
                if self.process is None or not failed or "on-failure" not in self.values["Restart"]:
                    return
                self.process = self._launched()

    def stop(self) -> None:
        with self.lock:
            process, self.process = self.process, None
            if process is not None:
                process.terminate()
        if self.keeper is not None:
            self.keeper.join()


SERVICES: dict[str, Service] = {}


def mistakes_in(names: list[str]) -> str:
    """What systemd itself says of units, where it is installed."""
    if shutil.which("systemd-analyze") is None:
        return ""
    checked = ["systemd-analyze", "verify", *(str(UNITS / name) for name in names)]
    done = subprocess.run(checked, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
    return done.stdout or ("" if done.returncode == 0 else f"{checked} ended with {done}")


def obey(words: list[str]) -> str:
    """What is wrong; empty when it is done."""
    verb, *rest = words
    if verb == "daemon-reload":
        return ""
    names = [f"{name.removesuffix('.service')}.service" for name in rest if name[0] != "-"]
    if verb == "enable" and (wrong := mistakes_in(names)):
        return wrong
    services = [SERVICES.setdefault(name, Service(name)) for name in names]
    for service in services:
        if verb in ("start", "restart") or (verb == "enable" and "--now" in rest):
            service.start()
        elif verb == "stop" or (verb == "disable" and "--now" in rest):
            service.stop()
        elif verb == "kill" and service.process is not None:
            service.process.kill()
        else:
            return f"systemctl: the test knows no {' '.join(words)}"
    return "" if services else f"systemctl: {' '.join(words)}: which?"


def end_with_input() -> None:
    sys.stdin.read()
    os.kill(os.getpid(), signal.SIGTERM)


def main() -> None:
    signal.signal(signal.SIGTERM, lambda number, frame: sys.exit())
    threading.Thread(target=end_with_input, daemon=True).start()
    JOURNAL.mkdir()
    with socket.socket(socket.AF_UNIX) as acceptor:
        acceptor.bind(str(PLACE))
        acceptor.listen()
        print("ready", flush=True)
        try:
            while True:
                with acceptor.accept()[0] as line:
                    words = json.loads(b"".join(iter(lambda: line.recv(4096), b"")))
                    try:
                        line.sendall(obey(words).encode())
                    except (OSError, KeyError, ValueError) as error:
                        line.sendall(f"systemctl: {error}".encode())
        finally:
            for service in SERVICES.values():
                service.stop()


if __name__ == "__main__":
    main()
