"""A C interface can have every enumeration and every plain struct of the public headers.

c_names.py HEADERS OUTPUT COMPILER [SKIPPED...]: writes them as C99 to OUTPUT and compiles that. A type that has no
counterpart in C, such as a template, is an error, and so is an enumerator without a number of its own. Classes, and
structs with private members, are objects behind a handle, a void*. clsdf::detail is left out.
"""

import pathlib
import re
import subprocess
import sys

# Types that must be found: a check of this script.
EXPECTED = """ElementType Output ErrorCode DeviceKind SignRule BoxPlace Length::Unit Progress::Stage ArrayLayout InputArray
OutputArray OutputTarget OutputInfo Grid GridOptions Band Length Box Region Request BlockSet Progress CallOptions
TransformOptions SlabOptions KeptMemory TransformStatistics WorkCounts KernelBody DeviceInfo DeviceLimits Topology Defects
FieldDescription PapersOptions Classification SaddleReport picture::View reference::Nearest reference::CheckReport
reference::CheckReport::Finding""".split()

PLAIN = {
    "bool": "bool", "int": "int", "unsigned": "unsigned int", "float": "float", "double": "double", "void": "void",
    "std::size_t": "size_t", "std::ptrdiff_t": "ptrdiff_t", "std::byte": "unsigned char",
    "char*": "char*", "void*": "void*", "std::string": "const char*", "OutputSet": "uint32_t",
    **{f"std::{sign}int{bits}_t": f"{sign}int{bits}_t" for sign in ("", "u") for bits in (8, 16, 32, 64)},
    **{handle: "void*" for handle in ("cl_mem", "cl_event", "cl_context", "cl_device_id", "cl_command_queue")},
}
# Classes that are a sequence of a struct.
SEQUENCES = {"OutputTargets": "OutputTarget"}


class Refused(Exception):
    pass


def snake(name):
    return re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", name.replace("::", "_")).lower()


def without_comments(text):
    text = re.sub(r"/\*.*?\*/", "", re.sub(r"//[^\n]*", "", text), flags=re.S)
    text = re.sub(r"^[ \t]*#(?:[^\n]*\\\n)*[^\n]*", "", text, flags=re.M)
    return re.sub(r"\bCLSDF_(EXPORT|VISIBLE)\b", "", text)


def without_brackets(text, opening, closing):
    """The text without what is between the outermost brackets of a kind."""
    kept, depth = "", 0
    for letter in text:
        depth += letter == opening
        if depth == 0:
            kept += letter
        depth -= letter == closing and depth > 0
    return kept


def statements(text):
    """Pairs of a statement and, if it is a block, the text between its braces."""
    begin = at = 0
    while at < len(text):
        if text[at] == ";":
            yield text[begin:at].strip(), None
            begin = at + 1
        elif text[at] == "{":
            opened, depth = at, 1
            while depth > 0:
                at += 1
                depth += {"{": 1, "}": -1}.get(text[at], 0)
            head = text[begin:opened].strip()
            is_block = re.match(r"(namespace|enum|struct|class|template)\b", head) or \
                "(" in without_brackets(head, "<", ">")
            if not head or (is_block and head.count("(") == head.count(")")):  # else it is a value
                yield head, text[opened + 1:at]
                begin = at + 1
        at += 1


def split_at_commas(text):
    parts, depth = [""], 0
    for letter in text:
        depth += {"<": 1, "(": 1, ">": -1, ")": -1}.get(letter, 0)
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return [part.strip() for part in parts if part.strip()]


