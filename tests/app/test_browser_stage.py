"""The stage in a real browser: by mouse, keys and fingers; it fits, and axe finds no fault."""

import base64
import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from app import stage
from tests.app.browser import CHAT, COMPLAINT, NAME, NOTHING_SHOWN, SHOWN, STAGE, TEXT
from tests.app.fakes import FakeAnswerer
from tests.track.recordings import there_and_back

pytestmark = pytest.mark.slow

FRAME = "document.querySelector('.stage [data-part=scrub]').valueAsNumber"
CANVAS = "document.querySelector('.stage canvas').toDataURL()"
DROP = """((name, content) => {
    const given = new DataTransfer();
    given.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
    const how = {bubbles: true, cancelable: true, dataTransfer: given};
    STAGE.querySelector('.stage-screen').dispatchEvent(new DragEvent('drop', how));
})""".replace("STAGE", STAGE)
PARTS = (".stage-screen", ".stage-time", ".talk-list", ".chips", ".question")


def box(browser, selector):
    script = f"document.querySelector({selector!r}).getBoundingClientRect().toJSON()"
    return browser.run(script)


def source(name):
    """Return a script of the page as a block, so that it can be run again."""
    return f"{{{(Path(stage.__file__).with_name(name)).read_text()}}}"


def click_at(browser, x, y):
    browser.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    for kind in ("mousePressed", "mouseReleased"):
        browser.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", clickCount=1)


@pytest.mark.parametrize("empty", [(1400, 900)], indirect=True)
def test_an_example_plays_on_load_and_all_is_seen_without_scrolling(browser):
    assert browser.run(f"{NAME}.innerText") == "key"
    browser.wait_for(f"{FRAME} > 0")
    assert browser.run("window.innerHeight") <= 900
    for part in PARTS:
        assert box(browser, part)["bottom"] <= browser.run("window.innerHeight"), part
    assert "clockwise" not in browser.run("document.querySelector('.examples').innerText")


@pytest.mark.parametrize("empty", [(500, 844)], indirect=True)
def test_on_a_phone_picture_timeline_answer_and_question_fit_the_first_screen(browser):
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 1, "mobile": True}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.wait_for("document.querySelector('.stage-screen').clientWidth < 390")
    places = [
        box(browser, part) for part in (".stage-screen", ".stage-time", ".talk-list", ".question")
    ]
    tops = [one["top"] for one in places]
    assert tops == sorted(tops)
    assert places[-1]["bottom"] <= 844
    assert places[-1]["bottom"] < box(browser, ".gallery")["top"]
    last = "[...document.querySelectorAll('.ask-line button')].find(e => e.innerText == 'Ask')"
    assert browser.run(f"{last}.getBoundingClientRect().right") <= 390
    assert browser.run("document.documentElement.scrollWidth") <= 390
    browser.click("Compare", ".stage-actions button")
    browser.wait_for(f"{TEXT}.includes('Choose a second recording')")
    for part in (".stage-second .stage-empty", ".gallery .example"):
        assert 0 < box(browser, part)["top"] < box(browser, part)["bottom"] <= 844, part
    browser.click("Live", "button[role=tab]")
    browser.wait_for("Boolean(document.querySelector('.live-camera').offsetParent)")
    camera = box(browser, ".live-camera")
    assert 0 <= camera["top"] - box(browser, ".tab-wrapper")["bottom"] < 40
    assert box(browser, ".live .stage-screen")["top"] - camera["bottom"] < 60


def test_the_picture_is_played_and_scrubbed_by_keys(browser):
    browser.run("document.querySelector('.stage [data-part=scrub]').focus()")
    browser.press("Home", 36)
    assert browser.run(FRAME) == 0
    browser.press("ArrowRight", 39)
    browser.press("ArrowRight", 39)
    assert browser.run(FRAME) == 2
    browser.press("ArrowLeft", 37)
    assert browser.run(FRAME) == 1
    browser.wait_for("document.querySelector('.stage [data-part=play]').ariaLabel == 'Play'")
    browser.press(" ", 32)
    browser.wait_for(f"{FRAME} != 1")


