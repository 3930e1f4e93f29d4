"""Values by name, whatever holds them."""

from typing import Any, Protocol


class Named(Protocol):
    """A mapping, a dataset, a place of a claim: anything that gives values by their names."""

    def __getitem__(self, name: str, /) -> Any: ...
