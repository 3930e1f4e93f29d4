"""The parameters of all systems: symbol, unit, range, equation and default in one place."""

from sim.parameters.amounts import amounts, covers, more
from sim.parameters.belt import BeltParameters
from sim.parameters.chute import ChuteParameters
from sim.parameters.common import Parameters, canonical_number
from sim.parameters.conveyor import ConveyorParameters
from sim.parameters.points import (
    AMOUNTS,
    NUMERICAL,
    RUN_FILE,
    SYSTEMS,
    FieldRow,
    as_yaml,
    canonical,
    canonical_json,
    complete,
    default_of,
    field_info,
    load_point,
    parse_point,
    point_id,
    point_in_python,
    require_alike,
    unsaid,
)
from sim.parameters.si import in_si

__all__ = [
    "AMOUNTS",
    "NUMERICAL",
    "RUN_FILE",
    "SYSTEMS",
    "BeltParameters",
    "ChuteParameters",
    "ConveyorParameters",
    "FieldRow",
    "Parameters",
    "amounts",
    "as_yaml",
    "canonical",
    "canonical_json",
    "canonical_number",
    "complete",
    "covers",
    "default_of",
    "field_info",
    "in_si",
    "load_point",
    "more",
    "parse_point",
    "point_id",
    "point_in_python",
    "require_alike",
    "unsaid",
]
