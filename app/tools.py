"""Tools as programs see them: a function's parameters checked, its schemas, its mistakes told."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, create_model

from geotlm_lm import GeoTLMError

logger = logging.getLogger(__name__)

OUR_FAULT = "The tool failed, and it is not your fault; the server's log has the reason."


@dataclass(frozen=True)
class Tool:
    """A function that programs and agents call by name.

    Args:
        name: Its own.
        description: What it does, and what it returns.
        function: That is called with its parameters.
        parameters: What these are checked by.
        output: What its result is described by.
    """

    name: str
    description: str
    function: Callable[..., dict[str, Any]]
    parameters: type[BaseModel]
    output: TypeAdapter[Any]

    @classmethod
    def of(cls, function: Callable[..., dict[str, Any]]) -> Tool:
        """Return the tool of a function whose parameters and result are annotated."""
        hints = get_type_hints(function, include_extras=True)
        fields = {
            name: (hints[name], ... if one.default is inspect.Parameter.empty else one.default)
            for name, one in inspect.signature(function).parameters.items()
        }
        model = create_model(function.__name__, __config__=ConfigDict(extra="forbid"), **fields)
        described = inspect.getdoc(function) or ""
        return cls(function.__name__, described, function, model, TypeAdapter(hints["return"]))

    @property
    def _names(self) -> tuple[str, ...]:
        return tuple(self.parameters.model_fields)

    @property
    def input_schema(self) -> dict[str, Any]:
        """What it takes, as JSON Schema."""
        return _without_titles(self.parameters.model_json_schema())

    @property
    def output_schema(self) -> dict[str, Any]:
        """What it returns, as JSON Schema."""
        return _without_titles(self.output.json_schema(mode="serialization"))

    def call(self, given: Mapping[str, Any]) -> dict[str, Any]:
        """Return the function's result as plain JSON values.

        Args:
            given: Its parameters by name.

        Raises:
            GeoTLMError: If a parameter is wrong, or the function cannot do what is asked, in one
                sentence; a mistake of ours is logged and told as such.
        """
        try:
            checked = self.parameters.model_validate(dict(given))
        except ValidationError as error:
            raise GeoTLMError(self._sentence(error)) from None
        try:
            result = self.function(**{name: getattr(checked, name) for name in self._names})
            return self.output.dump_python(result, mode="json", warnings=False)
        except GeoTLMError:
            raise
        except Exception as error:
            logger.exception("the tool %s failed", self.name)
            raise GeoTLMError(OUR_FAULT) from error

    def _sentence(self, error: ValidationError) -> str:
        """Return the first of what is wrong with the parameters."""
        first = error.errors(include_url=False)[0]
        name = ".".join(str(one) for one in first["loc"])
        if first["type"] == "missing":
            fields = self.parameters.model_fields
            needed = [name for name in self._names if fields[name].is_required()]
            return f"{self.name}: {name} is missing; give {' and '.join(needed)}."
        if first["type"] == "extra_forbidden":
            known = ", ".join(self._names) or "none"
            return f"{self.name}: there is no parameter {name[:80]!r}; it takes {known}."
        said = first["msg"][:1].lower() + first["msg"][1:]
        return (
            f"{self.name}: {name} was {_shown(first['input'])}, and {said}; the tool's schema says "
            f"what it may be."
        )


def _shown(value: Any) -> str:
    shown = repr(value)
    return shown if len(shown) <= 40 else f"{shown[:37]}..."


def _without_titles(schema: Any) -> Any:
    """Return a schema without the titles that repeat each name."""
    if isinstance(schema, list):
        return [_without_titles(one) for one in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        name: _without_titles(one)
        for name, one in schema.items()
        if not (name == "title" and isinstance(one, str))
    }
