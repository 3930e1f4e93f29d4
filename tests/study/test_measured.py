"""Tables measured elsewhere: what is read of a CSV file, and what is refused with its place."""

import pytest

from sim.base.errors import InputError
from sim.base.measured import MAX_ROWS, read_measured

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


def test_what_is_no_text_or_endless_is_refused(read):
    for text, message in (
        (b"a,b\n\xff,2\n", r"not a text file \(UTF-8 expected\)"),
        ("a\n" + "1\n" * (MAX_ROWS + 1), "more than 10,000 rows"),
    ):
        with pytest.raises(InputError, match=f"exp.csv: {message}$"):
            read(text)


def test_a_file_is_no_link_to_elsewhere_and_has_no_endless_name(tmp_path):
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "exp.csv").write_text(TABLE)
    link = tmp_path / "link.csv"
    link.symlink_to("other/exp.csv")
    with pytest.raises(InputError, match=r"link\.csv: a link to elsewhere; allowed: the name of a"):
        read_measured(link)
    with pytest.raises(InputError, match=r"a\.csv: (cannot be read: File name|no such file)"):
        read_measured(tmp_path / f"{'a' * 300}.csv")
    (tmp_path / "exp.csv").write_text(TABLE)
    link.unlink()
    link.symlink_to("exp.csv")
    assert read_measured(link).texts == read_measured(tmp_path / "exp.csv").texts
