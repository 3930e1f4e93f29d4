"""Tables measured elsewhere: what is read of a CSV file, and what is refused with its place."""

import pytest

from sim.base.errors import InputError
from sim.study.measured import MAX_ROWS, read_measured

TABLE = "# by hand\nangle (deg), V [mm/s], s\n\n16, 200, 5\n 17.5 ,2.5e2,6\n"


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "exp.csv"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return read_measured(path)

    return read


def numbers(table, column, to, **options):
    return table.numbers(column, to, **({"low": -1e9, "high": 1e9} | options))


def test_columns_are_read_in_the_unit_asked_for(read):
    table = read("\ufeff" + TABLE)
    assert list(table.texts) == ["angle", "V", "s"] and table.units["V"] == "mm/s"
    assert numbers(table, "angle", "degree") == (16, 17.5)
    assert numbers(table, "V", "m s-1") == pytest.approx((0.2, 0.25))
    assert numbers(table, "s", "m s-1", unit="mm/s") == pytest.approx((0.005, 0.006))
    assert numbers(table, "s", "m s-1") == (5, 6)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (b"a,b\n\xff,2\n", "not a text file (UTF-8 expected)"),
        ("a\n" + "1\n" * (MAX_ROWS + 1), "more than 10,000 rows"),
    ],
)
def test_what_is_no_text_or_endless_is_refused(read, text, message):
    with pytest.raises(InputError) as caught:
        read(text)
    assert f"exp.csv: {message}" in str(caught.value) and "\n" not in str(caught.value)


def test_a_file_is_no_link_to_elsewhere_and_has_no_endless_name(tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "exp.csv").write_text(TABLE)
    link = tmp_path / "link.csv"
    link.symlink_to("other/exp.csv")
    with pytest.raises(InputError, match=r"link\.csv: a link to elsewhere; allowed: the name of a"):
        read_measured(link)
    with pytest.raises(InputError, match=r"a\.csv: (File name too long|no such file)"):
        read_measured(tmp_path / f"{'a' * 300}.csv")
    (tmp_path / "exp.csv").write_text(TABLE)
    link.unlink()
    link.symlink_to("exp.csv")
    assert read_measured(link).texts == read_measured(tmp_path / "exp.csv").texts


def test_a_file_must_be_there_and_be_a_file(tmp_path):
    for path in (tmp_path / "none.csv", tmp_path):
        with pytest.raises(InputError, match="no such file"):
            read_measured(path)


def test_units_that_are_unknown_contradict_or_are_of_another_kind_are_refused(read):
    table = read(TABLE)
    for column, to, unit, message in [
        ("V", "m", "", "unit of column V: got 'mm/s'; allowed: a unit such as m"),
        ("V", "1", "", "unit of column V: got 'mm/s'; allowed: no unit, as it is a pure number"),
        ("s", "m s-1", "mph", "unit of column s: got 'mph'; allowed: a unit such as m s-1"),
        ("V", "m s-1", "m/s", "unit of column V: got 'm/s'; allowed: mm/s, as in its heading"),
    ]:
        with pytest.raises(InputError) as caught:
            numbers(table, column, to, unit=unit)
        assert message in str(caught.value)


def test_a_missing_column_is_named_with_those_there_are(read):
    with pytest.raises(InputError) as caught:
        read(TABLE).require_column("angel", "a condition")
    message = "column angel: got nothing; did you mean angle? allowed: a column angel, a condition"
    assert message in str(caught.value) and "the file has angle, V, s" in str(caught.value)
