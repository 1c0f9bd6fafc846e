"""Prints the names that system headers define outside of all namespaces. Generated C++ gives the
name of a macro to nothing, and gives the name of a function, type or constant of the C library to
nothing at global scope.

    tools/cpp_names_of_headers.py > codegen/gidl/names/cpp_names_of_headers.txt

The headers are those of C++20, and of POSIX those that programs beside a robot are likely to
include before generated code. Compilers and systems differ. Therefore names are only added to the
file, and never removed.
"""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

TREE = Path(__file__).resolve().parent.parent

HEADERS = """
    algorithm any array atomic barrier bit bitset cassert cctype cerrno cfenv cfloat charconv chrono
    cinttypes climits clocale cmath codecvt compare complex concepts condition_variable coroutine
    csetjmp csignal cstdarg cstddef cstdint cstdio cstdlib cstring ctime cuchar cwchar cwctype deque
    exception execution filesystem format forward_list fstream functional future initializer_list
    iomanip ios iosfwd iostream istream iterator latch limits list locale map memory
    memory_resource mutex new numbers numeric optional ostream queue random ranges ratio regex
    scoped_allocator semaphore set shared_mutex source_location span sstream stack stdexcept
    stop_token streambuf string string_view syncstream system_error thread tuple type_traits
    typeindex typeinfo unordered_map unordered_set utility valarray variant vector version
    arpa/inet.h assert.h ctype.h dirent.h dlfcn.h endian.h errno.h fcntl.h float.h inttypes.h
    limits.h locale.h math.h netdb.h netinet/in.h netinet/tcp.h poll.h pthread.h sched.h semaphore.h
    setjmp.h signal.h spawn.h stdint.h stdio.h stdlib.h string.h strings.h sys/epoll.h sys/eventfd.h
    sys/file.h sys/ioctl.h sys/mman.h sys/prctl.h sys/resource.h sys/select.h sys/socket.h
    sys/stat.h sys/syscall.h sys/sysmacros.h sys/time.h sys/timerfd.h sys/types.h sys/uio.h sys/un.h
    sys/utsname.h sys/wait.h syslog.h termios.h time.h unistd.h wchar.h wctype.h
"""

# A declaration at global scope, or in an extern "C" there, as clang prints it in a syntax tree.
_DECLARATION = re.compile(
    r"^(?:[|`]-|[| ] [|`]-)(?:Function|Var|Typedef|Enum|CXXRecord|Using|TypeAlias|FunctionTemplate"
    r"|ClassTemplate|Namespace)Decl 0x\w+ (.*)"
)
_ENUMERATOR = re.compile(r"EnumConstantDecl 0x\w+ .*?(?:col|line):[\d:]+ (?:referenced )?(\w+) '")
_NAME = re.compile(
    r"(?:col|line|\.h|>):?[\d:]* (?:implicit |used |referenced |constexpr )*"
    r"(?:struct |class |union |enum )?(\w+)(?: '| definition|$)"
)


def source() -> str:
    return "".join(f"#if __has_include(<{h}>)\n#include <{h}>\n#endif\n" for h in HEADERS.split())


def macros(compiler: str) -> set[str]:
    """Returns the names of all macros, also of those that the compiler defines by itself."""
    command = [compiler, "-std=gnu++20", "-dM", "-E", "-w", "-x", "c++", "-"]
    text = subprocess.run(command, input=source(), capture_output=True, text=True, check=True)
    return {m[1] for m in re.finditer(r"#define (\w+)", text.stdout)}


def names_at_the_top(clang: str) -> set[str]:
    command = [clang, "-std=gnu++20", "-fsyntax-only", "-w", "-Xclang", "-ast-dump"]
    command += ["-fno-color-diagnostics", "-x", "c++", "-"]
    tree = subprocess.run(command, input=source(), capture_output=True, text=True, check=True)
    found = set()
    top = ""  # kind of the declaration at the top that the line belongs to
    inner = ""  # and of the one inside an extern "C"
    for line in tree.stdout.splitlines():
        if line[:2] in ("|-", "`-"):
            top, inner = line[2:].split(" ", 1)[0], ""
        elif line[2:4] in ("|-", "`-") and top == "LinkageSpecDecl":
            inner = line[4:].split(" ", 1)[0]
        elif top == "EnumDecl" or inner == "EnumDecl":
            constant = _ENUMERATOR.search(line)
            if constant and not line.startswith("    "):
                found.add(constant[1])
            continue
        else:
            continue
        if line[2:4] in ("|-", "`-") and top != "LinkageSpecDecl":
            continue
        declared = _DECLARATION.match(line)
        name = _NAME.search(declared[1]) if declared else None
        if name:
            found.add(name[1])
    return found


def printed(names: set[str]) -> list[str]:
    """Returns lines with the names. No interface has a name that begins with an underscore."""
    lines = [""]
    for name in sorted(n for n in names if not n.startswith("_")):
        if len(lines[-1]) + len(name) > 98:
            lines.append("")
        lines[-1] += f" {name}" if lines[-1] else name
    return lines


def main() -> None:
    clang = str(TREE / "tools" / "clang.sh")
    defined = macros("g++") | macros(clang)
    print("# Names that system headers define. Written by tools/cpp_names_of_headers.py.")
    print("# Macros:")
    print("\n".join(printed(defined)))
    print("# Outside of all namespaces:")
    print("\n".join(printed(names_at_the_top(clang) - defined)))


if __name__ == "__main__":
    main()
