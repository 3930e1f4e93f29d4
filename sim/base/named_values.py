"""The type of objects that give values by name."""

from typing import Any, Protocol


class NamedValues(Protocol):
    """A mapping, a dataset, a place of a claim: any object with values by name."""

    def __getitem__(self, name: str, /) -> Any: ...