def test_what_lies_over_the_picture_is_switched(browser):
    browser.open_example("bottle cap")
    browser.run("document.querySelector('.stage [data-part=scrub]').focus()")
    browser.press("End", 35)
    seen = {browser.run(CANVAS)}
    for layer in ("Motion", "Contact", "Difference"):
        browser.click(layer, ".stage-layers button")
        seen.add(browser.run(CANVAS))
    assert len(seen) == 4


def test_a_click_on_the_timeline_shows_that_moment(browser, touch_path):
    browser.open_recording(touch_path)
    line = box(browser, ".stage-time svg")
    browser.run("document.querySelector('.stage [data-part=play]').click()")
    for share in (0.3, 0.8):
        click_at(browser, line["left"] + 64 + share * (line["width"] - 74), line["top"] + 60)
        assert browser.run(FRAME) == pytest.approx(share * 39, abs=1)
    clock = browser.run("document.querySelector('.stage [data-part=clock]').innerText")
    assert 1.1 < float(clock.removesuffix(" s")) < 1.4
    told = browser.run("document.querySelector('.stage-tip').innerText")
    assert "turned 0°" in told
    assert "contact 100 %" in told
    chips = browser.run("document.querySelector('.chips').innerText")
    assert "What happens first and what then?" in chips


def test_contact_without_an_idle_frame_is_neither_drawn_nor_told(
    browser, fake, touch_path, monkeypatch
):
    def encode(clip, **named):
        encoded = FakeAnswerer.encode(fake, clip, **named)
        events = tuple(event for event in encoded.track.events if not event.is_of_contact)
        track = replace(encoded.track, events=events, is_contact_known=False)
        return replace(encoded, track=track)

    monkeypatch.setattr(fake, "encode", encode)
    browser.open_recording(touch_path)
    line = box(browser, ".stage-time svg")
    click_at(browser, line["left"] + line["width"] * 0.8, line["top"] + 60)
    tip = browser.run("document.querySelector('.stage-tip').innerText")
    assert "turned 0°" in tip
    assert "contact" not in tip
    assert browser.run("document.querySelector('.stage-time').textContent").count("not known") == 2
    assert browser.run("document.querySelector('[data-layer=contact]').hidden")
    assert not browser.run("Boolean(document.querySelector('.stage-time .contact-0'))")


@pytest.mark.parametrize(
    ("text", "short"),
    [
        ("27 px right and down", "↘ 27"),
        ("3.1 px up and left", "↖ 3.1"),
        ("2 px up and right", "↗ 2"),
        ("2 px down and left", "↙ 2"),
        ("2.2 px down and a little right", "↓ 2.2"),
        ("counterclockwise 32°", "↺ 32°"),
        ("rest", ""),
    ],
)
def test_a_way_is_short_as_one_arrow(empty, text, short):
    assert empty.run(f"{source('timeline.js')}; inShort({text!r})") == short


@pytest.mark.parametrize(
    ("answer", "moments"),
    [
        ("No, at 1.92 s and 1.88 s.", "1.92 1.88"),
        ("At 1.4 s, 2 s and 3.25 s.", "1.4 2 3.25"),
        ("It turns from 1.4 to 2.28 s; until 3 s.", "1.4 2.28 3"),
        ("It lasts 1.6 s and 0.2 s, at 2 px.", ""),
    ],
)
def test_each_moment_of_an_answer_is_a_click_away(empty, answer, moments):
    place = f"{source('parts.js')}; var place = withMoments({answer!r}); "
    buttons = "[...place.querySelectorAll('button')].map((one) => one.textContent).join(' ')"
    assert empty.run(f"{place}{buttons}") == moments
    assert empty.run(f"{place}place.textContent") == answer


def test_arrows_too_short_to_be_drawn_are_told_from_those_that_are(empty):
    field = (
        f"{source('draw.js')}; drawField(document.createElement('canvas').getContext('2d'), "
        "[100, 100], [[[0.5, 0.5], [0.51, 0.5]], [[0.1, 0.1], [TIP, 0.1]]], 'red')"
    )
    assert empty.run(field.replace("TIP", "0.2"))
    assert not empty.run(field.replace("TIP", "0.12"))


