"""A violation of a layer rule, and its text."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, order=True)
class Violation:
    path: str
    line: int
    what: str
    rule: str
    do: str

    def __str__(self) -> str:
        return (
            f"{self.path}:{self.line}: error: {self.what}\n"
            f"    = rule: {self.rule}\n"
            f"    = help: {self.do}"
        )
