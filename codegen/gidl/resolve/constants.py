"""Computes constant expressions: values, their kinds, and the ranges that they must fit."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from gidl.diagnostics.findings import Findings
from gidl.diagnostics.source import Span
from gidl.model import EnumValue, Value
from gidl.syntax.tree import Binary, Expression, Literal, NameUse, RefusedValue, ScopedName, Unary


@dataclass(frozen=True, slots=True)
class Computed:
    kind: str  # one of "bool" "int" "float" "string" "char" "enum"
    value: Value
    # True: an integer that an operator computed from two integers. It must not become a
    # floating-point number: 1 / 2 is 0, where a reader expects 0.5.
    is_arithmetic: bool = False


@dataclass(frozen=True, slots=True)
class Arithmetic:
    """The rules of integer arithmetic: every intermediate result must fit in `bits` bits, signed or
    unsigned. The value of `~` depends on `unsigned`, as the IDL standard says."""

    bits: int = 64
    unsigned: bool = False


class _Failed(Exception):
    """Raised when an expression has no value, after the finding that tells why."""


def compute(
    expression: Expression,
    look_up: Callable[[ScopedName], Computed | None],
    findings: Findings,
    arithmetic: Arithmetic = Arithmetic(),
) -> Computed | None:
    """Returns the value of the expression. If it has no value, reports a finding and returns None.

    `look_up` returns the value of a constant or enumerator, or reports a finding and returns None.
    """
    try:
        found = _Calculator(look_up, findings, arithmetic).value(expression)
    except _Failed:
        return None
    return replace(found, is_arithmetic=found.kind == "int" and _has_operands(expression))


def _has_operands(expression: Expression) -> bool:
    """Returns whether the expression is computed from two operands, for example `-(1 / 2)`."""
    while isinstance(expression, Unary):
        expression = expression.operand
    return isinstance(expression, Binary)


def refuse_arithmetic(found: Computed, at: Span, findings: Findings) -> bool:
    """Reports integer arithmetic whose result would become a floating-point number. Returns whether
    there is a finding."""
    if found.is_arithmetic:
        findings.error(
            "G0304",
            at,
            "the operands are integers, but the value must be a floating-point number",
            "write the operands with a decimal point, for example 1.0 / 2.0",
        )
    return found.is_arithmetic


def computed(value: Value) -> Computed:
    """Returns `value` together with its kind."""
    match value:
        case bool():
            return Computed("bool", value)
        case int():
            return Computed("int", value)
        case float():
            return Computed("float", value)
        case EnumValue():
            return Computed("enum", value)
        case str():
            return Computed("string", value)


def is_character(value: Value) -> bool:
    """Returns whether `value` fits a `char`: it is one character of Latin-1, which may be NUL."""
    return isinstance(value, str) and len(value) == 1 and ord(value) < 256


class _Calculator:
    def __init__(
        self,
        look_up: Callable[[ScopedName], Computed | None],
        findings: Findings,
        arithmetic: Arithmetic,
    ) -> None:
        self._look_up = look_up
        self._findings = findings
        self._arithmetic = arithmetic

    def _fail(self, code: str, at: Span, message: str, *help_lines: str) -> _Failed:
        self._findings.error(code, at, message, *help_lines)
        return _Failed()

    def value(self, expression: Expression) -> Computed:
        match expression:
            case Literal(value, kind, span):
                if isinstance(value, float) and not math.isfinite(value):
                    raise self._fail("G0301", span, "this number is too large for a double")
                return Computed(kind, value)
            case RefusedValue():
                raise _Failed
            case NameUse(name, _):
                found = self._look_up(name)
                if found is None:
                    raise _Failed
                return found
            case Unary(operator, operand, span):
                return self._unary(operator, self._operand(operand), span)
            case Binary():
                return self._chain(expression)

    def _chain(self, expression: Binary) -> Computed:
        """Computes `a + b + c ...` of any length without recursion. Operators group to the left."""
        chain: list[Binary] = []
        first: Expression = expression
        while isinstance(first, Binary):
            chain.append(first)
            first = first.left
        result = self._operand(first)
        for link in reversed(chain):
            result = self._binary(link.operator, result, link.right, link.span)
        return result

    def _operand(self, expression: Expression) -> Computed:
        found = self.value(expression)
        if found.kind == "int":
            assert isinstance(found.value, int)
            return self._checked(found.value, expression.span)
        return found

    def _unary(self, operator: str, operand: Computed, span: Span) -> Computed:
        value = operand.value
        if operand.kind == "float" and operator != "~":
            assert isinstance(value, float)
            return Computed("float", -value if operator == "-" else value)
        if operand.kind != "int":
            raise self._fail(
                "G0304", span, f"'{operator}' needs a number, not {describe_kind(operand.kind)}"
            )
        assert isinstance(value, int)
        match operator:
            case "-":
                return self._checked(-value, span)
            case "~":
                most = (1 << self._arithmetic.bits) - 1
                unsigned = self._arithmetic.unsigned and value >= 0
                return self._checked(most - value if unsigned else ~value, span)
            case _:
                return operand

    def _binary(
        self, operator: str, left: Computed, right_side: Expression, span: Span
    ) -> Computed:
        right = self._operand(right_side)
        if left.kind == right.kind == "int":
            assert isinstance(left.value, int) and isinstance(right.value, int)
            return self._integers(operator, left.value, right.value, right_side.span, span)
        if left.kind in ("int", "float") and right.kind in ("int", "float"):
            return self._floats(operator, left, right, span)
        if left.kind == right.kind == "enum" and operator == "|":
            return self._flags(left, right, span)
        wrong = left if left.kind not in ("int", "float") else right
        raise self._fail(
            "G0304", span, f"'{operator}' needs numbers, not {describe_kind(wrong.kind)}"
        )

    def _integers(self, operator: str, left: int, right: int, at: Span, span: Span) -> Computed:
        match operator:
            case "|":
                result = left | right
            case "^":
                result = left ^ right
            case "&":
                result = left & right
            case "+":
                result = left + right
            case "-":
                result = left - right
            case "*":
                result = left * right
            case "<<" | ">>":
                if not 0 <= right < 64:
                    raise self._fail(
                        "G0303", at, f"cannot shift by {right} bits: only 0 to 63 are possible"
                    )
                result = left << right if operator == "<<" else left >> right
            case _:
                if right == 0:
                    raise self._fail("G0302", at, "division by zero")
                quotient = abs(left) // abs(right)
                quotient = quotient if (left < 0) == (right < 0) else -quotient
                result = quotient if operator == "/" else left - quotient * right
        return self._checked(result, span)

    def _floats(self, operator: str, left: Computed, right: Computed, span: Span) -> Computed:
        if left.kind != right.kind:
            raise self._fail(
                "G0304",
                span,
                "an expression cannot mix integers and floating-point numbers",
                "write the integer with a decimal point, for example 2.0",
            )
        assert isinstance(left.value, float) and isinstance(right.value, float)
        match operator:
            case "+":
                result = left.value + right.value
            case "-":
                result = left.value - right.value
            case "*":
                result = left.value * right.value
            case "/":
                if right.value == 0.0:
                    raise self._fail("G0302", span, "division by zero")
                result = left.value / right.value
            case _:
                raise self._fail("G0304", span, f"'{operator}' needs integers")
        if not math.isfinite(result):
            raise self._fail("G0301", span, "the result is too large for a double")
        return Computed("float", result)

    def _flags(self, left: Computed, right: Computed, span: Span) -> Computed:
        assert isinstance(left.value, EnumValue) and isinstance(right.value, EnumValue)
        if left.value.enum != right.value.enum:
            raise self._fail("G0304", span, "these flags are of different bitmasks")
        literal = f"{left.value.literal}|{right.value.literal}"
        number = left.value.number | right.value.number
        return Computed("enum", EnumValue(left.value.enum, literal, number))

    def _checked(self, result: int, span: Span) -> Computed:
        bits = self._arithmetic.bits
        if not -(1 << bits) // 2 <= result < 1 << bits:
            wider = (
                ""
                if bits == 64
                else "to compute with 64 bits, declare the constant as int64 or uint64"
            )
            raise self._fail("G0301", span, f"{result} does not fit {bits} bits", wider)
        return Computed("int", result)


def describe_kind(kind: str) -> str:
    return {
        "bool": "a boolean",
        "int": "an integer",
        "float": "a floating-point number",
        "string": "a string",
        "char": "a character",
        "enum": "an enumerator",
    }[kind]
