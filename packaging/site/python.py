"""The page of the Python package, from its docstrings. Nothing is imported or built."""

import ast
import pathlib
import re

import cpp


def text_of(docstring):
    """A docstring as Markdown: indented parts of it are code."""
    parts = []
    for paragraph in (docstring or "").split("\n\n"):
        is_code = paragraph.startswith("    ")
        if is_code and parts and parts[-1].startswith("```"):
            parts[-1] = parts[-1].removesuffix("\n```") + "\n\n" + "\n".join(line[4:] for line in paragraph.split("\n")) + "\n```"
        elif is_code:
            parts.append("```python\n" + "\n".join(line[4:] for line in paragraph.split("\n")) + "\n```")
        elif re.match(r"[a-z_, ]+: ", paragraph) and "\n" in paragraph:
            parts.append(options_of(paragraph))
        else:
            parts.append(cpp.escaped(paragraph))
    return "\n\n".join(parts)


def options_of(paragraph):
    """Lines "name: meaning" become a list; lines that are indented, or name nothing, go on."""
    items = []
    for line in paragraph.split("\n"):
        if re.match(r"[a-z_]+(, [a-z_]+)*: ", line) or not items:
            name, _, meaning = line.partition(": ")
            items.append(f"- `{name}`: {cpp.escaped(meaning)}")
        else:
            items[-1] += " " + cpp.escaped(line.strip())
    return "\n".join(items)


def signature_of(node, name):
    """The arguments as they are written, each on a line if they are many."""
    arguments = ast.unparse(node.args).removeprefix("self, ").removeprefix("cls, ")
    arguments = "" if arguments in ("self", "cls") else arguments
    returns = f" -> {ast.unparse(node.returns)}" if node.returns else ""
    line = f"{name}({arguments}){returns}"
    if len(line) <= 100:
        return line
    parts, depth, part = [], 0, ""
    for letter in arguments:
        depth += (letter in "([{") - (letter in ")]}")
        if letter == "," and depth == 0:
            parts.append(part.strip())
            part = ""
        else:
            part += letter
    parts.append(part.strip())
    return f"{name}(\n    " + ",\n    ".join(parts) + f",\n){returns}"


def is_property(node):
    return any(ast.unparse(d).endswith(("property", ".getter")) for d in node.decorator_list)


def is_setter(node):
    return any(ast.unparse(d).endswith(".setter") or ast.unparse(d) == "overload" for d in node.decorator_list)


def comments_of(lines, node):
    """The text of #: above or beside a value."""
    beside = lines[node.end_lineno - 1].partition("#: ")[2]
    above, at = [], node.lineno - 2
    while at >= 0 and lines[at].strip().startswith("#: "):
        above.insert(0, lines[at].strip()[3:])
        at -= 1
    return cpp.escaped(" ".join(above) or beside)


def section_of_function(node, shown, level):
    kind = ast.unparse(node.returns) if is_property(node) and node.returns else None
    code = shown + (f": {kind}" if kind else "") if is_property(node) else signature_of(node, shown)
    parts = ["#" * level + f" `{shown}`", cpp.code_block("python", [code]), text_of(ast.get_docstring(node))]
    return "\n\n".join(filter(None, parts))


def section_of_class(node, lines):
    bases = [ast.unparse(base) for base in node.bases]
    parts = [f"## `{node.name}`"]
    made = next((n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"), None)
    head = signature_of(made, f"clsdf.{node.name}").removesuffix(" -> None") if made else f"class clsdf.{node.name}({', '.join(bases)})"
    parts += [cpp.code_block("python", [head.replace("()", "") if not bases and not made else head]), text_of(ast.get_docstring(node))]
    if made and ast.get_docstring(made):
        parts.append(text_of(ast.get_docstring(made)))
    values = []
    for n in node.body:
        target = n.target if isinstance(n, ast.AnnAssign) else n.targets[0] if isinstance(n, ast.Assign) else None
        if isinstance(target, ast.Name) and not target.id.startswith("_"):
            values.append((ast.unparse(n), comments_of(lines, n)))
    if values:
        parts.append(cpp.table(values))
    for n in node.body:
        if isinstance(n, ast.FunctionDef) and not n.name.startswith("_") and not is_setter(n):
            parts.append(section_of_function(n, f"{node.name}.{n.name}", 3))
    return "\n\n".join(filter(None, parts))


def page(package, stub):
    """`stub`: the types of the compiled part, which a build makes; None without one."""
    files = {path.stem: path for path in sorted(package.glob("*.py"))}
    if stub:
        files["_core"] = stub
    trees = {name: ast.parse(path.read_text()) for name, path in files.items()}
    package_tree = trees["__init__"]
    names = next(ast.literal_eval(n.value) for n in package_tree.body if isinstance(n, ast.Assign) and n.targets[0].id == "__all__")
    home = {alias.asname or alias.name: n.module for n in ast.walk(package_tree) if isinstance(n, ast.ImportFrom) for alias in n.names}
    parts = ["# Python's package", text_of(ast.get_docstring(package_tree))]
    compiled = []
    for name in sorted(names, key=lambda n: (n != "Transform", n.islower(), n)):
        module = home.get(name)
        if module is None or module not in trees:
            if module == "_core":
                compiled.append(name)
            continue
        lines = pathlib.Path(files[module]).read_text().split("\n")
        found = [n for n in trees[module].body if getattr(n, "name", None) == name]
        if not found:
            continue
        if isinstance(found[-1], ast.ClassDef):
            parts.append(section_of_class(found[-1], lines))
        else:
            parts.append(section_of_function(found[-1], f"clsdf.{name}", 2))
    if compiled:
        listed = ", ".join(f"`{name}`" for name in compiled)
        parts.append(f"## The compiled part\n\n{listed}: see [the page of Python](../docs/python.md), or `help()` in Python.")
    for name in ("torch", "jax", "trimesh"):
        parts += [f"## `clsdf.{name}`", text_of(ast.get_docstring(trees[name]))]
        for n in trees[name].body:
            if isinstance(n, ast.FunctionDef) and not n.name.startswith("_"):
                parts.append(section_of_function(n, f"clsdf.{name}.{n.name}", 3))
    return "\n\n".join(filter(None, parts)) + "\n"
