"""The report in a real browser: by keyboard, on a phone, in the dark, in print, without scripts."""

import re
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser, Locator, Page, expect, sync_playwright

from tests.made.report import ANIMATION, make_page
from tests.report.test_page import Page as Source
from tests.report.test_page import make_asking

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome")

pytestmark = pytest.mark.skipif(
    CHROMIUM is None, reason="no chromium or google-chrome installed (apt install chromium)"
)

#: The rules of accessibility, as the npm package axe-core has them.
AXE = Path(__file__).parent / "axe" / "axe.min.js"

PHONE = {"width": 375, "height": 812}

#: Milliseconds after which something that does not happen is given up; a busy machine is slow.
PATIENCE = 300_000
expect.set_options(timeout=PATIENCE)


@pytest.fixture(scope="module")
def report(tmp_path_factory) -> str:
    _, path = make_page(tmp_path_factory.mktemp("made"))
    # Alone in a folder: it must need nothing beside it.
    return path.rename(tmp_path_factory.mktemp("alone") / path.name).as_uri()


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=CHROMIUM, args=["--no-sandbox"], timeout=PATIENCE
        )
        yield browser
        browser.close()


def opened(browser: Browser, **options) -> Page:
    """Return a new window, of a context of its own."""
    context = browser.new_context(**options)
    context.set_default_timeout(PATIENCE)
    return context.new_page()


