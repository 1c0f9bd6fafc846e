"""Names that a generator of code is afraid of, and comments that it must not stumble over."""

from __future__ import annotations

from random import Random

from gidl.syntax.keywords import UNUSED_BY_LOWER, USED_BY_LOWER, words

CPP = sorted(
    words(
        """
        alignas and and_eq asm auto bitand bitor bool break catch char8_t class compl concept
        consteval constexpr co_await co_yield decltype delete do dynamic_cast else explicit extern
        friend for goto if inline int mutable namespace new noexcept not nullptr operator or
        override final protected register requires return signed sizeof static static_assert
        template this throw thread_local try using virtual volatile while xor std tl main size_t
        """
    )
)
PYTHON = sorted(
    words(
        """
        None True and as assert async await cls def del elif except finally from global is lambda
        match nonlocal pass print raise self type with yield str bytes list dict tuple object
        property range len isinstance repr chr sorted sum int bool float set id hash format
        NotImplemented annotations
        """
    )
)
OURS = sorted(
    words(
        """
        value values bits set_bits raw out field tag Held encode decode encoded_size fingerprint
        type_name name number entry item to from_ call code size wrong result result_ run core
        source stamp stamp_ns read guard names row why session has to_string decode_enum separator
        selecting arm main flags data index count key first same other pack unpack mro args text
        detail add_note with_traceback gecos wire robcl Kind Handler Access Parts Method Interface
        Servant Command Decoder Encoder Operation Object ObjectRef Failure Stream Result Execution
        DeclaredError Quality Beat publish np numpy dataclass Enum IntEnum Any Final Self Mapping
        a b
        """
    )
)
MACROS = sorted(
    words(
        """
        EIO INT_MAX INT_MIN UINT64_MAX errno EOF NAN INFINITY NULL stdin stdout assert major minor
        BUFSIZ RAND_MAX CHAR_BIT PATH_MAX SIGINT SIGTERM EXIT_SUCCESS M_PI FLT_MAX DBL_MAX linux
        unix offsetof HUGE_VAL DOMAIN OVERFLOW SEEK_SET BIG_ENDIAN CLOCK_REALTIME EINTR SIZE_MAX
        """
    )
)
PLAIN = sorted(
    words(
        """
        x y z x_n x_n_ x_size pose speed torque left right Speed Pose State Mode Frame Arm Status
        Colour Level Reading Goal Limits Part
        """
    )
)
MODULES = sorted(
    words("geo a b lab std gecos robcl class def types enum in_ x wire detail int delete")
)

POOL = [word for word in (*CPP, *PYTHON, *OURS, *MACROS) if word.lower() not in UNUSED_BY_LOWER]

COMMENTS = (
    "A comment.",
    "Ends in a backslash \\",
    'Says "three" \'\'\'quotes\'\'\' and """three more"""',
    'Ends in a quote "',
    "Looks like an end * / and a start / * and // another",
    "Grüße, 速度, \N{OHM SIGN} and \N{ROBOT FACE}",
    "%s {braces} {{ jinja }} {% raw %} ${shell} \\n \\x00 \\u12 \\N{",
    "A very long comment " + "that goes on and on " * 14 + "and ends.",
    "#define X 1",
    "trailing ??/ trigraph",
    "one word that is longer than any line: " + "a" * 140,
)


def name(dice: Random) -> str:
    chance = dice.random()
    if chance < 0.35:
        return dice.choice(PLAIN)
    word = dice.choice(POOL)
    if chance < 0.5:
        return word + "_"
    return word


def written(word: str) -> str:
    """The name as IDL has it: its own keywords are escaped."""
    return f"_{word}" if word.lower() in USED_BY_LOWER else word


def comment(dice: Random) -> str:
    """A comment above a declaration, or nothing."""
    if dice.random() > 0.12:
        return ""
    text = dice.choice(COMMENTS)
    return f"/** {text} */\n" if dice.random() < 0.5 else f"/// {text}\n"


def comment_behind(dice: Random) -> str:
    return f"  // {dice.choice(COMMENTS)}" if dice.random() < 0.12 else ""