def test_what_lies_over_a_small_picture_is_written_as_small_as_it_fits(empty):
    written = (
        f"{source('draw.js')}; var context = document.createElement('canvas').getContext('2d'); "
        "drawLegend(context, [WIDTH, 90], [{text: 'motion to scale'}]); "
        "context.measureText('motion to scale').width"
    )
    assert empty.run(written.replace("WIDTH", "90")) <= 90 - 32 + 1
    assert empty.run(written.replace("WIDTH", "300")) > 90


def test_a_link_opens_its_example_and_asks_its_question(empty, address):
    empty.open(f"{address}?example=coin&q=Which%20way%20does%20it%20go%3F")
    assert empty.run(f"{NAME}.innerText") == "coin"
    empty.wait_for(f"{TEXT}.includes('It slides ')")
    empty.click("Details", "button")
    empty.wait_for(f"{TEXT}.includes('app/examples/coin_press.npz')")


def test_a_link_to_what_is_no_example_says_so_and_answers_nothing(empty, address):
    for name in ("no_such", "../../etc/passwd", "<img src=x>"):
        empty.call("Page.navigate", url=f"{address}?example={name}&q=Which%20way%3F")
        empty.wait_for(f"({COMPLAINT} || {{innerText: ''}}).innerText.includes('does not exist')")
        assert empty.run(NOTHING_SHOWN)
        assert "Which way" not in empty.run("document.querySelector('.talk-list').innerText")


def test_the_page_opens_with_a_recording_that_is_asked_about(browser):
    assert browser.run(f"{STAGE}.querySelectorAll('.stage-time .event.turn').length") >= 2
    browser.wait_for("document.querySelectorAll('.exchange .answer').length == 1")
    browser.run("document.querySelector('.stage [data-part=play]').click()")
    result = "document.querySelector('.stage-result').innerText"
    browser.run("document.dispatchEvent(new CustomEvent('seek', {detail: 1.9}))")
    line = r"/^clockwise \d+° .\d+ to \d+°., [0-9.]+ to [0-9.]+\u00a0s$/"
    assert browser.run(f"{line}.test({result})")
    assert browser.run(FRAME) == pytest.approx(1.9 * 25, abs=1)


def test_the_keyboard_comes_to_the_question_in_three_tabs(browser, recordings):
    content = base64.b64encode(recordings["dark"].read_bytes()).decode()
    browser.run(f"{DROP}('dark.npy', '{content}')")  # shown without a click
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'dark.npy'")
    for _ in range(3):
        browser.press("Tab", 9)
        if browser.run("document.activeElement.matches('.question textarea')"):
            break
    assert browser.run("document.activeElement.matches('.question textarea')")
    assert browser.run("getComputedStyle(document.activeElement).outlineStyle") == "solid"


def test_the_timeline_is_zoomed_and_moved_along(browser):
    ticks = (
        "[...document.querySelectorAll('.stage-time .tick[text-anchor=middle]')]"
        ".map(one => Number(one.textContent))"
    )
    whole = browser.run(ticks)
    browser.click("+", ".stage-zoom button")
    part = browser.run(ticks)
    assert max(part) - min(part) < max(whole) - min(whole)
    browser.run("document.querySelector('.stage [data-part=scrub]').focus()")
    browser.press("End", 35)  # the part that is shown follows
    assert browser.run(f"Math.max(...{ticks})") == max(whole)
    bar = "document.querySelector('.stage-time svg .part').getBoundingClientRect()"
    at, last = browser.run(f"[{bar}.x + {bar}.width / 2, {bar}.y + 3]"), max(browser.run(ticks))
    for kind, x in (("mousePressed", at[0]), ("mouseMoved", at[0] - 90), ("mouseReleased", 0)):
        point = {"x": x, "y": at[1], "button": "left", "buttons": 1, "clickCount": 1}
        browser.call("Input.dispatchMouseEvent", type=kind, **point)
    assert max(browser.run(ticks)) < last  # the part was taken hold of, and moved
    browser.click("all", ".stage-zoom button")
    assert browser.run(ticks) == whole


