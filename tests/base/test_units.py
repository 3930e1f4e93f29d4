"""Units as people write them, and tables measured elsewhere: what is read, what is refused."""

from math import pi

import pytest

from sim.base.errors import InputError
from sim.base.measured import MAX_ROWS, read_measured
from sim.base.messages import conversion


@pytest.mark.parametrize(
    ("unit", "to", "factor"),
    [
        ("mm/s", "m s-1", 1e-3),
        ("cm s^-1", "m s-1", 1e-2),
        ("m·s⁻¹", "m s-1", 1),
        ("g/cm³", "kg m-3", 1e3),
        ("kg/(m s)", "Pa s", 1),
        ("kPa", "Pa", 1e3),
        ("1/s", "Hz", 1),
        ("min", "s", 60),
        ("°", "degree", 1),
        ("rad", "degree", 180 / pi),
        ("%", "1", 0.01),
        ("µm", "m", 1e-6),
        ("N/m", "N m-1", 1),
        ("W m-3", "kg m-1 s-3", 1),
    ],
)
def test_a_unit_makes_so_many_of_another(unit, to, factor):
    assert conversion(unit, to) == pytest.approx(factor, rel=1e-12)


@pytest.mark.parametrize("unit", ["furlong", "m/", "", "kg", "m s", "m^x", "mmin", "/s"])
def test_an_unknown_unit_or_one_of_another_kind_makes_none(unit):
    assert conversion(unit, "m s-1") is None


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
    "text",
    [
        "angle (deg);V (mm/s)\n16;0,2\n17,5;2,5e-1\n",
        "sep=;\r\nangle (deg);V (mm/s)\r\n16;0,2\r\n17,5;0,25\r\n",
        "sep=,\nangle (deg),V (mm/s)\n16,0.2\n17.5,0.25\n",
        "angle (deg)\tV (mm/s)\n16\t0,2\n17,5\t,25\n",
        "angle (deg),V (mm/s),,\n16,0.2,,\n17.5,0.25,,\n,,,\n",
        "angle (deg),V (mm/s)\n16,0.2,\n17.5,0.25,\n",
        "angle (deg),,V (mm/s)\n16,,0.2\n17.5,,0.25\n",
        ",angle (deg),V (mm/s)\n3,16,0.2\n7,17.5,0.25\n",
        "Unnamed: 0,angle (deg),V (mm/s)\n0,16,0.2\n1,17.5,0.25\n",
    ],
)
def test_tables_of_spreadsheets_and_pandas_are_read(read, text):
    table = read(text)
    assert list(table.texts) == ["angle", "V"] and table.units == {"angle": "deg", "V": "mm/s"}
    assert numbers(table, "angle", "degree") == (16, 17.5)
    assert numbers(table, "V", "mm/s") == (0.2, 0.25)


def test_a_comma_is_a_decimal_point_only_where_none_is(read):
    for text in ("a;b\n1,234;1.5\n", 'a,b\n"1,234",1\n'):
        with pytest.raises(InputError, match="line 2, column a: got '1,234'; allowed: a number"):
            numbers(read(text), "a", "1")


def test_what_is_no_text_or_endless_is_refused(read):
    for text, message in (
        (
            b"a,b\n\xff,2\n",
            r"not a text file \(UTF-8 expected\); a spreadsheet saves one as 'CSV UTF-8'",
        ),
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
