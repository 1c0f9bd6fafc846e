"""Counts the methods and members of each C++ class of the runtime and the devices. A class that has
too many must say why in the comment in front of it: "more methods than other classes, …".

The declarations are counted in the text, without a compiler. Each overload counts. Declarations of
nested classes, deleted functions, friends and aliases do not count.
"""

import re
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent
ROOTS = ("runtime", "devices")
MOST_METHODS = 27
MOST_MEMBERS = 16

CLASS = re.compile(
    r"(?P<comment>(?:^///[^\n]*\n)*)^(?:template [^\n]*\n)?(?:class|struct) "
    r"(?:GECOS_\w+(?:\([^)]*\))? )?(?P<name>\w+)(?: final)?(?: :[^{;]*)? \{(?P<body>.*?)^\};",
    re.DOTALL | re.MULTILINE,
)
NOT_COUNTED = re.compile(r"using\b|friend\b|class\b|struct\b|enum\b|static constexpr\b")
REASONS = {
    "methods": re.compile("more methods (and members )?than"),
    "members": re.compile("more (methods and )?members than"),
}


@dataclass(frozen=True, slots=True)
class Size:
    name: str
    comment: str
    methods: int
    members: int

    def unexplained(self) -> list[str]:
        """Returns each count that is too large and not explained, such as "35 methods"."""
        said = " ".join(self.comment.replace("///", "").split()).lower()
        counted = {"methods": (self.methods, MOST_METHODS), "members": (self.members, MOST_MEMBERS)}
        return [
            f"{count} {what}"
            for what, (count, most) in counted.items()
            if count > most and not REASONS[what].search(said)
        ]


def own_declarations(body: str) -> list[str]:
    """Returns the declarations in a class body, without the text inside braces."""
    text = re.sub(r"//[^\n]*", "", body)
    text = re.sub(r"^ *(public|private|protected):", "", text, flags=re.MULTILINE)
    flat, depth = "", 0
    for letter in text:
        depth += letter == "{"
        if depth == 0:
            flat += letter
        if letter == "}":
            depth -= 1
            flat += ";" if depth == 0 else ""
    stripped = (re.sub(r"GECOS_\w+\([^)]*\)", "", part).strip() for part in flat.split(";"))
    return [
        part for part in stripped if part and "= delete" not in part and not NOT_COUNTED.match(part)
    ]


def sizes(source: str) -> Iterator[Size]:
    for found in CLASS.finditer(source):
        own = own_declarations(found["body"])
        methods = sum("(" in declaration for declaration in own)
        yield Size(found["name"], found["comment"], methods, len(own) - methods)


def main() -> int:
    counted = 0
    problems = []
    for root in ROOTS:
        for file in sorted((TREE / root).rglob("*.[hc]pp")):
            for size in sizes(file.read_text(encoding="utf-8")):
                counted += 1
                problems += [
                    f"{file.relative_to(TREE)}: {size.name} has {what}: split it along its ideas, "
                    "or say in the comment in front of it why it has 'more methods than' or 'more "
                    "members than' other classes"
                    for what in size.unexplained()
                ]
    print(
        "\n".join([*problems, f"check_class_sizes: {counted} classes, {len(problems)} too large"])
    )
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
