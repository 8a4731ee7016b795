#!/usr/bin/env python3
"""Writes what other files say of the C interface, from its headers, which are its one description: clsdf.h with its parts
in clsdf/c, and clsdf_io.h.

    interface.py            writes the files
    interface.py --check    exit status 1 if a file would change, with the first lines that differ

    bindings/fortran/clsdf_c.f90            numbers, structs and functions of C for the Fortran modules
    bindings/c/tests/structs.c              assertions on the size of each struct and the offset of each member
    packaging/debian/libclsdf-c*.symbols    the exported names, each with the version that brought it

Needs pycparser and a C compiler (CC, or cc).
"""

import difflib
import math
import os
import re
import subprocess
import sys
import tempfile
import textwrap
from dataclasses import dataclass
from pathlib import Path

try:
    from pycparser import c_ast, c_parser
except ImportError:
    sys.exit("skipped: pycparser is not installed (scripts/setup --tests)")

ROOT = Path(__file__).resolve().parent.parent
INCLUDE = ROOT / "bindings/c/include"
# The parts of clsdf.h, in the order in which it includes them.
PARTS = [INCLUDE / name for name in re.findall(r'^#include "(clsdf/c/.*)"', (INCLUDE / "clsdf.h").read_text(), re.M)]
# The headers that declare the functions of each library.
HEADERS = {"libclsdf_c": PARTS, "libclsdf_c_io": [INCLUDE / "clsdf_io.h"]}

# ---- Special cases ----

# Structs that Fortran programs use as they are in C. All others are called c_... in Fortran, because the module clsdf has
# types of its own for them.
SHARED = """clsdf_box clsdf_length clsdf_band clsdf_region clsdf_progress clsdf_statistics clsdf_kept_memory clsdf_sparse_counts
    clsdf_device_sparse_counts clsdf_device_link_count clsdf_edge clsdf_defects clsdf_weld_report clsdf_outer_report
    clsdf_fraction_options clsdf_cell_fraction""".split()

# Arguments for which the modules pass null in some calls: type(c_ptr) in place of a type.
NULLABLE = {
    "call", "statistics", "wait_list", "done",  # of all functions
    "clsdf_compute_slabs.options",              # null: defaults
    "clsdf_mesh_write.colours",                 # null: no colours
    "clsdf_point_plan_enqueue.status",          # null: not wanted
    "clsdf_scene_query.own",                    # null: not wanted
    "clsdf_scene_set_poses.bodies",             # null: all bodies
    "clsdf_transform_part_bytes.bytes",         # null: asks for the count
    "clsdf_transform_part_vertices.vertices",   # null: asks for the count
}

# Arrays that a function fills. Their types (double *, int32_t *, a handle **) are those of one value elsewhere.
FILLED = {"directions", "fields", "position", "results"}

# Initial values of members that differ from those of the _INIT macros (0 without one).
INITIAL = {
    "clsdf_grid.spacing": "1",                        # it has no macro; grids in the macros of other structs have this
    "clsdf_mesh_arrays.index_base": "1",              # Fortran counts from 1
    "clsdf_scene_options.index_base": "1",            # Fortran counts from 1
    "clsdf_ray_request.limit": "huge(1.0_c_double)",  # Fortran has no constant for infinity
}

