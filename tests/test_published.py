"""What is published: its verdicts follow from its dataset, and its flows can be had again."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from docs.site.paper_pages import main as paper_page
from docs.site.paper_pages import published_claims, results_page, verdicts_page
from sim.claims.claim import claims
from sim.claims.evidence import Evidence, readings_of
from sim.claims.judge import judge
from sim.claims.verdict_files import as_mapping
from sim.dataset.gather import read_run
from sim.dataset.replicates import PARAMETERS, outcome
from sim.dataset.results import load_results
from sim.engine.run import run_point
from sim.parameters import SYSTEMS, parse_point, point_id
from sim.report.claims import VERDICTS, count_verdicts, model_checks, read_claims
from sim.report.publish import MOST_BYTES, PUBLISHED, folder_size
from sim.study.load import load_study
from sim.study.model import estimate
from tests.made.processes import ROOT

STUDIES = sorted(path.parent for path in (ROOT / PUBLISHED).glob("*/dataset.nc"))

#: Points of each study that are computed anew, and the longest time (s) that one may take.
SAMPLED, LONGEST = 12, 60.0


def name(folder: Path) -> str:
    return folder.name


def test_what_is_published_is_small():
    assert sum(map(folder_size, STUDIES)) <= MOST_BYTES


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_verdicts_and_their_evidence_follow_from_the_dataset(study, monkeypatch):
    """What judges compute is held here, number by number."""
    # Other readings of the contact law take long to compile.
    monkeypatch.setitem(vars(readings_of("chute")), "model", [{}])
    paper = load_study(study / f"{study.name}.yaml").paper
    again = as_mapping(judge(load_results(study / "dataset.nc"), paper), study.name)["claims"]
    published = read_claims(study / "claims.json", replaceable=False)
    assert [one["id"] for one in again] == [one["id"] for one in published]
    for held, found in zip(published, again, strict=True):
        for key in ("verdict", "part_verdicts"):
            assert held[key] == found[key]
        if held["kind"] == "model":
            # Its numbers are those of a machine.
            continue
        words, numbers = leaves(found)
        assert words == leaves(held)[0] and numbers == pytest.approx(leaves(held)[1], rel=1e-6)


def leaves(value: object) -> tuple[list[object], list[float]]:
    """Return the words, places included, and the numbers in nested lists and mappings."""
    words, numbers = [], []

    def visit(one: object) -> None:
        if isinstance(one, dict | list | tuple):
            words.append([*one] if isinstance(one, dict) else len(one))
            for inner in one.values() if isinstance(one, dict) else one:
                visit(inner)
        else:
            (numbers if isinstance(one, float) else words).append(one)

    visit(value)
    return words, numbers


@pytest.mark.parametrize(
    ("claim_id", "settings"),
    [("W11", {"cell": {10}}), ("W22", {"depth": {20}, "stiffness": {100, 1000}})],
)
def test_the_price_of_a_claim_is_that_of_the_statistic_that_answers_it(claim_id, settings):
    """W11 is a share per cell, and W22 compares two stiffnesses at one depth."""
    results = load_results(ROOT / PUBLISHED / "paper_walton" / "dataset.nc")
    claim = next(claim for claim in claims() if claim.id == claim_id)
    checks = claim.checks_on(Evidence(results, "published"))
    points = {point for check in checks if check.has_vote for point in check.points}
    rows = results.dataset.sel(point=sorted(points))
    for name, values in settings.items():
        assert set(rows[name].values.tolist()) == values


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_the_readme_counts_the_verdicts(study):
    claims = read_claims(study / "claims.json", replaceable=False)
    ((paper, found),) = count_verdicts(claims).items()
    numbers = " | ".join(str(found[verdict]) for verdict in VERDICTS)
    line = f"]({study.relative_to(ROOT)}/report.html) | {numbers} |"
    readme, checks = (ROOT / "README.md").read_text(encoding="utf-8"), model_checks(claims)
    assert line in readme, f"{paper}: {line}"
    words = f"{checks['reproduced']} of {checks['tested']} checks of the model"
    assert not checks["tested"] or words in readme


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_it_is_said_what_happens_instead_of_each_claim_that_does_not_simply_hold(study):
    for claim in read_claims(study / "claims.json", replaceable=False):
        assert bool(claim["instead"]) == (
            claim["verdict"] != "reproduced" or bool(claim["condition"])
        )


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_claims_that_do_not_simply_hold_are_explained(study):
    """Each has a heading or a line of a table in docs/findings.md, or docs/new_paper.md."""
    pages = [ROOT / "docs" / page for page in ("findings.md", "new_paper.md")]
    explained = {name for page in pages for name in re.findall(r"\b[WGS]\d+\b", page.read_text())}
    open_ = {
        claim["id"]
        for claim in read_claims(study / "claims.json", replaceable=False)
        if claim["verdict"] != "reproduced"
        or claim["protocol_dependent"]
        or claim["reading_dependent"]
    }
    assert open_ <= explained, sorted(open_ - explained)


def test_the_page_of_verdicts_has_a_row_for_each_claim():
    """It is made for the site alone."""
    claims = published_claims(ROOT / PUBLISHED)
    rows = re.findall(r"^\| ([WG]\d+) .*\|$", verdicts_page(claims), re.MULTILINE)
    assert rows == [claim["id"] for claim in claims]


def test_every_number_of_the_abstract_is_published():
    """`python -m docs.site.paper_pages > docs/paper.md` makes it anew."""
    text = (ROOT / "docs" / "paper.md").read_text(encoding="utf-8")
    assert text == paper_page(ROOT / PUBLISHED)


#: Sentences of pages with numbers that follow from the datasets, which fill the braces.
SENTENCES = {
    "docs/running.md": (
        "| Walton | {walton.points:,} | {walton.runs:,} | {walton.hours:.1f} | {walton.wall:.1f} |"
        " {walton.days} |",
        "| Gallas, Herrmann and Sokołowski | {gallas.points:,} | {gallas.runs:,} |"
        " {gallas.hours:.1f} | {gallas.wall:.1f} | {gallas.days} |",
    ),
    "docs/physics.md": (
        "Of the {gallas.points:,} published points {gallas.beyond} exceed the bound.",
        "{gallas.lacking} points have a bed whose energy ledger lacks more than 0.5 %, and"
        " {gallas.both} of these exceed the bound.",
        "The other {gallas.other} are within the bound",
    ),
    "docs/findings.md": (
        "the ledgers of {gallas.unsound} points, all of the own mass, lack more than 5 %",
        "Single beds of {gallas.other} further points",
        "Of {walton.fast} fast beds of depths 1.24 to 5 none rests at 2.1 or 2.6 tan θ",
    ),
    "docs/validation.md": ("their ratio is tan θ, to {walton.imbalance:.2f} % in the median",),
    "docs/performance.md": ("Gallas' published dataset ({gallas.points:,} points",),
    "README.md": ("{gallas.fewest} to {gallas.most} beds a point",),
}


@pytest.mark.parametrize("page", SENTENCES)
def test_numbers_on_what_is_published_are_those_of_the_datasets(page):
    text = " ".join((ROOT / page).read_text(encoding="utf-8").split())
    told = {study.name.removeprefix("paper_"): numbers(study) for study in STUDIES}
    for sentence in SENTENCES[page]:
        assert sentence.format(**told) in text, sentence


def numbers(study: Path) -> SimpleNamespace:
    """Return what pages tell of a published study."""
    dataset = load_results(study / "dataset.nc").dataset
    first, last = (dataset.attrs[name][:10] for name in ("first_run", "last_run"))
    found = {
        "points": dataset.sizes["point"],
        "runs": int(dataset["wall_time"].notnull().sum()),
        "hours": float(dataset["loop_time"].sum()) / 3600,
        "wall": float(dataset["wall_time"].sum()) / 3600,
        "days": f"{first} to {last}",
    }
    missing = abs(dataset["missing_energy"])
    if study.name == "paper_walton":
        fast = dataset["friction"].isin([0.65, 0.8]) & (dataset["initial_velocity"] > 1)
        beds = dataset["regime"].where(fast & (dataset["depth"] <= 5), "")
        assert not (beds == "arrested").any()
        found["fast"] = int((beds != "").sum())
        is_steady = (dataset["point_regime"] == "steady") & (dataset["bumps"] == 0)
        ratio = (dataset["base_shear"] / dataset["base_normal"]).mean("replicate")
        deviation = abs(ratio / np.tan(np.radians(dataset["angle"])) - 1)
        found["imbalance"] = 100 * float(deviation.where(is_steady).median())
    if study.name == "paper_gallas":
        beyond = dataset["caveat"].str.contains("beyond the stability")
        lacking = (missing > 0.005).any("replicate")
        unsound = missing.median("replicate") > 0.05
        assert set(dataset["damping_mass"].values[unsound]) == {"own"}
        found |= {"beyond": int(beyond.sum()), "lacking": int(lacking.sum())}
        found |= {"both": int((lacking & beyond).sum()), "other": int((lacking & ~beyond).sum())}
        found["unsound"] = int(unsound.sum())
        beds = pd.read_csv(study / "figures" / "gallas_1a.csv")["completed replicates"]
        found |= {"fewest": beds.min(), "most": beds.max()}
    return SimpleNamespace(**found)


def test_the_abstract_refuses_verdicts_and_numbers_that_it_does_not_know():
    claims = {
        claim["id"]: claim
        for study in STUDIES
        for claim in read_claims(study / "claims.json", replaceable=False)
    }
    runs = {paper: {"points": 1, "runs": 1, "hours": 1.0} for paper in ("walton", "gallas")}
    assert "W9: τ = " in results_page(claims, runs)
    with pytest.raises(ValueError, match="W9 is 'inconclusive' and no more 'reproduced'"):
        results_page(claims | {"W9": claims["W9"] | {"verdict": "inconclusive"}}, runs)
    with pytest.raises(ValueError, match="W25 has 0 checks 'narrowest window"):
        results_page(claims | {"W25": claims["W25"] | {"variants": []}}, runs)


@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_a_verdict_that_changed_or_a_criterion_that_was_restated_has_a_reason(study):
    for claim in read_claims(study / "claims.json", replaceable=False):
        first = claim["first"]
        if first and (first["criterion"] or first["verdict"] != claim["verdict"]):
            assert first["why"], claim["id"]


@pytest.mark.long
@pytest.mark.parametrize("study", STUDIES, ids=name)
def test_flows_computed_anew_from_other_beds_agree(study, tmp_path):
    """Velocities differ by no more than the intervals of both allow."""
    dataset = load_results(study / "dataset.nc").dataset
    steady = np.flatnonzero(dataset["point_regime"].values == "steady")
    deviations = []
    for index in np.random.default_rng(1).permutation(steady):
        row = dataset.isel(point=int(index))
        parameters = anew(row)
        if estimate(parameters).core_seconds > LONGEST or parameters.replicates < 2:
            continue
        path = tmp_path / f"{point_id(parameters)}.nc"
        assert run_point(parameters, path, quiet=True) == 0
        held = read_run(path).values | {name: row[name] for name in PARAMETERS}
        before, after = outcome(row), outcome(held)
        allowed = np.hypot(before["half_width"], after["half_width"])
        deviations.append(abs(after["velocity"] - before["velocity"]) / allowed)
        if len(deviations) == SAMPLED:
            break
    assert len(deviations) >= 4
    assert np.max(deviations) < 2.5 and np.median(deviations) < 1, deviations


def anew(row) -> object:
    """Return the parameters of a point with other initial states."""
    system = str(row["system"].values)
    values = {"system": system}
    for parameter, field in SYSTEMS[system].model_fields.items():
        value = row[parameter].values.item()
        values[parameter] = field.annotation(value) if field.annotation in (int, bool) else value
    return parse_point(values | {"seed": values["seed"] + 1000}, "published")
