"""The modules of the package have an order: each imports only those before it, also within functions."""

from __future__ import annotations

import ast
from graphlib import TopologicalSorter
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "clsdf"


def imports(tree):
    """The modules of the package that code imports, and the imports for types alone."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            yield from ((name, True) for name, _ in imports(node))
        elif isinstance(node, ast.ImportFrom) and node.level == 1:
            yield from ((name, False) for name in ([node.module] if node.module else [one.name for one in node.names]))
        else:
            yield from imports(node)


def test_no_modules_import_each_other():
    trees = {path.stem: ast.parse(path.read_text()) for path in PACKAGE.glob("*.py") if path.stem != "__init__"}
    found = {module: set(imports(tree)) for module, tree in trees.items()}
    assert ("_field", False) in found["_with_fields"]
    TopologicalSorter({module: {name for name, for_types in of if not for_types} for module, of in found.items()}).prepare()
    # Methods of what a transform makes take the transform.
    by_types = {(module, name) for module, of in found.items() for name, for_types in of if for_types}
    assert by_types == {("_field", "_transform"), ("_plan", "_transform")}
