"""Runs the reads of a shared vector (tests/vectors/decoder.json) with the Python decoder."""

from __future__ import annotations

from typing import Any

from gecos.wire import MAX_COUNT, DecodeError, Decoder

CODES = {
    "bool": "?", "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i",
    "uint32": "I", "int64": "q", "uint64": "Q", "float": "f", "double": "d",
}  # fmt: skip
SIZES = {"int16": 2, "double": 8}


def problem_name(error: DecodeError) -> str:
    """As C++ spells it: INVALID_UTF8 is InvalidUtf8."""
    return "".join(word.capitalize() for word in error.problem.name.split("_"))


def verdict_of(error: DecodeError) -> dict[str, Any]:
    return {"problem": problem_name(error), "offset": error.offset, "field": error.field}


def run_reads(data: bytes | memoryview, reads: list[dict[str, Any]]) -> dict[str, Any]:
    """{"values": […]} when all succeeded, else {"refused": {problem, offset, field}}."""
    try:
        return {"values": _values(Decoder(data), reads)}
    except DecodeError as error:
        return {"refused": verdict_of(error)}


def _values(source: Decoder, reads: list[dict[str, Any]]) -> list[Any]:
    values = [_value(source, read) for read in reads]
    return [value for read, value in zip(reads, values, strict=True) if read["get"] != "end"]


def _value(source: Decoder, read: dict[str, Any]) -> Any:
    field = read.get("field", "")
    most = read.get("max", MAX_COUNT)
    match read["get"]:
        case "string":
            return source.string(most, field)
        case "count":
            return source.count(read["min"], most, field)
        case "array":
            return source.array(CODES[read["of"]], read["count"], field).tolist()
        case "counted":
            number = source.count(SIZES[read["of"]], most, field)
            return source.array(CODES[read["of"]], number, field).tolist()
        case "block":
            return _values(source.block(field), read["reads"])
        case "enter":
            return source.enter(field)
        case "end":
            return source.expect_end()
        case number:
            return source.number(CODES[number], field)