def test_a_long_question_does_not_break_the_page(browser):
    browser.ask("way all " + "which_way" * 150)
    assert browser.run("document.documentElement.scrollWidth <= window.innerWidth")
    assert box(browser, ".question")["bottom"] <= 1100


def test_a_recordings_name_is_shown_and_never_run(browser, recordings, tmp_path):
    name = "${document.title='run'} {{value}} <b>x<b>.npy"
    shutil.copy(recordings["dark"], tmp_path / name)
    browser.upload("Recording", tmp_path / name)
    browser.wait_for(f"{SHOWN} && {NAME}.innerText.includes('.npy')")
    assert browser.run("document.title") != "run"
    assert browser.run(f"{NAME}.children.length") == 0


def test_what_is_dropped_on_the_picture_plays_and_rests_on_what_goes_farthest(browser, tmp_path):
    clip = there_and_back()
    np.savez_compressed(tmp_path / "turn.npz", frames=clip.frames, fps=10 * clip.fps)
    content = base64.b64encode((tmp_path / "turn.npz").read_bytes()).decode()
    browser.run(f"{DROP}('turn.npz', '{content}')")
    browser.wait_for(f"{SHOWN} && {NAME}.innerText == 'turn.npz'")
    browser.wait_for(f"{STAGE}.querySelector('[data-part=play]').innerText == '▶'")
    assert 0 < browser.run(FRAME) < len(clip) - 1
    result = browser.run(f"{STAGE}.querySelector('[data-part=result]').innerText")
    assert result.startswith(("clockwise ", "counterclockwise "))


def test_a_mistake_stands_beside_the_field_and_the_conversation_stays(browser):
    browser.ask("Which way does it go?")
    browser.fill("Question", " ")
    mistake = f"({COMPLAINT} || {{innerText: ''}}).innerText.trim().length > 10"
    browser.click_until("Ask", mistake, "button.primary")
    assert browser.run("document.querySelector('.talk-list').innerText").count("It turns ") == 2
    below = box(browser, ".complaint")["top"] - box(browser, ".question")["bottom"]
    assert 0 <= below < 60


@pytest.fixture
def phone(empty, address):
    """A browser as wide as a phone's that tells of fingers and not of a mouse."""
    browser = empty
    metrics = {"width": 390, "height": 844, "deviceScaleFactor": 2, "mobile": True}
    browser.call("Emulation.setDeviceMetricsOverride", **metrics)
    browser.call("Emulation.setTouchEmulationEnabled", enabled=True, maxTouchPoints=1)
    browser.open(address)
    assert browser.run("navigator.maxTouchPoints") == 1
    return browser


def touch(browser, *places):
    """Put a finger down at the first place, move it over the others, and lift it."""
    for kind, (x, y) in zip(["touchStart"] + ["touchMove"] * len(places), places, strict=False):
        browser.call("Input.dispatchTouchEvent", type=kind, touchPoints=[{"x": x, "y": y}])
    browser.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])


def tap(browser, kind, text):
    """Tap the middle of the first element that is seen of a kind and holds a text."""
    find = (
        f"[...document.querySelectorAll({kind!r})].find("
        f"one => one.offsetParent && one.innerText.includes({text!r}))"
    )
    browser.wait_for(f"Boolean({find})")
    browser.run(f"{find}.scrollIntoView({{block: 'center', inline: 'center'}})")
    place = browser.run(f"{find}.getBoundingClientRect().toJSON()")
    touch(browser, (place["x"] + place["width"] / 2, place["y"] + place["height"] / 2))


def test_a_finger_opens_an_example_asks_and_scrubs(phone, touch_path):
    tap(phone, "button.example", "bead")
    phone.wait_for(f"{SHOWN} && {NAME}.innerText == 'bead'")
    tap(phone, ".chips button", "Which way is it moving?")
    phone.wait_for(f"{CHAT}.innerText.includes('% sure')")
    phone.open_recording(touch_path)
    phone.run(f"{STAGE}.scrollIntoView(); {STAGE}.querySelector('[data-part=play]').click()")
    line = box(phone, ".stage-time svg")
    places = [line["left"] + 64 + share * (line["width"] - 74) for share in (0.2, 0.4, 0.6, 0.75)]
    touch(phone, *((x, line["top"] + 60) for x in places))
    assert phone.run(FRAME) == pytest.approx(0.75 * 39, abs=1)


