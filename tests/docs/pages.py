"""A page that is followed to the letter: commands are typed, files written, output seen.

A block ```sh is typed at a terminal and has to succeed. Words after `sh` are for this reader:
`terminal=2` for another terminal than the one before (each is a shell of its own), `host=desk` for
the terminals of another machine, `stays` when the last command goes on, `status=3` when one command
ends with that status, `repeat` when a person would type it again until it prints what is expected,
`answer=y` when a person answers a question so. A link to join, which is another one in each run, is
typed as a terminal has printed it.
A block ```text after it has lines that are printed, in this order; … stands for anything. A block
`text terminal=2` is printed there, by the command that stayed, which ends if `status=` is given
too; at a line ^C, Ctrl-C is pressed there, and the command ends after the lines behind it. A block
of another language is written to the file that the line before it names, in backticks and with a
colon at its end; without such a name it is not followed. Commands that stay are ended by Ctrl-C
before the next one in their terminal, unless that is the same.
"""

from __future__ import annotations

import os
import re
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from types import TracebackType

from terminals import PATIENCE_S, Terminal, pattern_of

TREE = Path(__file__).resolve().parents[2]
FENCED = re.compile(r"([^\n]*)\n*```(\w+)([^\n]*)\n(.*?)^```$", re.MULTILINE | re.DOTALL)
LINK = re.compile(r"gecos-join:\S+")
FILE = re.compile(r"`([\w./@-]+)`[^`]*:$")


@dataclass(frozen=True, slots=True)
class Block:
    before: str  # the line before it
    language: str
    words: dict[str, str]  # "stays" → "", "terminal" → "2"
    text: str

    @property
    def file(self) -> str | None:
        """The file that it is, or None."""
        found = FILE.search(self.before)
        return found[1] if found and self.language not in ("sh", "text") else None

    @property
    def lines(self) -> list[str]:
        return [line for line in self.text.splitlines() if line.strip() not in ("", "…")]

    @property
    def around_ctrl_c(self) -> tuple[list[str], bool, list[str]]:
        """Lines before ^C, whether there is one, and lines behind it."""
        lines = self.lines
        at = lines.index("^C") if "^C" in lines else len(lines)
        return lines[:at], at < len(lines), lines[at + 1 :]

    @property
    def status(self) -> int:
        return int(self.words.get("status", "0"))


def blocks_of(page: str) -> list[Block]:
    """All fenced blocks of a page, by its path in the tree, in their order."""
    text = (TREE / page).read_text(encoding="utf-8")
    found = []
    for before, language, words, body in FENCED.findall(text):
        pairs = (word.partition("=") for word in words.split())
        found.append(Block(before, language, {name: value for name, _, value in pairs}, body))
    return found


def variables(home: Path, commands: Path) -> dict[str, str]:
    """The environment of a user who has just logged in for the first time. `commands`: a folder
    with those that need another machine or another user."""
    ours = ("GECOS_", "PYTHONPATH", "VIRTUAL_ENV", "XDG_CONFIG_HOME")
    env = {name: value for name, value in os.environ.items() if not name.startswith(ours)}
    home.mkdir()
    env |= {"HOME": str(home), "GECOS_RUNTIME_DIR": str(home / "r"), "PYTHONUNBUFFERED": "1"}
    env["PATH"] = f"{commands}:{env['PATH']}"
    for role in ("AUTHOR", "COMMITTER"):  # as `git config` would say it
        env |= {f"GIT_{role}_NAME": "Ann", f"GIT_{role}_EMAIL": "ann@desk"}
    if shutil.which("ccache"):
        env["CMAKE_CXX_COMPILER_LAUNCHER"] = "ccache"
    return env


@dataclass(slots=True)
class Reader:
    """A person who follows pages at terminals, which stay open from page to page. All programs
    that the pages start have ended when the block `with` ends."""

    open_terminal: Callable[[str], Terminal]  # at the machine of this name; "": the only one
    build: str = str(TREE / os.environ.get("GECOS_BUILD", "build"))  # of `make build`
    terminals: dict[str, Terminal] = field(default_factory=dict)
    _first_commands: str = ""
    _at: str = "1"
    _host: str = ""

    def follow(self, page: str) -> None:
        """Raises AssertionError with the first block that does not do what the page says."""
        blocks = blocks_of(page)
        if "each terminal" in blocks[0].before:
            self._first_commands = blocks.pop(0).text
        self._at = "1"
        for at, block in enumerate(blocks):
            after = blocks[at + 1] if at + 1 < len(blocks) else None
            if block.language == "sh":
                printed = after is not None and after.language == "text" and not after.words
                self._do(block, after.lines if after and printed else [])
            elif block.language == "text" and block.words:
                terminal = self.terminals[block.words["terminal"]]
                before, ctrl_c, behind = block.around_ctrl_c
                terminal.see(before)
                if ctrl_c:
                    terminal.interrupt(behind)
                if "status" in block.words:
                    terminal.finish(block.status)
            elif block.file is not None:
                self._write(block, block.file)

    def __enter__(self) -> Reader:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Ctrl-C in all terminals, the last one first; then the terminals are closed."""
        try:
            for terminal in reversed(self.terminals.values()):
                if terminal.running is not None and error is None:
                    terminal.interrupt()
        finally:
            for terminal in reversed(self.terminals.values()):
                terminal.close()

    def _do(self, block: Block, expected: list[str]) -> None:
        terminal = self._terminal(block)
        commands = block.text.replace("$ROBCL/build", self.build)
        if LINK.search(commands):
            commands = LINK.sub(self._printed_link(), commands)
        if "answer" in block.words:
            commands = f"{commands.rstrip()} <<< {block.words['answer']}\n"
        if terminal.running is not None:
            if terminal.running == commands:
                return  # it runs already, since the page before
            terminal.interrupt()
        if "repeat" in block.words:
            self._repeat(terminal, commands, expected)
            return
        terminal.type(commands)
        terminal.see(expected)
        if "stays" not in block.words:
            terminal.finish(block.status)

    def _printed_link(self) -> str:
        links = [link for terminal in self.terminals.values() for link in terminal.found(LINK)]
        assert links, "no terminal has printed a link to join"
        return links[-1]

    def _repeat(self, terminal: Terminal, commands: str, expected: list[str]) -> None:
        end = time.monotonic() + PATIENCE_S
        while time.monotonic() < end:
            terminal.type(commands)
            said = "\n".join(terminal.finish())
            if all(pattern_of(line).search(said) for line in expected):
                return
        raise AssertionError(f"{commands}did not print {expected}\n{terminal}")

    def _write(self, block: Block, name: str) -> None:
        terminal = self._terminal(block)
        terminal.type("pwd -P")
        file = Path(terminal.finish()[0]) / name
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(block.text, encoding="utf-8")

    def _terminal(self, block: Block) -> Terminal:
        self._at = block.words.get("terminal", self._at)
        self._host = block.words.get("host", self._host)
        if self._at not in self.terminals:
            self.terminals[self._at] = terminal = self.open_terminal(self._host)
            terminal.type(self._first_commands)
            terminal.finish()
        return self.terminals[self._at]