# The types of C: that of Fortran, and the bytes.
TYPES = {
    "double": ("real(c_double)", 8), "float": ("real(c_float)", 4), "size_t": ("integer(c_size_t)", 8),
    "char": ("character(kind=c_char)", 1), "clsdf_status": ("integer(c_int32_t)", 4),
    **{f"{sign}int{bits}_t": (f"integer(c_int{bits}_t)", bits // 8) for sign in ("", "u") for bits in (8, 32, 64)},
}

# ---- What the headers declare ----


@dataclass
class Value:
    """A member or an argument, or a result."""

    name: str
    base: str
    coord: object
    pointers: int = 0
    dimensions: tuple = ()
    is_input: bool = False  # what the pointer leads to is const


def value_of(name, node, coord) -> Value:
    value = Value(name, "", coord)
    while not isinstance(node, c_ast.TypeDecl):
        if isinstance(node, c_ast.ArrayDecl):
            value.dimensions += (int(node.dim.value),)
        else:
            if value.pointers == 0:
                value.is_input = "const" in node.type.quals
            value.pointers += 1
        node = node.type
    value.base = " ".join(node.type.names)
    return value


def declarations(more=""):
    """The syntax trees of the headers. Headers of the system are empty, but for the types that are used here."""
    integers = "".join(f"typedef int {sign}int{bits}_t;\n" for sign in ("", "u") for bits in (8, 32, 64))
    with tempfile.TemporaryDirectory() as folder:
        for name, text in (("math.h", ""), ("stddef.h", "typedef int size_t;\n"), ("stdint.h", integers)):
            Path(folder, name).write_text(text)
        compiler = os.environ.get("CC") or "cc"
        command = [compiler, "-E", "-nostdinc", "-U__GNUC__", "-I", folder, "-I", INCLUDE, "-x", "c", "-"]
        text = "#include <clsdf.h>\n#include <clsdf_io.h>\n" + more
        text = subprocess.run(command, input=text, text=True, stdout=subprocess.PIPE, check=True).stdout
    return [node for node in c_parser.CParser().parse(text).ext if not isinstance(node, c_ast.FuncDef)]


def place_of(coord):
    return Path(coord.file).name, coord.line


class Interface:
    def __init__(self):
        self.numbers = []  # (name, value, comment above, comment beside)
        self.structs = {}  # name: its members
        self.functions = []  # (name, result, arguments, header)
        self.callbacks = set()
        self.places = {}  # of structs: the header and the line
        self.comments = {}  # (header, line): the comment beside this line
        self.comments_above = {}  # (header, line): the first line of a comment that ends on this line, and its text
        for header in sum(HEADERS.values(), []):
            self.read_comments_and_numbers(header)
        for node in declarations():
            if isinstance(node, c_ast.Decl):
                arguments = [value_of(a.name, a.type, a.coord) for a in node.type.args.params if a.name]
                self.functions.append((node.name, value_of("value", node.type.type, node.coord), arguments, Path(node.coord.file)))
            elif isinstance(node.type, c_ast.PtrDecl):
                self.callbacks.add(node.name)
            elif isinstance(node.type.type, c_ast.Struct) and node.type.type.decls:
                self.places[node.name] = place_of(node.type.type.coord)
                self.structs[node.name] = [value_of(m.name, m.type, m.coord) for m in node.type.type.decls]
        # The _INIT macros, expanded as initial values of variables.
        text = "".join(header.read_text() for header in PARTS)
        macros = [name for name in self.structs if f"#define {name.upper()}_INIT" in text]
        variables = declarations("".join(f"{name} a_{name} = {name.upper()}_INIT;\n" for name in macros))
        self.initial = {node.name[2:]: node.init.exprs for node in variables if getattr(node, "init", None)}

    def read_comments_and_numbers(self, header):
        text = header.read_text()

        def line_of(at):
            return text.count("\n", 0, at) + 1

        for comment in re.finditer(r"/\*(.*?)\*/", text, re.S):
            words = " ".join(re.sub(r"\n *\*?", "\n", comment[1]).split())
            begin = line_of(comment.start())
            if text[:comment.start()].rpartition("\n")[2].strip():
                self.comments[header.name, begin] = words
            elif not words.startswith("----"):
                self.comments_above[header.name, line_of(comment.end())] = (begin, words)
        for number in re.finditer(r"^#define (CLSDF_[A-Z0-9_]+)[\s\\]+\(?(-?\d+)\b", text, re.M):
            if "_VERSION_" not in number[1]:
                above = self.comment_above((header.name, line_of(number.start())))
                beside = self.comments.get((header.name, line_of(number.end())), "")
                self.numbers.append((number[1], number[2], above, beside))

    def comment_above(self, place):
        header, line = place
        words = []
        while (header, line - 1) in self.comments_above:
            line, text = self.comments_above[header, line - 1]
            words.insert(0, text)
        return " ".join(words)

    def layout(self, base):
        """The alignment and the size of a type, and the offsets of its members, of 64-bit systems."""
        if base not in self.structs:
            size = TYPES[base][1]
            return size, size, {}
        at, largest, offsets = 0, 1, {}
        for member in self.structs[base]:
            is_pointer = member.pointers or member.base in self.callbacks
            alignment, size, _ = (8, 8, None) if is_pointer else self.layout(member.base)
            at = -(-at // alignment) * alignment
            offsets[member.name] = at
            at += size * math.prod(member.dimensions)
            largest = max(largest, alignment)
        return largest, -(-at // largest) * largest, offsets


# ---- Fortran ----


def name_in_fortran(name):
    return name if name in SHARED else "c_" + name.removeprefix("clsdf_")


def statement(indent, text):
    """A statement, continued in further lines if it is long."""
    lines = textwrap.wrap(text, 118 - indent, subsequent_indent="    ", break_long_words=False, break_on_hyphens=False)
    return " &\n".join(" " * indent + line for line in lines) + "\n"


def documented(indent, text, above, beside):
    """A declaration with its comments. That beside it stays there if the line is not too long."""
    line = " " * indent + text
    comments = [above]
    if beside and len(line) + len(beside) < 114:
        line += f"  !< {beside}"
    else:
        comments.append(beside)
    prefix = " " * indent + "!> "
    lines = [prefix + words for comment in comments for words in textwrap.wrap(comment, 120 - len(prefix))]
    return "\n".join([*lines, line]) + "\n"


class Fortran:
    def __init__(self, interface):
        self.interface = interface

    def number(self, name, value, above, beside):
        text = documented(2, f"integer(c_int32_t), parameter :: {name} = {value}", above, beside)
        return "\n" + text if above else text

    def type_of(self, base):
        if base in self.interface.callbacks:
            return "type(c_funptr)"
        return f"type({name_in_fortran(base)})" if base in self.interface.structs else TYPES[base][0]

    def initial(self, struct, member, node):
        """The initial value of a member whose macro has the expression `node`, if there is one."""
        if f"{struct}.{member.name}" in INITIAL:
            return INITIAL[f"{struct}.{member.name}"]
        if member.base in self.interface.callbacks:
            return "c_null_funptr"
        if member.pointers:
            return "c_null_ptr"
        if member.base in self.interface.structs:
            if node is None or member.dimensions:
                return ""
            given = self.initial_values(member.base, node.exprs)
            own = self.initial_values(member.base, self.interface.initial.get(member.base))
            return "" if given == own else f"{name_in_fortran(member.base)}({', '.join(given)})"
        if member.name == "struct_size":
            # CLSDF_RESULT_SIZE adds 1.
            return str(self.interface.layout(struct)[1] + isinstance(node, c_ast.BinaryOp))
        numbers = [number_of(n) for n in (node.exprs if isinstance(node, c_ast.InitList) else [node])]
        return numbers[0] if len(set(numbers)) == 1 else f"[{', '.join(numbers)}]"

    def initial_values(self, struct, nodes):
        members = self.interface.structs[struct]
        return [self.initial(struct, member, node) for member, node in zip(members, nodes or [None] * len(members))]

    def struct(self, name):
        interface = self.interface
        text = documented(2, f"type, bind(C) :: {name_in_fortran(name)}", interface.comment_above(interface.places[name]), "")
        for member, initial in zip(interface.structs[name], self.initial_values(name, interface.initial.get(name))):
            place = place_of(member.coord)
            kind = "type(c_ptr)" if member.pointers else self.type_of(member.base)
            shape = f"({', '.join(map(str, reversed(member.dimensions)))})" if member.dimensions else ""
            declared = f"{kind} :: {member.name}{shape}" + (f" = {initial}" if initial else "")
            text += documented(4, declared, interface.comment_above(place), interface.comments.get(place, ""))
        return text + "  end type\n\n"

    def argument(self, function, argument, following):
        """The type of an argument with its attributes, and its shape. A call that fails may leave a result as it is: inout."""
        base, pointers = argument.base, argument.pointers
        intent = "in" if argument.is_input else "inout"
        if pointers == 0:
            return f"{self.type_of(base)}, value", ""
        if argument.name in NULLABLE or f"{function}.{argument.name}" in NULLABLE:
            return "type(c_ptr), value", ""
        if pointers == 2 and (argument.is_input or argument.name in FILLED):
            return f"type(c_ptr), intent({intent})", "(*)"
        if pointers == 2:
            return "type(c_ptr), intent(out)", ""
        if base in self.interface.structs:
            # An array if its count follows.
            is_array = following and following.pointers == 0 and re.search("^size$|(^|_)count$", following.name)
        elif base in TYPES and (base != "char" or argument.is_input):
            is_array = argument.is_input or base in ("float", "uint8_t") or argument.name in FILLED
        else:
            return "type(c_ptr), value", ""  # a handle, void, or room for a text
        return f"{self.type_of(base)}, intent({intent})", "(*)" if is_array else ""

    def function(self, name, result, arguments, _):
        is_function = result.base != "void"
        word = "function" if is_function else "subroutine"
        head = f"{word} c_{name.removeprefix('clsdf_')}({', '.join(a.name for a in arguments)}) bind(C, name=\"{name}\")"
        text = statement(4, head + (" result(value)" if is_function else ""))
        text += "      import\n"
        for argument, following in zip(arguments, [*arguments[1:], None]):
            kind, shape = self.argument(name, argument, following)
            text += f"      {kind} :: {argument.name}{shape}\n"
        if is_function:
            text += f"      {'type(c_ptr)' if result.pointers else self.type_of(result.base)} :: value\n"
        return text + f"    end {word}\n"

    def module(self):
        interface = self.interface
        return "".join([
            "! Numbers, structs and functions of clsdf.h and clsdf_io.h, for the modules clsdf and clsdf_io, not for programs.\n"
            "!\n"
            "! Written by bindings/interface.py: change the headers, not this file.\n"
            "module clsdf_c\n"
            "  use, intrinsic :: iso_c_binding\n"
            "  implicit none\n\n"
            "  ! ---- Numbers ----\n\n",
            *(self.number(*number) for number in interface.numbers),
            "\n  ! ---- Structs of C ----\n\n",
            *map(self.struct, interface.structs),
            "  ! ---- Functions ----\n\n",
            "  interface\n",
            *(self.function(*function) for function in interface.functions),
            "  end interface\n",
            "end module\n",
        ])


def number_of(node):
    """A number of C as Fortran writes it."""
    if node is None:
        return "0"
    if isinstance(node, c_ast.UnaryOp):
        return node.op + number_of(node.expr)
    return node.value + "_c_double" if node.type == "double" else node.value


# ---- Assertions and exported names ----


def assertions(interface):
    text = """/*
 * The size of each struct of clsdf.h and the offset of each member, on which programs that were compiled earlier rely.
 *
 * Written by bindings/interface.py from the header. Lines may be added, and a struct with struct_size may grow at its
 * end. Other changes of a number break such programs: see CLSDF_C_ABI in bindings/c/CMakeLists.txt.
 */
#include <clsdf.h>

#define SIZE(type, bytes) typedef char type##_size[sizeof(type) == (bytes) ? 1 : -1]
#define MEMBER(type, member, bytes) typedef char type##_at_##member[offsetof(type, member) == (bytes) ? 1 : -1]

"""
    for name in interface.structs:
        size, offsets = interface.layout(name)[1:]
        text += f"SIZE({name}, {size});\n"
        text += "".join(f"MEMBER({name}, {member}, {at});\n" for member, at in offsets.items())
    return text + "\nint main(void) {\n    return 0;\n}\n"


def symbols(interface, path):
    """The symbols file of Debian's package. A name keeps the version that it has there; a new one has the present version."""
    abi = re.search(r"libclsdf-c(\d+)", path.name)[1]
    version = ".".join(re.findall(r"#define CLSDF_VERSION_\w+ (\d+)", (INCLUDE / "clsdf/c/basics.h").read_text()))
    since = dict(re.findall(r"^ (\w+@\w+) (.*)$", path.read_text(), re.M))
    text = ""
    for library, headers in HEADERS.items():
        names = [f"CLSDF_C_{abi}", *(name for name, _, _, file in interface.functions if file in headers)]
        text += f"{library}.so.{abi} libclsdf-c{abi} #MINVER#\n"
        for name in sorted(f"{name}@CLSDF_C_{abi}" for name in names):
            text += f" {name} {since.get(name, version + '~')}\n"
        if library == "libclsdf_c":  # between the libraries of one version
            text += ' (optional|regex)"^(clsdf_c_same_version|CLSDF_C_PRIVATE_[0-9.]+)@CLSDF_C_PRIVATE_[0-9.]+$" 0\n'
    return text


def main() -> int:
    check = sys.argv[1:] == ["--check"]
    if sys.argv[1:] and not check:
        sys.exit(__doc__)
    interface = Interface()
    exported = next((ROOT / "packaging/debian").glob("libclsdf-c*.symbols"))
    written = {
        ROOT / "bindings/fortran/clsdf_c.f90": Fortran(interface).module(),
        ROOT / "bindings/c/tests/structs.c": assertions(interface),
        exported: symbols(interface, exported),
    }
    status = 0
    for path, after in written.items():
        before = path.read_text() if path.exists() else ""
        if before == after:
            continue
        lines = list(difflib.unified_diff(before.splitlines(True), after.splitlines(True), "is", "should be", n=0))
        gone = [line for line in lines if re.match(r"-(SIZE|MEMBER| clsdf)", line) and line[1:] not in after.splitlines(True)]
        if gone:
            print(f"{path.name}: programs rely on these lines, see CLSDF_C_ABI in bindings/c/CMakeLists.txt")
            sys.stdout.writelines(gone)
        if check:
            sys.stdout.writelines(lines[:20])
            print(f"{path.relative_to(ROOT)} is stale: run bindings/interface.py")
            status = 1
        else:
            path.write_text(after)
    return status


if __name__ == "__main__":
    sys.exit(main())
