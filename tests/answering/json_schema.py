"""A validator of as much of JSON Schema as the published schema uses; more is refused."""

TYPES = {
    "object": dict,
    "array": list,
    "string": str,
    "boolean": bool,
    "null": type(None),
}
ANNOTATIONS = {"$schema", "title", "description", "$defs"}
CHECKED = {
    "type",
    "enum",
    "anyOf",
    "$ref",
    "required",
    "properties",
    "additionalProperties",
    "items",
    "minItems",
    "maxItems",
    "minimum",
    "maximum",
}


def problems(value, schema, root, where="$"):
    """Return every way in which `value` breaks `schema`."""
    unknown = set(schema) - ANNOTATIONS - CHECKED
    assert not unknown, f"{where}: the validator knows no {unknown}"
    found = []
    if "$ref" in schema:
        found += problems(value, _target(schema["$ref"], root), root, where)
    if "anyOf" in schema and all(problems(value, one, root, where) for one in schema["anyOf"]):
        found.append(f"{where}: {value!r} fits none of anyOf")
    if "enum" in schema and value not in schema["enum"]:
        found.append(f"{where}: {value!r} is none of {schema['enum']}")
    if "type" in schema and not _has_type(value, schema["type"]):
        return [*found, f"{where}: {value!r} is no {schema['type']}"]
    if isinstance(value, dict):
        found += _object_problems(value, schema, root, where)
    if isinstance(value, list):
        found += _array_problems(value, schema, root, where)
    if _has_type(value, "number"):
        if value < schema.get("minimum", value):
            found.append(f"{where}: {value} is below {schema['minimum']}")
        if value > schema.get("maximum", value):
            found.append(f"{where}: {value} is above {schema['maximum']}")
    return found


def _object_problems(value, schema, root, where):
    named = schema.get("properties", {})
    found = [f"{where}: lacks {name}" for name in schema.get("required", ()) if name not in value]
    for name, inner in value.items():
        other = schema.get("additionalProperties", {})
        if name in named:
            found += problems(inner, named[name], root, f"{where}.{name}")
        elif other is False:
            found.append(f"{where}: {name} is not foreseen")
        else:
            found += problems(inner, other, root, f"{where}.{name}")
    return found


def _array_problems(value, schema, root, where):
    found = []
    if not schema.get("minItems", 0) <= len(value) <= schema.get("maxItems", len(value)):
        found.append(f"{where}: holds {len(value)} items")
    for index, inner in enumerate(value):
        found += problems(inner, schema.get("items", {}), root, f"{where}[{index}]")
    return found


def _has_type(value, names):
    names = [names] if isinstance(names, str) else names
    is_number = isinstance(value, int | float) and not isinstance(value, bool)
    return any(
        is_number and (name == "number" or isinstance(value, int))
        if name in ("number", "integer")
        else isinstance(value, TYPES[name])
        for name in names
    )


def _target(reference, root):
    found = root
    for name in reference.removeprefix("#").strip("/").split("/"):
        found = found[name] if name else found
    return found
