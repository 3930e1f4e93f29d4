"""An entry under ``plots`` of a study file: which observable is drawn against which parameters."""

from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, BeforeValidator, Field, WithJsonSchema, model_validator

from sim.base.additions import NAME as PLUGGED
from sim.parameters.common import Real, broken_rule
from sim.study.catalogue import FIGURES
from sim.study.entries import ALLOWED_NAME, NAME, Strict, optional, require_shown
from sim.study.plot_beside import LARGEST, MOST_BESIDE, BesideFile
from sim.study.plot_kinds import KINDS, like, own_plots
from sim.study.plottable import every_name


def _known(kind: str) -> str:
    known = [*KINDS, *own_plots()]
    if kind not in known:
        raise broken_rule("", kind, "one of " + ", ".join(known))
    return kind


#: One of `KINDS`, or of a plug-in.
Kind = Annotated[
    str,
    AfterValidator(_known),
    WithJsonSchema({"anyOf": [{"enum": list(KINDS)}, {"type": "string", "pattern": PLUGGED}]}),
]

#: What the colour of a map may be besides an observable.
REGIME = "regime"

#: The key of the observable of each kind of plot, and what it is if not given.
OBSERVABLE: dict[str, tuple[str, str]] = {
    "curves": ("y", "velocity"),
    "map": ("colour", REGIME),
    "profiles": ("x", "velocity"),
    "time_series": ("y", "velocity"),
    "distribution": ("y", "velocity"),
}

#: The key of a second observable of the kinds that can show one against another.
SECOND = {"curves": "x", "profiles": "y"}

#: Kinds that have a place for data beside.
_TAKE_BESIDE = ("curves", "profiles", "map")

#: What is allowed as heights to show slices between.
_BETWEEN = "two heights in diameters, 0 or more, the lower one first"

#: Keys of the parameters that stand on the axes of each kind, and what to know of keys it lacks.
AXES: dict[str, tuple[str, ...]] = {
    "curves": ("x",),
    "map": ("x", "y"),
    "profiles": (),
    "time_series": (),
    "distribution": ("x",),
}
_LACKING = {
    ("map", "curves"): "no curves on a map; panels tell further parameters apart",
    ("time_series", "x"): "nothing: x is the time",
}

#: Axes that each kind of plot can make logarithmic.
_LOG: dict[str, tuple[str, ...]] = {
    "curves": ("x", "y"),
    "map": ("x", "y", "colour"),
    "profiles": ("x",),
    "time_series": ("x", "y"),
    "distribution": ("y",),
}


def _listed(value: Any) -> Any:
    return [value] if isinstance(value, str) else value