class Interface:
    def __init__(self):
        self.enums, self.structs, self.aliases, self.declared, self.constants = {}, {}, {}, set(), {}
        self.objects = set()

    def read(self, text, scope=""):
        """The declarations of a namespace, or of a struct with this name."""
        members = []
        self.constants.update(re.findall(r"\binline constexpr [\w:]+ (\w+) = (\d+);", text))
        for head, body in statements(text):
            words = head.split()
            if not words or words[0] == "typedef":
                continue
            if words[0] == "namespace":
                inner = re.match(r"namespace\s+(?:clsdf)?(?:::)?(\w*)$", head)
                if inner and inner[1] != "detail":
                    self.read(body, scope + (inner[1] + "::" if inner[1] else ""))
            elif words[0] == "using":
                name, equals, type_name = head[len("using"):].partition("=")
                if equals:
                    self.aliases[name.strip()] = type_name.strip()
            elif words[0] == "enum":
                self.read_enum(head, body, scope)
            elif words[0] == "struct":
                self.read_struct(head, body, scope)
            elif re.match(r"class\s+\w+$", head) and body is not None:
                self.objects.add(scope + words[1])
            elif re.match(r"template\b.*\bstruct\b", head, re.S) and "(" not in without_brackets(head, "<", ">"):
                raise Refused(f"{head}: C has no templates")
            elif scope and not re.match(r"(template|friend|static|constexpr|explicit|class)\b", head):
                members.append((head, body))
        return members

    def read_enum(self, head, body, scope):
        match = re.match(r"enum\s+class\s+(\w+)\s*(?::\s*([\w:]+))?$", head)
        if not match:
            raise Refused(f"'{head}' is no enum class")
        name = scope + match[1]
        if match[2] not in PLAIN:
            raise Refused(f"enum {name} has no underlying type of a fixed size")
        numbers = {}
        for enumerator in split_at_commas(body or ""):
            pair = re.match(r"(\w+)\s*=\s*(-?\d+)$", enumerator)
            if not pair:
                raise Refused(f"enumerator '{enumerator}' of {name} has no number")
            if pair[2] in numbers.values():
                raise Refused(f"enumerator '{enumerator}' of {name} has the number of another one")
            numbers[pair[1]] = pair[2]
        self.enums[name] = (PLAIN[match[2]], numbers or self.enums.get(name, (0, {}))[1])

    def read_struct(self, head, body, scope):
        match = re.match(r"struct\s+(\w+)\s*(?::\s*(\w+))?$", head)
        if not match:
            raise Refused(f"'{head}' is no plain struct")
        name = scope + match[1]
        if body is None:
            self.declared.add(name)
        elif re.search(r"\b(private|protected)\s*:", body):
            self.objects.add(name)
        else:
            data = []
            if match[2]:
                data.append((match[2], snake(match[2]), name))
            for member, _ in self.read(body, name + "::"):
                member = re.split(r"[={]", member)[0].strip()
                if "(" in without_brackets(member, "<", ">"):
                    continue  # a function
                parts = re.match(r"(.*[\s>*&])(\w+)$", member, re.S)
                if not parts:
                    raise Refused(f"member '{member}' of {name} is not understood")
                data.append((" ".join(parts[1].split()), parts[2], name))
            self.structs[name] = data

    # Translation.

    def resolved(self, type_name, scope):
        """The name of a type that a name stands for in a struct."""
        while True:
            name = f"{scope}::{type_name}" if scope else type_name
            if name in self.enums or name in self.structs or name in self.objects:
                return name
            if not scope:
                return None
            scope = scope.rpartition("::")[0]

    def single(self, type_name, scope):
        """A type without a count, as what stands before and after its name."""
        type_name = re.sub(r"^const\s+|\s+(?=\*)", "", type_name.strip())
        if type_name in PLAIN:
            return PLAIN[type_name], ""
        if type_name in self.aliases:
            return self.single(self.aliases[type_name], scope)
        array = re.match(r"std::array<(.*),\s*(?:\w+::)*(\w+)>$", type_name)
        if array:
            before, after = self.single(array[1], scope)
            return before, f"[{self.constants.get(array[2], array[2])}]{after}"
        if re.match(r"std::shared_ptr<[\w\s:]+>$", type_name):
            return "const void*", ""
        name = self.resolved(type_name, scope)
        if name is None:
            raise Refused(f"type '{type_name}' in {scope} has no counterpart in C")
        if name in self.objects:
            return "void*", ""
        return f"clsdf_{snake(name)}", ""

    def declaration(self, type_name, name, scope):
        """The members that stand for one member."""
        type_name = type_name.strip()
        function = re.match(r"std::function<(.*?)\((.*)\)>$", type_name)
        if function:
            parameters = []
            for parameter in split_at_commas(function[2]):
                parameter = re.match(r"(.*[\w>]\s*&|(?:const\s+)?[\w:<>, ]*?[\w>])(?:\s*\b(\w+))?$", parameter)[1]
                before, after = self.single(parameter.rstrip("& "), scope)
                is_reference = parameter.endswith("&") and "*" not in before
                parameters.append(f"const {before}*" if is_reference or after else before)
            result = self.single(function[1], scope)[0]
            return [f"{result} (*{name})({', '.join(parameters + ['void* user'])})", f"void* {name}_user"]
        optional = re.match(r"std::optional<(.*)>$", type_name)
        if optional:
            return [f"bool has_{name}"] + self.declaration(optional[1], name, scope)
        sequence = re.match(r"std::(?:span|vector)<(.*)>$", type_name)
        if sequence or type_name in SEQUENCES:
            before, after = self.single(sequence[1] if sequence else SEQUENCES[type_name], scope)
            if not before.endswith("*"):
                before = "const " + before
            pointer = f"(*{name}){after}" if after else ("const* " if before.endswith("*") else "* ") + name
            return [f"{before} {pointer}".replace(" * ", "* "), f"size_t {name}_count"]
        before, after = self.single(type_name, scope)
        is_const = type_name.startswith("const ") and before.endswith("*") and not before.startswith("const ")
        return [f"{'const ' if is_const else ''}{before} {name}{after}"]

    def as_c(self):
        lines = ["#include <stdbool.h>", "#include <stddef.h>", "#include <stdint.h>", ""]
        for name, (underlying, numbers) in self.enums.items():
            lines.append(f"typedef {underlying} clsdf_{snake(name)};")
            if numbers:
                texts = [f"    CLSDF_{snake(name).upper()}_{key.upper()} = {value}" for key, value in numbers.items()]
                lines += ["enum {", ",\n".join(texts), "};"]
        lines += [f"typedef struct clsdf_{snake(name)} clsdf_{snake(name)};" for name in self.structs]
        done = set()

        def add(name):
            if name in done:
                return
            done.add(name)
            body = []
            for type_name, member, scope in self.structs[name]:
                for used in re.findall(r"[\w:]+", type_name):
                    inner = self.resolved(used, scope)
                    if inner in self.structs:
                        add(inner)
                body += self.declaration(type_name, member, scope)
            lines.extend([f"struct clsdf_{snake(name)} {{"] + [f"    {text};" for text in body] + ["};"])

        for name in self.structs:
            if self.structs[name]:
                add(name)
        return "\n".join(lines) + "\n"


