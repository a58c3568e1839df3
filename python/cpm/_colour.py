"""colour-science, imported when it is first needed: it takes a second."""
from __future__ import annotations

import warnings
from functools import cache
from typing import Any


@cache
def colour_science() -> Any:
    """The module ``colour``, without its advice to install SciPy and others for what is not used here."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        import colour
    return colour