#: A name, or a list of names.
Names = Annotated[
    list[str],
    BeforeValidator(_listed),
    WithJsonSchema({"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}),
]

_ANY = {"examples": every_name()}


class PlotFile(Strict):
    """A plot of the points of a study."""

    name: str = Field(
        pattern=NAME,
        max_length=60,
        description="name of the plot and of its files, unique in the study and none of the "
        "catalogue's",
        json_schema_extra=ALLOWED_NAME,
    )
    kind: Kind = Field(
        "curves",
        description="`curves` of a number with intervals; `map` over two parameters; `profiles` "
        "over the height; `time_series`; `distribution` of the replicates; or one of a plug-in",
    )
    system: Literal["chute", "belt", "conveyor"] = optional(
        "which system, where the series have several"
    )
    title: str = Field("", description="one line (omitted: made from what is shown)")
    x: str = optional(
        "parameter on the horizontal axis, of `curves` also another observable; of `profiles` the "
        "observable (velocity)",
        json_schema=_ANY,
    )
    y: str = optional(
        "observable on the vertical axis (velocity); of a `map` a parameter; of `profiles` an "
        "observable over the height, in each slice shown against x (omitted: the height itself)",
        json_schema=_ANY,
    )
    colour: str = optional(
        "of a `map`: observable that the colour shows, or `regime` (omitted)", json_schema=_ANY
    )
    curves: Names = optional(
        "parameter, or list of them, that tells curves apart",
        json_schema={"allowed": "a name, or a list of names"},
    )
    panels: str = optional(
        "parameter that tells panels apart", json_schema={"allowed": "the name of one parameter"}
    )
    series: list[str] = optional(
        "series whose points are drawn (omitted: all of the system)", min_length=1
    )
    units: Literal["si", "natural"] = Field(
        "si",
        description="units of what is observed: `si`, or `natural` ones of diameter, mass and "
        "gravity; parameters are as in study files",
    )
    between: list[Real] = optional(
        "of `profiles`: heights above the base between which slices are shown, in diameters",
        json_schema={"allowed": _BETWEEN},
        min_length=2,
        max_length=2,
    )
    beside: list[BesideFile] = optional(
        "data that are not of the study, drawn beside it: of `curves`, `profiles` and `map`",
        min_length=1,
        max_length=MOST_BESIDE,
        json_schema={"allowed": f"a list of at most {MOST_BESIDE} mappings with label and points"},
    )
    log: list[Literal["x", "y", "colour"]] = Field(
        [],
        description="axes that are logarithmic",
        json_schema_extra={"allowed": "a list of 'x', 'y' or 'colour'"},
    )

    @model_validator(mode="after")
    def _of_a_name_of_its_own(self) -> Self:
        if self.name.lower() in FIGURES:
            raise broken_rule("name", self.name, "a name that no figure of the catalogue has")
        require_shown(self.title)
        return self

    @model_validator(mode="after")
    def _with_the_keys_of_its_kind(self) -> Self:
        observed, _ = OBSERVABLE[self.like]
        has = {observed, self.second, "panels", *AXES[self.like]}
        has |= set() if self.like == "map" else {"curves"}
        for key in ("x", "y", "colour", "curves", "panels"):
            value = getattr(self, key)
            if value is not None and key not in has:
                allowed = _LACKING.get((self.like, key), f"{key} of a map alone")
                raise broken_rule(key, value, allowed)
            if value is None and key in AXES[self.like]:
                other = ", or an observable" if SECOND.get(self.like) == key else ""
                raise broken_rule(key, value, f"a parameter that the points vary{other}")
        for number, axis in enumerate(self.log):
            known = _LOG[self.like] + (("y",) if self.like == "profiles" and self.y else ())
            if self.like == "map" and self.observable == REGIME:
                known = ("x", "y")
            if axis not in known:
                allowed = "one of " + ", ".join(known)
                raise broken_rule(f"log[{number}]", axis, allowed)
        return self

    @model_validator(mode="after")
    def _with_heights_of_profiles(self) -> Self:
        if self.between is None:
            return self
        if self.like != "profiles":
            raise broken_rule("between", self.between, "between of profiles alone")
        low, high = self.between
        if not 0 <= low < high:
            raise broken_rule("between", self.between, _BETWEEN)
        return self

    @model_validator(mode="after")
    def _with_data_beside_that_have_a_place(self) -> Self:
        labels: set[str] = set()
        for number, one in enumerate(self.beside or []):
            if self.kind not in _TAKE_BESIDE:
                allowed = f"no data beside, which are of {', '.join(_TAKE_BESIDE)} alone"
                raise broken_rule("beside", one.label, allowed)
            if one.label in labels:
                raise broken_rule(f"beside[{number}].label", one.label, "a label of its own")
            labels.add(one.label)
            for place, point in enumerate(one.points):
                low = [axis for axis, at in zip("xy", point, strict=True) if at < 1 / LARGEST]
                if axes := [axis for axis in low if axis in self.log]:
                    allowed = f"numbers >= {1 / LARGEST:g} on the logarithmic axis {axes[0]}"
                    raise broken_rule(f"beside[{number}].points[{place}]", point, allowed)
        return self

    @property
    def like(self) -> str:
        """Kind of Talus whose keys it takes."""
        return like(self.kind)

    @property
    def observable(self) -> str:
        """Name of what is shown."""
        key, usual = OBSERVABLE[self.like]
        return getattr(self, key) or usual

    @property
    def second(self) -> str:
        """Key of a second observable, empty where the kind shows none."""
        return SECOND.get(self.like, "")

    @property
    def on_axes(self) -> tuple[str, ...]:
        """What stands on the axes where a parameter may: parameters, unless it is ``second``."""
        return tuple(getattr(self, key) for key in AXES[self.like])
