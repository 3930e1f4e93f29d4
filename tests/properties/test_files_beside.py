"""Whatever the files beside a study hold, it is a study or an error of one line that names a file.

They are those of a stranger's paper, and measurements.
"""

import re
import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from sim.base.errors import InputError
from sim.claims.claim import claims
from sim.study.figure_spec import FIGURES
from sim.study.load import load_study
from tests.made.plugins import restore_plugins
from tests.made.processes import ROOT
from tests.properties.mutations import TOKENS, mutated_texts, mutated_trees
from tests.properties.values import SCALARS

EXAMPLES = ROOT / "docs" / "examples"
PAPER = {path.name: path.read_text() for path in (EXAMPLES / "silbert").glob("*.yaml")}

#: A study that is calibrated by measurements, and the measurements.
CALIBRATED = """\
study: beads
series:
  - name: wide
    system: chute
    design: {kind: sobol, points: 8, over: {friction: [0.3, 0.8], angle: [14, 18]}}
surrogate: [{name: speed, series: wide}]
calibrate:
  - {name: beads, data: exp.csv, surrogate: speed, parameters: {friction: [0.3, 0.8]}}
"""
MEASURED = """\
# from a laboratory
angle (deg), velocity (mm/s), velocity_error (mm/s), note
14.5, 212, 8, "first, dry"
16.0, 254, 8,
"""

#: What may stand in a YAML file.
PLAIN = SCALARS.filter(lambda one: one is None or isinstance(one, (bool, int, float, str)))
NODES = st.recursive(
    PLAIN, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(PLAIN, inner))
)

#: Each loads a study: fewer with each change.
FEW = settings(max_examples=settings().max_examples // 4)


def load(folder: Path, study: str) -> None:
    """Load a study and what papers say, or be refused in one line that names a file."""
    with restore_plugins():
        try:
            load_study(folder / study, None)
            list(FIGURES)
            claims(["chute"])
        except InputError as error:
            message = str(error)
            assert message.isprintable() and len(message) < 1500
            assert re.search(r"\.(yaml|csv|py): ", message), message


def load_paper(name: str, content: bytes) -> None:
    with TemporaryDirectory() as folder:
        shutil.copy(EXAMPLES / "silbert.yaml", folder)
        shutil.copytree(EXAMPLES / "silbert", Path(folder) / "silbert")
        (Path(folder) / "silbert" / name).write_bytes(content)
        load(Path(folder), "silbert.yaml")


@FEW
@given(st.data())
def test_mutated_texts_of_a_paper(data):
    name = data.draw(st.sampled_from(sorted(PAPER)))
    load_paper(name, data.draw(mutated_texts([PAPER[name]])).encode(errors="surrogatepass"))


@FEW
@given(st.data())
def test_mutated_trees_of_a_paper(data):
    name = data.draw(st.sampled_from(sorted(PAPER)))
    tree = data.draw(mutated_trees([yaml.safe_load(PAPER[name])], NODES, PLAIN))
    load_paper(name, yaml.safe_dump(tree, allow_unicode=True).encode(errors="surrogatepass"))


@FEW
@given(
    st.one_of(
        mutated_texts([MEASURED]).map(str.encode),
        st.lists(st.one_of(TOKENS, st.text(max_size=3))).map(" ".join).map(str.encode),
        st.binary(max_size=50),
    )
)
def test_measurements_of_all_kinds(content):
    with TemporaryDirectory() as folder:
        (Path(folder) / "beads.yaml").write_text(CALIBRATED)
        (Path(folder) / "exp.csv").write_bytes(content)
        load(Path(folder), "beads.yaml")