def translated(texts):
    interface = Interface()
    for text in texts:
        interface.read(without_comments(text))
    return interface, interface.as_c()


def check_that_it_refuses():
    for text in ("enum class A : std::int32_t { a, b = 1 };", "enum class A { a = 0 };",
                 "template <typename> struct X {}; ", "struct B { X<int> x; };", "struct B { std::map<int, int> x; };",
                 "struct B { std::vector<X<int>> x; };", "struct B { std::function<void(const X<int>& x)> f; };"):
        try:
            translated([f"namespace clsdf {{ {text} }}"])
        except Refused:
            continue
        raise Refused(f"this script takes '{text}'")


def main():
    headers, output, compiler, *skipped = sys.argv[1:]
    try:
        check_that_it_refuses()
        paths = [path for path in sorted(pathlib.Path(headers).glob("*.h*")) if path.name not in skipped]
        interface, text = translated(path.read_text() for path in paths)
        missing = [name for name in EXPECTED if name not in interface.enums and not interface.structs.get(name)]
        if missing:
            raise Refused("not found in the public headers: " + ", ".join(missing))
    except Refused as reason:
        sys.exit(f"a C interface could not have all types: {reason}")
    pathlib.Path(output).write_text(text)
    print(f"{len(interface.enums)} enumerations and {len(interface.structs)} structs, {output}")
    sys.exit(subprocess.run([compiler, "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", "-fsyntax-only", output],
                            check=False).returncode)


if __name__ == "__main__":
    main()
