"""Functions of the extension as functions of Python: with a signature that inspect reads, and with Python's own errors for
wrong arguments, which name the right ones."""

from __future__ import annotations

import __future__

from collections.abc import Callable
from typing import Any

from . import _core


def as_python(function: Any, owner: str = "") -> Callable[..., Any]:
    """A function of Python that calls one of the extension, with its signature and its documentation."""
    text, documentation, defaults = function.__nb_signature__[0]
    for n, default in enumerate(defaults or ()):
        text = text.replace(f"\\{n}", repr(default))
    if "ndarray[dtype" in text:  # no expression of Python
        text = text.partition(" -> ")[0] + " -> numpy.ndarray"
    empty = _defined(f"{text}: ...", {}).__code__
    count = empty.co_argcount
    names = empty.co_varnames[: count + empty.co_kwonlyargcount]
    call = ", ".join(name if n < count else f"{name}={name}" for n, name in enumerate(names))
    made = _defined(f"{text}: return called({call})", {"called": function, "clsdf": _core, "__name__": "clsdf"})
    made.__qualname__ = f"{owner}.{made.__name__}" if owner else made.__name__
    made.__doc__ = documentation
    return made  # type: ignore[no-any-return]


def _defined(source: str, names: dict[str, Any]) -> Any:
    flags = __future__.annotations.compiler_flag
    exec(compile(source, "<clsdf>", "exec", flags, dont_inherit=True), names)
    return names[source[4 : source.index("(")]]


def give(kind: type) -> None:
    """Puts them in the place of the methods of a class of the extension."""
    for name, member in list(vars(kind).items()):
        if name.startswith("_") or not hasattr(member, "__nb_signature__"):
            continue
        is_method = type(member).__name__ == "nb_method"
        made = as_python(member, kind.__name__)
        setattr(kind, name, made if is_method else staticmethod(made))
