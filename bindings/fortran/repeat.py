#!/usr/bin/env python3
"""Writes the repeated procedures of clsdf.f90: for other kinds, ranks and types of objects.

    repeat.py FILE            writes them into FILE
    repeat.py --check FILE    exit status 1 if FILE would change, with the first lines that differ

A pattern is written by hand, and what this script makes of it stands below it:

    ! REPEATED FOR rank=2 | rank=3 | r8 | r8 rank=2
    (the pattern: procedures for real(4) arrays of rank 1, say)
    ! REPEATED BY repeat.py
    (a copy for each list of rules between the bars)
    ! END

A rule is one of the names below, or old=new: this word of a name, or the whole of it, becomes another one.
"""

import difflib
import re
import sys
from pathlib import Path


def of_kind(number: str, declared: str, constant: str):
    def change(text: str) -> str:
        text = re.sub(r"_r4(?![a-z0-9])", f"_{number}", text)
        text = re.sub(r"real\(c_float\)", declared, text)
        return text.replace("CLSDF_FLOAT32", constant)

    return change


def closest_beside_offset(text: str) -> str:
    """Arrays in double precision have one output more: positions of the closest points."""
    vectors = r"(real\(\w+\), intent\(inout\), target, optional ::) offset(\(.*?\)), gradient"
    text = text.replace("offset, gradient, barycentric, &", "closest, gradient, barycentric, offset, &")
    text = re.sub(f"( *){vectors}(.*)", r"\1\2 closest\3, gradient\4\n\1\2 offset\3", text)
    text = text.replace("targets(6)\n", "targets(7)\n").replace("CLSDF_OFFSET, offset", "CLSDF_CLOSEST, closest")
    text = text.replace("present(offset)", "present(closest)")
    last = r"( *if \(present)\(barycentric\)\) targets\(6\).*"
    return re.sub(last, r"\g<0>\n\1(offset)) targets(7) = clsdf_target(CLSDF_OFFSET, offset)", text)


def of_rank(rank: int):
    """From arrays of rank 1."""

    def element(axis: int) -> str:
        return "x(" + ", ".join(f"k({i})" if i == axis else "1" for i in range(1, rank + 1)) + ")"

    def change(text: str) -> str:
        neighbours = [f"c_loc({element(axis)})" for axis in range(1, rank + 1)]
        call = f"    call place(array, c_loc({element(0)}), &\n        [" + neighbours[0]
        for i, neighbour in enumerate(neighbours[1:], 1):
            call += (", &\n        " if i == 3 else ", ") + neighbour
        text = re.sub(r" *call place\(.*", lambda _: call + "])", text)
        text = text.replace("_1(", f"_{rank}(").replace("x(:)", "x(" + ", ".join(":" * rank) + ")")
        return text.replace(":: k(1)", f":: k({rank})")

    return change


def with_components(text: str) -> str:
    """From pointers to arrays of a number for each sample to those of several."""
    text = text.replace("_3(", "_4(").replace("(:, :, :)", "(:, :, :, :)").replace(", 3, array", ", 4, array")
    return text.replace("grid%size)", "[components, grid%size])").replace("values(grid", "values(1:, grid")


RULES = {
    "r8": of_kind("r8", "real(c_double)", "CLSDF_FLOAT64"),
    "i4": of_kind("i4", "integer(c_int32_t)", "CLSDF_INT32"),
    "i8": of_kind("i8", "integer(c_int64_t)", "CLSDF_INT64"),
    "i1": of_kind("i1", "integer(c_int8_t)", "CLSDF_UINT8"),
    "closest": closest_beside_offset,
    "components": with_components,
    **{f"rank={rank}": of_rank(rank) for rank in range(2, 6)},
}


def repeated(pattern: str, rules: str) -> str:
    """A copy of the pattern. Words of names are separated by _, and a name may be one word."""
    for rule in rules.split():
        if rule in RULES:
            pattern = RULES[rule](pattern)
        else:
            old, new = rule.split("=")
            pattern = re.sub(rf"(?<![A-Za-z0-9]){old}(?![A-Za-z0-9])", new, pattern)
    return pattern


def written(text: str) -> str:
    """The file with all copies."""
    begin, middle, end = "! REPEATED FOR ", "! REPEATED BY repeat.py\n", "! END\n"
    # Lists that end with a bar go on in the next line.
    region = re.compile(rf"^( *){begin}((?:[^\n]*\|\n)*[^\n]*)\n(.*?)^ *{middle}.*?^ *{end}", re.M | re.S)
    if not len(region.findall(text)) == text.count(begin) == text.count(middle) == text.count(end) > 0:
        sys.exit(f"repeat.py: each '{begin}' needs a '{middle.strip()}' and an '{end.strip()}' behind it")

    def with_copies(match: re.Match) -> str:
        indent, lists, pattern = match.groups()
        copies = "\n\n".join(repeated(pattern.strip("\n"), rules) for rules in re.sub(r"\n *!", "", lists).split("|"))
        return f"{match[0][:match.start(3) - match.start()]}{pattern}{indent}{middle}\n{copies}\n\n{indent}{end}"

    return region.sub(with_copies, text)


def main() -> int:
    check = sys.argv[1:2] == ["--check"]
    if len(sys.argv) != 2 + check:
        sys.exit(__doc__)
    path = Path(sys.argv[-1])
    before = path.read_text()
    after = written(before)
    if check and before != after:
        sys.stdout.writelines(list(difflib.unified_diff(before.splitlines(True), after.splitlines(True), "is", "should be"))[:20])
        print(f"{path} is stale: write its patterns, and run bindings/fortran/repeat.py {path}")
        return 1
    if not check:
        path.write_text(after)
    return 0


if __name__ == "__main__":
    sys.exit(main())
