"""Pages of the modules of Fortran, from their comments (!> before, !< beside)."""

import re

import cpp

SECTION = re.compile(r"  ! ---- (.*?) ----")
PROCEDURE = re.compile(r"  (?:(?:pure|impure|elemental|recursive) )*(function|subroutine) (\w+)")
BINDING = re.compile(r"    (procedure|generic)(.*?)(?:::)\s*(.*)")


def joined(lines):
    """Statements without the marks of continuation."""
    statements = []
    for line in lines:
        if statements and statements[-1].rstrip().endswith("&"):
            statements[-1] = statements[-1].rstrip()[:-1] + line.strip()
        else:
            statements.append(line)
    return statements


def comment_above(lines, at):
    """The text of the lines !> that end above a line."""
    begin = at
    while begin > 0 and re.match(r"\s*!>", lines[begin - 1]):
        begin -= 1
    return cpp.escaped(" ".join(re.sub(r"\s*!> ?", "", line) for line in lines[begin:at]))


class Module:
    def __init__(self, path):
        self.lines = joined(path.read_text().split("\n"))
        at = next(i for i, line in enumerate(self.lines) if re.match(r"module \w+$", line))
        head = "\n".join(line[3:] for line in self.lines[:at])
        # Numbers and structs of C, some of which are public, are in another file.
        self.lines[at:at] = joined((path.parent / "clsdf_c.f90").read_text().split("\n"))
        self.head = re.sub(r"^([A-Z]{5,})([. ])", lambda m: f"**{m.group(1).capitalize()}**{m.group(2)}", cpp.escaped(head), flags=re.M)
        text = "\n".join(self.lines)
        self.public = set(re.findall(r"\w+", " ".join(re.findall(r"^  public :: ([^!\n]*)", text, re.M))))
        self.beside = dict(re.findall(r"^  public :: (\w+) *!< (.*)", text, re.M))
        hidden = text.partition("! For the module clsdf_io, not for programs.\n")[2].partition("\n")[0] if "not for programs" in text else ""
        self.public -= set(re.findall(r"\w+", hidden.partition("::")[2]))
        self.body = self.lines.index("contains")
        self.procedures = {}
        for i in range(self.body, len(self.lines)):
            match = PROCEDURE.match(self.lines[i])
            if match and not self.lines[i].startswith("   "):
                self.procedures[match.group(2)] = (comment_above(self.lines, i), self.signature(i))

    def signature(self, at):
        """The head of a procedure with the declarations of its arguments."""
        head = self.lines[at].strip()
        names = [name.strip() for name in re.search(r"\((.*?)\)", head + "()").group(1).split(",")]
        result = re.search(r"result\((\w+)\)", head)
        if result:
            names.append(result.group(1))
        declarations = []
        for line in self.lines[at + 1:at + 40]:
            match = re.match(r"    [a-z].*::\s*(.*)", line)
            if not match:
                break
            declared = re.findall(r"(\w+)(?:\([^)]*\))?(?:\s*=[^,]*)?(?:,|$|\s*!)", match.group(1))
            if any(name in names and name != "self" for name in declared):
                declarations.append("    " + line.strip())
        return "\n".join([head, *declarations])

    def section_of_procedure(self, name, shown, level):
        text, code = self.procedures[name]
        return "\n\n".join(filter(None, ["#" * level + f" `{shown}`", f"```fortran\n{code}\n```", text]))

    def section_of_type(self, at):
        name = re.search(r"(\w+)\s*$", self.lines[at]).group(1)
        end = next(i for i in range(at, len(self.lines)) if self.lines[i].strip() == "end type")
        members, bindings, is_bound, above = [], [], False, {}
        for i in range(at + 1, end):
            line = self.lines[i]
            is_bound = is_bound or line.strip() == "contains"
            match = BINDING.match(line)
            if match and "private" not in match.group(2) and "deferred" not in match.group(2) and "assignment" not in match.group(3):
                shown, _, own = match.group(3).partition("=>")
                own = [n.strip() for n in own.split("!")[0].split(",")] if own else [shown.strip()]
                bindings.append((shown.strip(), own, comment_above(self.lines, i)))
            elif not is_bound and ", private ::" not in line:
                members.append(line.rstrip())
        code = [self.lines[at].strip(), *(line[2:] for line in members), "end type"]
        parts = [f"### `{name}`", comment_above(self.lines, at), "```fortran\n" + "\n".join(code) + "\n```"]
        for shown, own, text in bindings:
            # The copies for other kinds and ranks have no comment of their own.
            shown_of = next((n for n in own if n in self.procedures and self.procedures[n][0]), own[0])
            if shown_of in self.procedures:
                parts.append(text if text and not self.procedures[shown_of][0] else "")
                parts.append(self.section_of_procedure(shown_of, f"{name.removeprefix('clsdf_')}%{shown}", 4))
                if len(own) > 1:
                    parts.append(f"It has {len(own)} forms, for other kinds, ranks or arguments.")
        return "\n\n".join(filter(None, parts))

    def page(self, title):
        parts = [f"# {title}", self.head, f"```fortran\nuse {title}\n```"]
        section = ""
        for i, line in enumerate(self.lines[:self.body]):
            match = SECTION.match(line)
            if match:
                section = match.group(1)
            name = re.match(r"  type\b.*::\s*(\w+)\s*$", line)
            if name and name.group(1) in self.public:
                if section:
                    parts.append(f"## {section}")
                    section = ""
                elif not any(part.startswith("## ") for part in parts):
                    parts.append("## Types")
                parts.append(self.section_of_type(i))
        parts.append("## Procedures")
        for name in self.procedures:
            if name in self.public:
                parts.append(self.section_of_procedure(name, name, 3))
        numbers = []
        for i, line in enumerate(self.lines[:self.body]):
            match = re.match(r"  integer\(c_int\d+_t\), parameter(, public)? :: ((\w+) = \S+) *(?:!< (.*))?", line)
            if match and (match.group(1) or match.group(3) in self.public):
                words = " ".join(filter(None, [comment_above(self.lines, i), cpp.escaped(match.group(4) or "")]))
                numbers.append((match.group(2), cpp.escaped(self.beside.get(match.group(3), "")) or words))
        if numbers:
            parts += ["## Numbers", cpp.table(numbers)]
        return "\n\n".join(filter(None, parts)) + "\n"