def test_on_a_phone_the_answer_begins_with_its_question_and_the_picture_is_free(phone):
    phone.wait_for("document.querySelectorAll('.exchange .answer').length == 1")
    for question in ("Which way does it go?", "way all " + "which_way " * 60):
        phone.ask(question)
        below = box(phone, ".exchange:last-child")["top"] - box(phone, ".talk-list")["top"]
        assert 0 <= below < 60
    phone.wait_for("document.querySelector('.stage-result').innerText")
    assert box(phone, ".stage-result")["top"] >= box(phone, ".stage-screen canvas")["bottom"]


def test_a_pixels_size_that_is_given_afterwards_redraws_the_timeline_in_mm(browser, touch_path):
    browser.open_recording(touch_path)
    browser.click("Details", "button")
    panel = f"[...{STAGE}.querySelectorAll('.stage-time .tick')].map(one => one.textContent)"
    assert "px" in browser.run(panel)
    field = (
        "[...document.querySelectorAll('label')].find(one => one.offsetParent && "
        "one.innerText.startsWith('Millimetres')).querySelector('input')"
    )
    # The page takes a number over a moment after it is typed: the field is left until it has.
    leaving = f"{field}.focus() || {field}.blur()"
    for size, unit in (("0.05", "mm"), ("0", "px")):
        browser.fill("Millimetres per pixel", size)
        browser.wait_for(f"{leaving} || {panel}.includes('{unit}')", seconds=60)
    browser.fill("Millimetres per pixel", "60")
    refusal = f"{TEXT}.includes('A pixel of 60 mm was given, expected')"
    browser.wait_for(f"{leaving} || {refusal}", seconds=60)


TABS = ("Ask", "Live", "Simulate")
RUN = """;window.found = null; axe.run(document, {resultTypes: ['violations']}).then(told => {
    window.found = JSON.stringify(told.violations.map(
        one => [one.impact, one.id, one.nodes.map(node => node.html.slice(0, 200))]))}); 1"""


def found_by_axe(browser):
    """Return what is critical or serious of what is seen."""
    axe_core_python = pytest.importorskip("axe_core_python", reason="axe is in the extra dev")
    axe = (Path(axe_core_python.__file__).parent / "axe.min.js").read_text()
    browser.run(axe + RUN)
    browser.wait_for("window.found !== null")
    found = json.loads(browser.run("window.found"))
    return [one for one in found if one[0] in ("critical", "serious")]


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_critical_or_serious(empty, address, theme):
    empty.open(f"{address}?__theme={theme}")
    for tab in TABS:
        empty.click(tab, "button[role=tab]")
        empty.wait_for(
            f"document.querySelector('button[role=tab][aria-selected=true]').innerText == {tab!r}"
        )
        if tab == "Simulate":
            empty.wait_for(f"{SHOWN} && !document.querySelector('.pending')")
        assert found_by_axe(empty) == [], tab
        if tab != "Simulate":
            empty.click("Details", "button[data-part=details]")
            assert found_by_axe(empty) == [], f"{tab} with its details"
            empty.press("Escape", 27)


@pytest.mark.parametrize("theme", ["light", "dark"])
def test_axe_finds_nothing_while_a_recording_is_watched(empty, address, theme, long_recording):
    empty.open(f"{address}?__theme={theme}")
    empty.click("Live", "button[role=tab]")
    empty.upload("Recording", long_recording)
    empty.wait_for("document.body.innerText.includes('long')")
    empty.click("When did it stop?", ".chips button")
    # What it has stopped by then depends on how long the page took to ask.
    answered = "/does not happen in this recording|At [0-9.]+ s\\./.test(document.body.innerText)"
    empty.wait_for(answered)
    # While an answer is being made the toolkit fades what shows its progress.
    empty.wait_for("!document.querySelector('.chips .pending, .chips.pending')")
    assert found_by_axe(empty) == []
    assert empty.run(f"!{STAGE}.querySelector('[data-part=live]').hidden"), "it was over"
