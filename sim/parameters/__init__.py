"""The parameters of all systems: symbol, unit, range, equation and default in one place."""

# ruff: noqa: F401

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
    amounts,
    as_yaml,
    canonical_json,
    canonical_values,
    complete_values,
    covers,
    default_of,
    defaults_of_added,
    field_info,
    hint_on_key,
    load_point,
    parse_point,
    parse_python_point,
    point_id,
    require_compatible_source,
    with_larger_amounts,
)
from sim.parameters.words import in_si
