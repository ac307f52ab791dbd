"""The model behind a page that already stands: loaded once, by whoever needs it first."""

import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from types import SimpleNamespace

import pytest

from app.lazy_answerer import LazyAnswerer
from geotlm_lm.core.errors import IncompatibleBundle


def test_nothing_is_loaded_until_it_is_used_and_then_once_for_all():
    loads = []

    def slowly():
        time.sleep(0.05)
        loads.append(1)
        return SimpleNamespace(name="model")

    model = LazyAnswerer(slowly)
    assert not loads
    with ThreadPoolExecutor(8) as pool:
        assert list(pool.map(lambda _: model.name, range(8))) == ["model"] * 8
    assert len(loads) == 1


def test_a_model_that_cannot_be_loaded_says_so_every_time():
    tries = []

    def fails():
        tries.append(1)
        raise IncompatibleBundle("this installation has no model bundle.")

    model = LazyAnswerer(fails)
    for _ in range(2):
        with pytest.raises(IncompatibleBundle, match="no model bundle"):
            _ = model.bundle
    assert len(tries) == 2


def test_the_page_is_built_without_the_models_libraries():
    pytest.importorskip("gradio", reason="building the page needs gradio (extra: app)")
    code = (
        "import sys; from app.lazy_answerer import LazyAnswerer; from app.ui import build; "
        "build(LazyAnswerer(lambda: 1 / 0)); "
        "print([name for name in ('torch', 'transformers') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