@pytest.fixture
def page(browser, report) -> Iterator[Page]:
    """Yield the report in a new window; complaints of the page fail the test."""
    page = opened(browser)
    complaints = []
    page.on("console", lambda message: complaints.append(message.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.on("request", lambda request: complaints.append(request.url))
    page.goto(report)
    yield page
    assert [text for text in complaints if not text.startswith((report, "data:"))] == []
    page.context.close()


def shown(page: Page, table: str) -> list[str]:
    """Return the first words of the rows that a table shows, in their order."""
    rows = page.locator(f"#{table} > tbody:not([hidden]) > tr:not([hidden]):not(.evidence)")
    return [text.split()[0] for text in rows.all_inner_texts()]


def press(page: Page, locator: Locator, key: str = "Enter") -> None:
    """Press a key where the keyboard can go."""
    locator.focus()
    expect(locator).to_be_focused()
    page.keyboard.press(key)


def test_pictures_are_drawn_links_lead_somewhere_and_all_has_a_name(page):
    images = page.evaluate(
        """async () => {
          await Promise.all([...document.images].map((image) => image.decode()));
          return [...document.images].map((one) => [one.naturalWidth, one.alt, one.dataset.same]);
        }"""
    )
    assert len(images) == 9
    assert all(width > 0 for width, _, _ in images)
    # The pictures of the first screen are those of the gallery; their links name them.
    assert all(len(alt) > 30 for _, alt, same in images if not same)
    links = page.evaluate(
        "[...document.querySelectorAll('a')].map((link) => link.getAttribute('href'))"
    )
    assert len(links) > 50
    for link in set(links):
        assert link.startswith("data:") or page.evaluate(
            "(id) => document.getElementById(id) !== null", link.removeprefix("#")
        ), link
    unnamed = page.evaluate(
        """() => [...document.querySelectorAll("button, select, input, a, summary, [role=region]")]
          .filter((one) => !(one.textContent.trim() || one.getAttribute("aria-label")
            || one.labels?.length || one.getAttribute("aria-labelledby")))
          .map((one) => one.outerHTML.slice(0, 80))"""
    )
    assert unnamed == []
    assert page.locator("table:not(:has(> caption))").count() == 0
    assert page.locator("th:not([scope])").count() == 0
    identifiers = page.evaluate("[...document.querySelectorAll('[id]')].map((one) => one.id)")
    assert len(identifiers) == len(set(identifiers))
    for landmark in ("header", "nav", "main", "footer"):
        assert page.locator(landmark).count() == 1
    # The first stop of the keyboard skips to the content.
    page.keyboard.press("Tab")
    expect(page.locator(".skip")).to_be_focused()
    page.keyboard.press("Enter")
    expect(page.locator("main")).to_be_focused()


@pytest.fixture(scope="module", params=[make_page, make_asking], ids=["paper", "own"])
def each(request, tmp_path_factory) -> Path:
    """Yield the report of a paper's study and that of one's own."""
    return request.param(tmp_path_factory.mktemp("each"))[1]


def test_a_browser_repairs_nothing_and_pictures_and_links_have_addresses(browser, each):
    text = each.read_text(encoding="utf-8")
    page, source = opened(browser), Source(text)
    parsed = page.evaluate(
        "(text) => [...new DOMParser().parseFromString(text, 'text/html').querySelectorAll('*')]"
        ".map((one) => one.localName)",
        text,
    )
    assert [name for name, _ in source.elements] == parsed
    assert all("href" in one for one in source.all("a"))
    assert all("src" in one and "alt" in one for one in source.all("img"))
    page.context.close()


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_a_report_is_accessible_with_all_opened(browser, each, scheme):
    page = opened(browser, color_scheme=scheme)
    page.goto(each.as_uri())
    opened_explorer(page)
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
    page.evaluate("for (const one of document.querySelectorAll('.opener')) one.click()")
    page.evaluate(AXE.read_text(encoding="utf-8"))
    found = page.evaluate("axe.run()")
    assert len(found["passes"]) > 30
    faults = [(one["id"], [node["html"] for node in one["nodes"]]) for one in found["violations"]]
    assert faults == []
    page.context.close()


def test_claims_open_their_evidence_by_keyboard(page):
    opener = page.locator("#claim-W9 .opener")
    evidence = page.locator("#evidence-W9")
    expect(evidence).to_be_hidden()
    press(page, opener)
    expect(opener).to_have_attribute("aria-expanded", "true")
    expect(evidence).to_be_visible()
    expect(evidence).to_contain_text("0.910 ± 0.020")
    expect(evidence).to_contain_text("the criterion & its <limits>")
    press(page, opener, "Space")
    expect(evidence).to_be_hidden()
    press(page, page.locator("[data-toggle-all]"))
    assert page.locator("tr.evidence:visible").count() == 7


def test_claims_are_filtered(page, report):
    assert shown(page, "claims-table") == ["W1", "W9", "G3", "G4", "G6", "G13", "W21"]
    expect(page.locator("#claims output")).to_have_text("7 of 8 shown")
    expect(page.locator("#claims select[name=verdict]")).to_have_value("tested")
    press(page, page.locator("#claims p a[data-filter]"))
    assert shown(page, "claims-table") == ["G31"]
    for name, value, left in [
        ("paper", "walton", ["W1", "W9", "W21"]),
        ("depends", "protocol", ["W9"]),
        ("depends", "reading", ["G4"]),
        ("depends", "nothing", ["W1", "G3", "G6", "G13", "W21", "G31"]),
        ("verdict", "reproduced in part", ["W21"]),
        ("verdict", "paper inconsistent", ["G6"]),
    ]:
        press(page, page.locator("#claims button[type=reset]"))
        expect(page.locator("#claims output")).to_have_text("8 of 8 shown")
        page.locator(f"#claims select[name={name}]").select_option(value)
        assert shown(page, "claims-table") == left
    press(page, page.locator("#claims button[type=reset]"))
    page.locator("#claims").get_by_label("Search").focus()
    page.keyboard.type("no obstacle")
    assert shown(page, "claims-table") == ["G31"]
    # So does a link, and a number of the summary lists its claims.
    page.goto("about:blank")
    page.goto(f"{report}#claim-G31")
    expect(page.locator("#claim-G31")).to_be_visible()
    expect(page.locator("#evidence-G31")).to_be_visible()
    press(page, page.locator("#summary td a").first)
    assert shown(page, "claims-table") == ["W1"]
    expect(page.locator("#claims select[name=paper]")).to_have_value("walton")


def test_claims_and_runs_are_sorted_by_keyboard_runs_as_numbers_with_the_unknown_last(page):
    page.locator("#claims button[type=reset]").click()
    expect(page.locator("#claims output")).to_have_text("8 of 8 shown")
    header = page.locator("#claims-table th[aria-sort]", has_text="Verdict")
    press(page, header.locator("button"))
    expect(header).to_have_attribute("aria-sort", "ascending")
    assert shown(page, "claims-table") == ["W1", "W21", "G13", "G4", "W9", "G6", "G3", "G31"]
    press(page, header.locator("button"))
    expect(header).to_have_attribute("aria-sort", "descending")
    assert shown(page, "claims-table") == ["G31", "G3", "G6", "W9", "G4", "G13", "W21", "W1"]
    assert page.locator("#claims-table [aria-sort=descending]").count() == 1
    header = page.locator("#runs-table th[aria-sort]", has_text="Velocity")
    for direction in ("ascending", "descending"):
        press(page, header.locator("button"))
        expect(header).to_have_attribute("aria-sort", direction)
        place = header.evaluate("(one) => one.cellIndex + 1")
        cells = page.locator(f"#runs-table tbody td:nth-child({place})").all_inner_texts()
        values = [float(text.split()[0]) for text in cells if text != "–"]
        assert cells[-1] == "–"
        assert values == sorted(values, reverse=direction == "descending")


def test_a_link_to_a_run_shows_it_whatever_is_filtered(page):
    page.locator("#runs select[name=series]").select_option("rough")
    assert page.locator("#runs-table tbody tr:visible").count() == 4
    page.locator("#runs select[name=series]").select_option("")
    page.locator("#runs select[name=regime]").select_option("failed")
    expect(page.locator("#runs output")).to_have_text(re.compile(r"^1 of \d+ shown$"))
    press(page, page.locator("#claim-W9 .opener"))
    link = page.locator("#evidence-W9 .links a").first
    number = page.locator(f"[id='{link.get_attribute('href').removeprefix('#')}']")
    row = number.locator("xpath=..")
    expect(row).to_be_hidden()
    press(page, link)
    expect(row).to_be_in_viewport()
    expect(row).to_be_focused()


def test_figures_open_from_claims_lead_back_and_are_downloaded(page, tmp_path):
    figure = page.locator("#figure-walton_2")
    press(page, page.locator("#claim-W9 .opener"))
    press(page, page.locator("#evidence-W9 a", has_text="Fig. 2"))
    expect(figure).to_have_attribute("open", "")
    expect(figure.locator(".caption")).to_be_visible()
    press(page, page.locator("#claim-W9 .opener"))
    press(page, figure.locator("a", has_text="W9"))
    expect(page.locator("#evidence-W9")).to_be_visible()
    expect(page.locator("#evidence-G3")).to_be_hidden()
    for text, name in (("SVG", "walton_2.svg"), ("CSV", "walton_2.csv")):
        with page.expect_download() as download:
            page.locator("#figure-walton_2 a", has_text=text).click()
        assert download.value.suggested_filename == name
        download.value.save_as(tmp_path / name)
    assert "<svg" in (tmp_path / "walton_2.svg").read_text()
    assert (tmp_path / "walton_2.csv").read_text().startswith("point,")


def test_an_animation_plays_and_stops(page):
    figure = page.locator(f"#figure-{ANIMATION}")
    press(page, figure.locator("summary"))
    picture, button = figure.locator("img"), figure.locator("button")
    expect(picture).to_have_attribute("src", re.compile("^data:image/png"))
    press(page, button)
    expect(picture).to_have_attribute("src", re.compile("^data:image/gif"))
    expect(button).to_have_attribute("aria-pressed", "true")
    press(page, button)
    expect(picture).to_have_attribute("src", re.compile("^data:image/png"))


def test_nothing_is_wider_than_a_phone(browser, report):
    page = opened(browser, viewport=PHONE)
    page.goto(report)
    page.locator("[data-toggle-all]").click()
    page.evaluate("for (const one of document.querySelectorAll('details')) one.open = true")
    assert page.evaluate("document.documentElement.scrollWidth") <= PHONE["width"]
    tables = page.evaluate(
        "[...document.querySelectorAll('table')].filter((one) => !one.closest('.scroll'))"
        ".map((one) => one.scrollWidth)"
    )
    assert tables and all(width <= PHONE["width"] for width in tables)
    ends = page.locator("#claims-table > tbody > tr:first-child .verdict > .badge").evaluate_all(
        "(all) => all.map((one) => one.getBoundingClientRect().right)"
    )
    assert len(ends) == 8 and max(ends) <= PHONE["width"]
    page.locator("#claims select[name=paper]").select_option("gallas")
    assert page.locator(".opener:visible").count() == 4
    page.context.close()


def colours(page: Page) -> tuple[int, int]:
    """Return how bright the page and its text are, 0 to 765."""
    found = page.evaluate(
        "[getComputedStyle(document.body).backgroundColor, getComputedStyle(document.body).color]"
    )
    return tuple(sum(map(int, re.findall(r"\d+", one)[:3])) for one in found)


@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_colours_follow_the_system_until_chosen(browser, report, scheme):
    page = opened(browser, color_scheme=scheme)
    page.goto(report)
    ground, text = colours(page)
    assert (ground > 600 and text < 200) if scheme == "light" else (ground < 150 and text > 500)
    button = page.get_by_role("button", name="Theme")
    button.click()
    assert colours(page)[0] > 600
    button.click()
    page.reload()
    assert colours(page)[0] < 150
    page.context.close()


def opened_explorer(page: Page) -> Locator:
    """Scroll to the explorer, which draws when it is first seen; return its section."""
    section = page.locator("#explore")
    section.scroll_into_view_if_needed()
    expect(section.locator("canvas")).to_be_visible()
    return section


def marks(page: Page) -> int:
    """Return the number of pixels of the explorer's picture that are not background."""
    return page.locator("#explorer-picture canvas").evaluate(
        """(one) => one.getContext("2d").getImageData(0, 0, one.width, one.height).data
          .reduce((count, value, index) => count + (index % 4 === 3 && value > 0), 0)"""
    )


def test_the_explorer_draws_what_is_chosen_and_keeps_it_in_the_address(page, report):
    section = opened_explorer(page)
    assert marks(page) > 1000
    section.locator("select[name=system]").select_option("belt")
    section.locator("select[name=x]").select_option("frequency")
    section.locator("summary").click()
    section.locator("select[name='is.regime']").select_option("steady")
    expect(section.locator("output")).to_have_text(re.compile(r"^\d+ of \d+ points$"))
    shown_points, total = map(int, re.findall(r"\d+", section.locator("output").inner_text()))
    assert 0 < shown_points < total
    page.wait_for_function("location.hash.includes('is.regime=steady')")
    address = page.url
    page.goto("about:blank")
    page.goto(address)
    section = page.locator("#explore")
    expect(section.locator("select[name='is.regime']")).to_have_value("steady")
    expect(section.locator("output")).to_have_text(f"{shown_points} of {total} points")
    # Unknown names leave the usual choice.
    for words in ("x=nonsense&y=velocity&is.nonsense=1&system=moon", "item=1", "%E0%A4=1"):
        page.goto("about:blank")
        page.goto(f"{report}#explore?{words}")
        section = opened_explorer(page)
        expect(section.locator("select[name=y]")).to_have_value("velocity")
        expect(section.locator("select[name=x]")).not_to_have_value("")


def drawn(section: Locator, folder: Path) -> str:
    """Return the picture of the explorer as SVG."""
    with section.page.expect_download() as download:
        section.locator("[data-save=svg]").click()
    download.value.save_as(folder / "picture.svg")
    return (folder / "picture.svg").read_text()


def test_the_explorer_shows_a_surrogate_saves_and_colours(page, tmp_path):
    section = opened_explorer(page)
    section.locator("select[name=system]").select_option("chute")
    section.locator("select[name=x]").select_option("friction")
    note = section.locator("[data-notes]")
    expect(note).to_have_text(re.compile("surrogate speed and its 95 % interval .*Held: n = 6"))
    assert all(f"mark-{one}" in drawn(section, tmp_path) for one in ("area", "line"))
    section.locator("[name=logy]").check()
    assert "mark-area" in drawn(section, tmp_path)
    section.locator("select[name=panels]").select_option("regime")
    expect(note).to_have_text("")
    assert "mark-area" not in drawn(section, tmp_path)
    for kind, start in (("png", b"\x89PNG"), ("csv", b"friction")):
        with page.expect_download() as download:
            section.locator(f"[data-save={kind}]").click()
        download.value.save_as(tmp_path / kind)
        assert start in (tmp_path / kind).read_bytes()[:3000]
    lines = (tmp_path / "csv").read_text().splitlines()
    assert len(lines) == 1 + int(section.locator("output").inner_text().split()[0])
    # Few values have distinct colours, and steady marks are filled.
    section.locator("select[name=panels]").select_option("")
    section.locator("select[name=system]").select_option("belt")
    section.locator("select[name=colour]").select_option("vibration_angle")
    picture = drawn(section, tmp_path)
    assert "role-legend-symbol" in picture and "role-legend-gradient" not in picture
    marks = re.findall(
        r'regime: (\w+)[^"]*" .*?="point" .*? fill="([^"]+)" stroke="([^"]+)"', picture
    )
    assert {regime for regime, _, _ in marks} > {"steady"}
    assert all((fill == line) == (regime == "steady") for regime, fill, line in marks)
    assert len({line for _, _, line in marks}) == 3


def test_a_click_on_a_mark_leads_to_its_row(page):
    section = opened_explorer(page)
    section.locator("select[name=system]").select_option("belt")
    section.locator("summary").click()
    section.locator("select[name='is.regime']").select_option("steady")
    expect(section.locator("output")).to_have_text(re.compile("points$"))
    canvas = section.locator("canvas")
    box = canvas.bounding_box()
    # The marks are coloured: go over the picture until one is hit.
    hit = canvas.evaluate(
        """(one) => {
          const [w, h] = [one.width, one.height];
          const data = one.getContext("2d").getImageData(0, 0, w, h).data;
          for (let y = 2; y < h - 2; y++) for (let x = 60; x < w - 160; x++) {
            const i = 4 * (y * w + x);
            const spread = Math.max(...data.slice(i, i + 3)) - Math.min(...data.slice(i, i + 3));
            if (data[i + 3] > 200 && spread > 60) return [x / w, y / h];
          }
          return null;
        }"""
    )
    page.mouse.click(box["x"] + hit[0] * box["width"], box["y"] + hit[1] * box["height"] + 1)
    page.wait_for_function("location.hash.startsWith('#run-')")
    expect(page.locator("#runs-table tr:focus")).to_be_visible()


def test_print_is_short_until_evidence_is_asked_for(page, tmp_path):
    page.emulate_media(media="print", color_scheme="dark")
    hidden = ["#runs", "#evidence-W9", "#figure-gallas_1a .caption", "nav", "#claims form"]
    for selector in hidden:
        expect(page.locator(selector)).to_be_hidden()
    assert colours(page)[0] > 600
    page.emulate_media(media="screen")
    page.locator("#print-all").check()
    page.emulate_media(media="print", color_scheme="dark")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    for selector in ("#runs-table", "#evidence-W9", "#figure-gallas_1a .caption"):
        expect(page.locator(selector)).to_be_visible()
    expect(page.locator("#reproduce pre").last).to_be_visible()
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(media="screen")
    expect(page.locator("#evidence-W9")).to_be_hidden()
    expect(page.locator("#figure-gallas_1a .caption")).to_be_hidden()
    page.pdf(path=tmp_path / "report.pdf", prefer_css_page_size=True)
    pages = re.findall(rb"/Type\s*/Page\b", (tmp_path / "report.pdf").read_bytes())
    assert len(pages) > 3
    assert page.locator("details.figure[open]").count() == 0


def test_without_scripts_nothing_is_out_of_reach(browser, report):
    page = opened(browser, java_script_enabled=False)
    page.goto(report)
    expect(page.locator("#evidence-W9")).to_be_visible()
    expect(page.locator("#claim-G31")).to_be_visible()
    expect(page.locator("#runs-table tbody tr").first).to_be_visible()
    expect(page.locator("#claims form")).to_be_hidden()
    expect(page.locator("#picture-walton_2")).to_be_visible()
    page.context.close()
