"""Turns the arguments of a call, given as plain data, into the bytes of a request."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from inspect import Parameter, Signature
from typing import Any

from gecos.dynamic_client.model import Model, Value
from gecos.dynamic_client.names import PARAMETER_WORDS, member_name
from gecos.dynamic_client.plain import place_of_error, plain_data
from gecos.dynamic_client.types import Types
from gecos.wire import EncodeError, JsonError, Parts
from gecos.wire.members import Arguments


class Request:
    """The parameters of a call. `name` is the name of the call in error messages."""

    def __init__(self, name: str, values: Sequence[Value], types: Types, model: Model) -> None:
        self.name = name
        steps = [types.step(each) for each in values]
        words = PARAMETER_WORDS | {model.class_name(n) for v in values for n in v.use.named()}
        self.spelled = [member_name(each.name, words) for each in values]
        self.steps = steps
        self._values = values
        self._model = model
        self._defaults = {
            i: types.default(each) for i, each in enumerate(values) if each.may_be_missing
        }
        first = self._first_missing()
        self.defaults = tuple(self._defaults[i] for i in range(first, len(values)))
        names = [each.name for each in values]
        self.arguments = Arguments(name, names, steps, self.defaults)

    def _first_missing(self) -> int:
        """Returns the index of the first parameter that an older caller may leave out. Such a
        caller leaves out all following parameters, too."""
        first = len(self._values)
        while first - 1 in self._defaults:
            first -= 1
        return first

    def encoded(self, given: Sequence[Any], named: Mapping[str, Any]) -> Parts:
        """Returns the bytes of the request. Raises TypeError for a missing or unknown argument, and
        EncodeError, which names the member, for a value that does not fit."""
        arguments = self.arguments
        data = self._bound(given, named)
        plain = {key: plain_data(each, f"{self.name}.{key}") for key, each in data.items()}
        try:
            made = self._defaults | dict(arguments.made(plain, self.name))
        except JsonError as error:
            raise EncodeError(error.path, error.why) from None
        values = [made[i] for i in range(len(self._values))]
        try:
            return arguments.encode(*values)
        except EncodeError as error:
            raise EncodeError(self._place(values) or error.field, error.why) from None

    def _place(self, values: Sequence[Any]) -> str:
        for value, kind, each in zip(self._values, self.arguments.kinds, values, strict=True):
            try:
                kind.put(each, [], "")
            except EncodeError:
                return place_of_error(kind, each, f"{self.name}.{value.name}")
        return ""

    def _bound(self, given: Sequence[Any], named: Mapping[str, Any]) -> dict[str, Any]:
        """Returns the arguments, by the names of their parameters in the interface."""
        names = [each.name for each in self._values]
        if len(given) > len(names):
            raise TypeError(
                f"{self.name}() takes at most {len(names)} arguments, {len(given)} are given"
            )
        bound = dict(zip(names, given, strict=False))
        spelled = dict(zip(names, names, strict=True)) | dict(zip(self.spelled, names, strict=True))
        for key, each in named.items():
            if key not in spelled:
                known = "give one of " + ", ".join(self.spelled) if names else "it takes none"
                raise TypeError(f"{self.name}() has no parameter {key}; {known}")
            if spelled[key] in bound:
                raise TypeError(f"{self.name}() got two values for its parameter {key}")
            bound[spelled[key]] = each
        for i, name in enumerate(names):
            if name not in bound and i not in self._defaults:
                missing = self.spelled[i]
                raise TypeError(f"{self.name}() needs its parameter {missing}; give `{missing}=…`")
        return bound

    def signature(self, gives: str) -> Signature:
        first = self._first_missing()
        parameters = [Parameter("self", Parameter.POSITIONAL_OR_KEYWORD)]
        for i, (name, value) in enumerate(zip(self.spelled, self._values, strict=True)):
            optional = value.optional or i < first
            default = None if optional else self._model.default_of(value)
            parameters.append(
                Parameter(
                    name,
                    Parameter.POSITIONAL_OR_KEYWORD,
                    default=default if i >= first else Parameter.empty,
                    annotation=value.type,
                )
            )
        return Signature(parameters, return_annotation=gives)
