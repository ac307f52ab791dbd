"""Rooms import downwards only, and nothing heavy arrives before it is needed."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import geotlm_lm
from geotlm_lm.core.resources import resource_dir

PACKAGE = Path(geotlm_lm.__file__).parent

LEVELS = (
    {"core"},
    {
        "simulation",
        "recordings",
        "backbone",
        "dgr",
        "probe",
        "language",
        "evaluation",
        "conversation",
    },
    {"model", "data", "views", "odometry"},
    {"checkpoint"},
    {"precision"},
    {"answering", "training"},
    {"experiments", "reports", "live", "opinions"},
    {"fuzzing"},
    {"cli"},
)
"""Rooms and top-level modules, lowest first. Rooms of one level do not import each other."""

FORBIDDEN = {
    "core": {"torch", "cv2", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "recordings": {"torch", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "evaluation": {"torch", "cv2", "transformers", "typer", "gradio"},
    "simulation": {"transformers", "typer", "gradio", "sklearn"},
    "dgr": {"transformers", "cv2", "typer", "gradio"},
    "odometry": {"transformers", "cv2", "typer", "gradio"},
    "language": {"cv2", "typer", "gradio"},
    "conversation": {"torch", "cv2", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "views": {"torch", "scipy", "sklearn", "transformers", "typer", "gradio"},
    "live": {"torch", "scipy", "sklearn", "transformers", "typer", "gradio"},
}
"""Outside packages a room must do without, anywhere in it."""

HEAVY = {"torch", "transformers", "tokenizers", "cv2", "scipy", "sklearn", "gradio", "matplotlib"}

FILES = sorted(path for path in PACKAGE.rglob("*.py") if "bundle" not in path.parts)


def room_of(path):
    first = path.relative_to(PACKAGE).parts[0]
    return first.removesuffix(".py")


def level_of(room):
    return next(i for i, rooms in enumerate(LEVELS) if room in rooms)


def imported(path, everywhere=True):
    """Return the dotted names a file imports; only those at its top level if not `everywhere`.

    Imports under `if TYPE_CHECKING` never run; they count as dependencies all the same.
    """
    tree = ast.parse(path.read_text())
    nodes = ast.walk(tree) if everywhere else tree.body
    names = set()
    for node in nodes:
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
            assert node.level == 0, f"{path}: imports are written out in full"
    return names


def is_root(path):
    return path.parent == PACKAGE and path.stem in ("__init__", "__main__")


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_rooms_import_only_downwards(path):
    if is_root(path):
        pytest.skip("the package's own front door")
    room = room_of(path)
    for name in imported(path):
        if not name.startswith("geotlm_lm."):
            continue
        other = name.split(".")[1]
        if other in (room, "__version__"):
            continue
        assert level_of(other) < level_of(room), f"{room} imports {name}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(PACKAGE)))
def test_rooms_do_without_what_they_must_not_know(path):
    outside = {name.split(".")[0] for name in imported(path)}
    assert not outside & FORBIDDEN.get(room_of(path), set())


@pytest.mark.parametrize("path", sorted(resource_dir("app").glob("*.py")), ids=lambda p: p.stem)
def test_the_page_uses_public_names_and_errors_only(path):
    tree = ast.parse(path.read_text())
    used = {
        f"{node.module}.{alias.name}"
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom) and node.level == 0
        for alias in node.names
    }
    ours = {name for name in used if name.startswith("geotlm_lm")}
    public = {f"geotlm_lm.{name}" for name in geotlm_lm.__all__}
    assert {n for n in ours if not n.startswith("geotlm_lm.core.errors.")} <= public


@pytest.mark.parametrize("path", sorted((PACKAGE / "cli").glob("*.py")), ids=lambda path: path.stem)
def test_the_command_line_imports_nothing_heavy_before_a_command_runs(path):
    outside = {name.split(".")[0] for name in imported(path, everywhere=False)}
    assert not outside & HEAVY


@pytest.mark.parametrize("name", sorted(geotlm_lm.__all__))
def test_public_names_resolve(name):
    assert getattr(geotlm_lm, name) is not None


def test_an_unknown_public_name_is_an_attribute_error():
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


@pytest.mark.parametrize("room", ["recordings.read", "recordings.choose", "evaluation"])
def test_rooms_without_torch_import_without_torch(room):
    program = f"import sys, geotlm_lm.{room}; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True)
    assert done.stdout.strip() == "False", done.stderr
