"""The codec of generated Python types. It uses LCM's type encoding: big-endian, fields in order.

The C++ codec, `runtime/cpp/gecos/wire`, accepts and refuses the same bytes and uses the same names
for errors. If bytes contain two errors, the codecs may report different ones.

Encoding appends pieces to a list (`Parts`) that is joined once at the end. Decoding raises
`DecodeError`. numpy is imported with the first array, so that programs without arrays start faster.
"""

from gecos.wire.codes import MAX_COUNT, MAX_DEPTH, MAX_TEXT, MAX_ZERO_WIDTH
from gecos.wire.contents import (
    Contents,
    from_bytes,
    from_message,
    put,
    put_block,
    to_bytes,
    to_message,
)
from gecos.wire.decode import Decoder
from gecos.wire.encode import (
    Parts,
    array,
    block,
    char,
    count,
    counted,
    entries,
    exactly,
    fixed,
    fixed_octets,
    number,
    numbers,
    octets,
    secret_string,
    string,
)
from gecos.wire.errors import (
    HIDDEN,
    DecodeError,
    DecodeProblem,
    EncodeError,
    JsonError,
    WrongTypeError,
    expect,
    expect_enumerator,
)
from gecos.wire.fields import Fields
from gecos.wire.values import same, signed, zeros

__all__ = [
    "HIDDEN",
    "MAX_COUNT",
    "MAX_DEPTH",
    "MAX_TEXT",
    "MAX_ZERO_WIDTH",
    "Contents",
    "DecodeError",
    "DecodeProblem",
    "Decoder",
    "EncodeError",
    "Fields",
    "JsonError",
    "Parts",
    "WrongTypeError",
    "array",
    "block",
    "char",
    "count",
    "counted",
    "entries",
    "exactly",
    "expect",
    "expect_enumerator",
    "fixed",
    "fixed_octets",
    "from_bytes",
    "from_message",
    "number",
    "numbers",
    "octets",
    "put",
    "put_block",
    "same",
    "secret_string",
    "signed",
    "string",
    "to_bytes",
    "to_message",
    "zeros",
]
