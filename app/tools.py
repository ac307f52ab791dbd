"""Tools as programs and agents see them: typed, checked, with schemas; errors in one sentence."""

from __future__ import annotations

import inspect
import logging
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, get_type_hints

import gradio as gr
from pydantic import BaseModel, ConfigDict, TypeAdapter, ValidationError, create_model

import geotlm_lm as lm
from geotlm_lm.core.errors import choice_of

from .guards import BUSY_TITLE, Busy
from .schema import Recording
from .sources import Upload, path_in
from .toolkit import MODEL

logger = logging.getLogger(__name__)

OUR_FAULT = "The tool failed, and it is not your fault; the server's log has the reason."


@dataclass(frozen=True)
class Tool:
    """A function that programs and agents call by name; its parameters and result are annotated.

    A parameter that is a model of several stands for them: each is a parameter of the tool.
    """

    name: str
    description: str
    function: Callable[..., dict[str, Any]]
    parameters: type[BaseModel]
    groups: Mapping[str, type[BaseModel]]
    output: TypeAdapter[Any]

    @classmethod
    def of(cls, function: Callable[..., dict[str, Any]]) -> Tool:
        """Return the tool of a function."""
        hints = get_type_hints(function, include_extras=True)
        groups = {
            name: kind
            for name, kind in hints.items()
            if isinstance(kind, type) and issubclass(kind, BaseModel)
        }
        fields: dict[str, Any] = {}
        for name, parameter in inspect.signature(function).parameters.items():
            if name in groups:
                shared = groups[name].model_fields.items()
                fields |= {each: (field.annotation, field) for each, field in shared}
            else:
                is_needed = parameter.default is inspect.Parameter.empty
                fields[name] = (hints[name], ... if is_needed else parameter.default)
        name, description = function.__name__, inspect.getdoc(function) or ""
        model = create_model(name, __config__=ConfigDict(extra="forbid"), **fields)
        return cls(name, description, function, model, groups, TypeAdapter(hints["return"]))

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

        Raises:
            GeoTLMError: If a parameter is wrong, or the function cannot do what is asked, in one
                sentence; a defect is logged with its trace and reported as one.
        """
        try:
            checked = self.parameters.model_validate(dict(given))
        except ValidationError as error:
            raise lm.GeoTLMError(self._sentence(error)) from None
        arguments = dict(checked)
        for name, group in self.groups.items():
            arguments[name] = group(**{each: arguments.pop(each) for each in group.model_fields})
        try:
            result = self.function(**arguments)
            return self.output.dump_python(result, mode="json", warnings=False)
        except lm.GeoTLMError:
            raise
        except Exception as error:
            logger.exception("the tool %s failed", self.name)
            raise lm.GeoTLMError(OUR_FAULT) from error

    def serve(self) -> None:
        """Serve the tool over REST; call it inside the `gradio.Blocks`."""
        gr.api(self._typed(), api_name=self.name, api_description=self.description, **MODEL)

    def _typed(self) -> Callable[..., Any]:
        """Return the tool as the toolkit takes it: plain types, files as its clients send them."""
        full = get_type_hints(self.parameters, include_extras=True)
        plain = get_type_hints(self.parameters)
        hints = {name: Upload | str if full[name] == Recording else plain[name] for name in full}

        def call(*given: Any) -> dict[str, Any]:
            try:
                return self.call(dict(zip(self._names, map(path_in, given), strict=True)))
            except lm.GeoTLMError as error:
                title = {"title": BUSY_TITLE} if isinstance(error, Busy) else {}
                raise gr.Error(str(error), print_exception=False, **title) from error

        hints["return"] = get_type_hints(self.function)["return"]
        typed = [
            parameter.replace(annotation=hints[name], kind=parameter.POSITIONAL_OR_KEYWORD)
            for name, parameter in inspect.signature(self.parameters).parameters.items()
        ]
        call.__signature__ = inspect.Signature(typed, return_annotation=hints["return"])
        call.__annotations__, call.__name__, call.__doc__ = hints, self.name, self.description
        return call

    def _sentence(self, error: ValidationError) -> str:
        """Return the first of what is wrong with the parameters."""
        first = error.errors(include_url=False)[0]
        name = ".".join(map(str, first["loc"]))
        if first["type"] == "missing":
            fields = self.parameters.model_fields
            needed = [name for name in self._names if fields[name].is_required()]
            return f"{self.name}: {name} is missing; give {' and '.join(needed)}."
        if first["type"] == "extra_forbidden":
            advice = choice_of(name, self._names) if self._names else "it takes none."
            return f"{self.name}: there is no parameter {name[:80]!r}; {advice}"
        value, reason = repr(first["input"]), first["msg"]
        return (
            f"{self.name}: {name} was {value if len(value) <= 40 else f'{value[:37]}...'}, and "
            f"{reason[:1].lower()}{reason[1:]}; the tool's schema says what it may be."
        )


def _without_titles(schema: Any) -> Any:
    """Return a schema without the titles that repeat each name."""
    if isinstance(schema, list):
        return [_without_titles(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {
        name: _without_titles(part)
        for name, part in schema.items()
        if not (name == "title" and isinstance(part, str))
    }
