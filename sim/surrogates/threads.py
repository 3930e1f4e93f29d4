"""Linear algebra of surrogates on one thread.

Their matrices are small: the threads of BLAS wait for each other longer than they compute (twelve
times the processor time with two threads on two busy cores).
"""

from collections.abc import Callable
from functools import cache, wraps
from typing import Any, TypeVar

Function = TypeVar("Function", bound=Callable[..., Any])


def on_one_thread(function: Function) -> Function:
    """Return a function during which BLAS computes on one thread."""

    @wraps(function)
    def call(*args: Any, **options: Any) -> Any:
        with _controller().limit(limits=1, user_api="blas"):
            return function(*args, **options)

    return call  # type: ignore[return-value]


@cache
def _controller() -> Any:
    """Return the controller of the threads of BLAS, once scikit-learn has loaded it."""
    import sklearn.gaussian_process  # noqa: F401  # it loads them
    from threadpoolctl import ThreadpoolController

    return ThreadpoolController()
