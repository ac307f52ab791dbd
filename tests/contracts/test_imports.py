"""Rooms import downwards only, and nothing heavy arrives before it is needed."""

import ast
import subprocess
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import geotlm_lm
from geotlm_lm.core.files import resource_dir

PACKAGE = Path(geotlm_lm.__file__).parent

LEVELS = (
    {"core"},
    {"alignment", "runs"},
    {"simulation", "recordings", "backbone", "dgr", "probe", "language"},
    {"model", "data", "views", "motion"},
    {"track"},
    {"query"},
    {"checkpoint"},
    {"answering"},
    {"training"},
    {"benchmarks", "data_sets", "reference_readings", "doctor"},
    {"cli"},
)
"""Rooms and top-level modules, lowest first. Rooms of one level do not import each other."""

FORBIDDEN = {
    "core": {"torch", "cv2", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "recordings": {"torch", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "simulation": {"transformers", "typer", "gradio", "sklearn"},
    "dgr": {"transformers", "cv2", "typer", "gradio"},
    "motion": {"transformers", "cv2", "typer", "gradio"},
    "alignment": {"transformers", "scipy", "sklearn", "typer", "gradio"},
    "language": {"cv2", "typer", "gradio"},
    "query": {"cv2", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "views": {"torch", "scipy", "sklearn", "transformers", "typer", "gradio"},
}
"""Outside packages a room must do without, anywhere in it."""

HEAVY = {"torch", "transformers", "tokenizers", "cv2", "scipy", "sklearn", "gradio", "matplotlib"}
HEAVY |= {"ray"}

FILES = sorted(
    path
    for path in PACKAGE.rglob("*.py")
    if "bundle" not in path.parts
    and not (path.parent == PACKAGE and path.stem in ("__init__", "__main__"))
)


def room_of(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def level_of(room):
    return next(i for i, rooms in enumerate(LEVELS) if room in rooms)


def imported(path, everywhere=True):
    """Return the dotted names a file imports; only those at its top level if not `everywhere`.

    Imports under `if TYPE_CHECKING` never run; they count as dependencies all the same.
    """
    tree = ast.parse(path.read_text())
    names = set()
    for node in ast.walk(tree) if everywhere else tree.body:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            # A relative import keeps its dots, and so belongs to no room.
            names |= {f"{'.' * node.level}{node.module}.{alias.name}" for alias in node.names}
    return names


def outside(path, everywhere=True):
    return {name.split(".")[0] for name in imported(path, everywhere)}


def test_rooms_import_only_downwards_and_in_full():
    wrong = [
        f"{path.relative_to(PACKAGE)} imports {name}"
        for path in FILES
        for name in sorted(imported(path))
        if name.startswith(".") or not is_downwards(room_of(path), name.split("."))
    ]
    assert wrong == []


def is_downwards(room, names):
    if names[0] != "geotlm_lm" or len(names) == 1 or names[1] in (room, "__version__"):
        return True
    return level_of(names[1]) < level_of(room)


def module_of(path):
    dotted = ".".join(("geotlm_lm", *path.relative_to(PACKAGE).with_suffix("").parts))
    return dotted.removesuffix(".__init__")


def test_modules_import_each_other_in_no_circle():
    modules = {module_of(path): path for path in FILES}
    graph = {
        module: {name if name in modules else name.rpartition(".")[0] for name in imported(path)}
        for module, path in modules.items()
    }
    order = tuple(TopologicalSorter(graph).static_order())
    assert order.index("geotlm_lm.core.clip") < order.index("geotlm_lm.answering.answerer")


def test_rooms_do_without_what_they_must_not_know():
    wrong = {path.name: outside(path) & FORBIDDEN.get(room_of(path), set()) for path in FILES}
    assert {name: packages for name, packages in wrong.items() if packages} == {}


def used_of_the_package(path):
    """Return the dotted names of the package that a file of the page imports, or reads of `lm`."""
    read = {
        f"geotlm_lm.{node.attr}"
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Attribute)
        and isinstance(node.value, ast.Name)
        and node.value.id == "lm"
    }
    return read | {name for name in imported(path) if name.startswith("geotlm_lm.")}


def test_the_page_uses_public_names_and_errors_only():
    public = {f"geotlm_lm.{name}" for name in geotlm_lm.__all__}
    wrong = [
        f"{path.name} uses {name}"
        for path in sorted(resource_dir("app").glob("*.py"))
        for name in sorted(used_of_the_package(path) - public)
        if not name.startswith("geotlm_lm.core.errors.")
    ]
    assert wrong == []


def test_public_names_resolve_and_others_are_attribute_errors():
    assert all(getattr(geotlm_lm, name) is not None for name in geotlm_lm.__all__)
    with pytest.raises(AttributeError, match="no attribute 'nonsense'"):
        geotlm_lm.nonsense  # noqa: B018


def test_importing_the_package_loads_nothing_heavy_not_even_numpy():
    program = (
        "import sys; before = set(sys.modules); import geotlm_lm; "
        "print(sorted(name.split('.')[0] for name in set(sys.modules) - before))"
    )
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    loaded = set(ast.literal_eval(done.stdout))
    assert not loaded & (HEAVY | {"numpy"})
    assert len(loaded) < 30
