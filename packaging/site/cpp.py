"""Pages of the headers of C++ and C, from the XML that Doxygen makes of their comments."""

import pathlib
import re
import subprocess
import xml.etree.ElementTree as ElementTree

DOXYFILE = """
OUTPUT_DIRECTORY = {folder}
INPUT = {folder}/headers
RECURSIVE = YES
GENERATE_HTML = NO
GENERATE_LATEX = NO
GENERATE_XML = YES
XML_PROGRAMLISTING = NO
EXTRACT_ALL = YES
EXTRACT_STATIC = YES
MACRO_EXPANSION = YES
EXPAND_ONLY_PREDEF = YES
PREDEFINED = CLSDF_EXPORT= CLSDF_API= DOXYGEN=1
MARKDOWN_SUPPORT = NO
AUTOLINK_SUPPORT = NO
SORT_MEMBER_DOCS = NO
WARN_IF_UNDOCUMENTED = NO
QUIET = YES
"""
HEAD = re.compile(r"^/\*\n(.*?)^ \*/\n", re.S | re.M)  # the comment that opens a header of C
NAMES = {"OPENCL": "OpenCL"}
SECTION = re.compile(r"^/\* ---- (.*?) ---- \*/", re.M)


def commented(text, is_c):
    """The header as Doxygen reads it: C's comments become its own, and what it would take for tags or commands is kept."""
    lines = []
    if is_c:
        text = HEAD.sub("", text, count=1)
    for line in text.split("\n"):
        if is_c:
            line = re.sub(r"(\S.*)/\* (?!----)(?=.*\*/|[^*]*$)", r"\1/**< ", line)
            line = re.sub(r"^(\s*)/\*(?= (?!----)|$)", r"\1/**", line)
        comment = re.search(r"///|/\*\*|^\s*\*(?!/)", line)
        if comment:
            at = comment.end() + line[comment.end():].startswith("<")
            line = line[:at] + re.sub(r"([<>@\\&#])", r"\\\1", line[at:])
        lines.append(line)
    return "\n".join(lines)


def escaped(text):
    """Without what Markdown would change, outside of code."""
    parts = text.split("`")
    return "`".join(part if i % 2 else re.sub(r"([*_<\[\]{}$|~])", r"\\\1", part) for i, part in enumerate(parts))


def description(node):
    """The text of a brief or detailed description: paragraphs and lists."""
    if node is None:
        return ""
    paragraphs = []
    for para in node.iter("para"):
        if para.find(".//itemizedlist") is not None:
            own = escaped(" ".join((para.text or "").split()))
            if own:
                paragraphs.append(own)
            continue
        text = escaped(" ".join("".join(para.itertext()).split()))
        if text:
            paragraphs.append(text)
    for item in node.iter("listitem"):
        text = escaped(" ".join("".join(item.itertext()).split()))
        paragraphs = [p for p in paragraphs if p != text] + [f"- {text}"]
    return "\n\n".join(paragraphs)


def documentation(node):
    return "\n\n".join(filter(None, (description(node.find(f"{kind}description")) for kind in ("brief", "detailed"))))


def flat(node):
    return "" if node is None else " ".join("".join(node.itertext()).split())


def tidy(code):
    code = re.sub(r"\s*([&*]+)\s*(?=[A-Za-z_])", r"\1 ", code)
    return re.sub(r"\s+([&*>,])", r"\1", re.sub(r"([<(])\s+", r"\1", code)).replace(")=", ") =").replace("&amp;", "&").replace("clsdf::", "")


class Member:
    """A function, a value, an enumeration or a type, with its place in the header."""

    def __init__(self, node, language):
        self.kind = node.get("kind")
        self.name = flat(node.find("name"))
        self.line = int(node.find("location").get("line"))
        self.text = documentation(node)
        self.above = ""  # the part of the text that stands above a number, and is about those that follow, too
        self.values = []
        if self.kind == "define":
            names = [flat(p) for p in node.findall("param/defname")]
            value = flat(node.find("initializer"))
            self.code = f"#define {self.name}" + (f"({', '.join(names)})" if names else "") + (f" {value}" if value else "")
        elif self.kind == "enum":
            self.code = f"enum class {self.name}" if node.get("strong") == "yes" else f"enum {self.name}"
            for value in node.findall("enumvalue"):
                self.values.append((f"{flat(value.find('name'))} {flat(value.find('initializer'))}".strip(), documentation(value)))
        else:
            definition = flat(node.find("definition"))
            owner = flat(node.find("qualifiedname")).rpartition("::")[0]
            if owner:
                definition = definition.replace(owner + "::" + self.name, self.name)
            template = node.find("templateparamlist")
            head = ""
            if template is not None:
                parameters = [f"{flat(p.find('type'))} {flat(p.find('declname'))}".strip() for p in template.findall("param")]
                head = f"template <{', '.join(parameters)}> "
            value = flat(node.find("initializer"))
            self.code = tidy(head + definition + flat(node.find("argsstring"))) + (f" {value}" if value and self.kind == "variable" else "")
            self.code = re.sub(r"^(constexpr )?friend (?!class|struct)", r"friend \1", self.code)
            if language == "cpp" or self.kind in ("function", "typedef", "variable"):
                self.code += ";"


class Compound:
    """A struct or a class, with its public members in the order of the header."""

    def __init__(self, node, language):
        full = flat(node.find("compoundname"))
        self.name = full.removeprefix("clsdf::")
        self.kind = node.get("kind")
        self.line = int(node.find("location").get("line"))
        self.file = node.find("location").get("file")
        self.text = documentation(node)
        bases = [flat(base) for base in node.findall("basecompoundref")]
        self.code = f"{self.kind} {self.name}" + (f" : {', '.join(bases)}" if bases else "")
        self.members = [Member(m, language) for m in node.findall("sectiondef/memberdef") if m.get("prot") == "public" and
                        "detail::" not in flat(m.find("definition")) and not (m.get("kind") == "friend" and flat(m.find("type")) in ("class", "struct"))]
        self.members.sort(key=lambda m: m.line)


def table(rows):
    cells = [(f"`{code}`".replace("|", "\\|"), " ".join(text.split())) for code, text in rows]
    return "| | |\n|-|-|\n" + "\n".join(f"| {code} | {text} |" for code, text in cells)


def grouped(members):
    """Members that follow another without a comment of their own share its text."""
    groups = []
    for member in members:
        is_alone = member.text or member.kind == "enum" or not groups or groups[-1][-1].kind != member.kind
        if is_alone:
            groups.append([member])
        else:
            groups[-1].append(member)
    return groups


def code_block(language, lines):
    return f"```{language}\n" + "\n".join(lines) + "\n```"


def section_of_group(group, language, level):
    names = list(dict.fromkeys(m.name for m in group))
    title = ", ".join(f"`{name}`" for name in names[:3]) + (", ..." if len(names) > 3 else "")
    parts = ["#" * level + " " + title, code_block(language, [m.code for m in group]), group[0].text]
    if group[0].values:
        parts.append(table(group[0].values))
    return "\n\n".join(filter(None, parts))


def section_of_compound(compound, language, level):
    parts = ["#" * level + f" `{compound.name}`", code_block(language, [compound.code + ";"]), compound.text]
    values = [m for m in compound.members if m.kind == "variable"]
    if values:
        parts.append(table([(m.code.rstrip(";"), m.text) for m in values]))
    for group in grouped([m for m in compound.members if m.kind != "variable"]):
        parts.append(section_of_group(group, language, level + 1))
    return "\n\n".join(filter(None, parts))


def head_of(path):
    """The comment at the head of a header of C, as Markdown."""
    match = HEAD.search(path.read_text())
    if not match:
        return ""
    text = "\n".join(line[3:] for line in match.group(1).split("\n"))
    return re.sub(r"^([A-Z]{5,})([. ])", lambda m: f"**{NAMES.get(m.group(1), m.group(1).capitalize())}**{m.group(2)}", escaped(text), flags=re.M)


def read(headers, folder, language, warnings):
    """The members and compounds of each header, by its name."""
    (folder / "headers").mkdir(parents=True)
    for header in headers:
        (folder / "headers" / header.name).write_text(commented(header.read_text(), language == "c"))
    (folder / "Doxyfile").write_text(DOXYFILE.format(folder=folder) + f"OPTIMIZE_OUTPUT_FOR_C = {'YES' if language == 'c' else 'NO'}\n")
    made = subprocess.run(["doxygen", folder / "Doxyfile"], capture_output=True, text=True, check=True)
    warnings.extend(line for line in made.stderr.splitlines() if "warning:" in line)
    found = {header.name: [] for header in headers}
    seen = set()
    for path in sorted((folder / "xml").glob("*.xml")):
        for node in ElementTree.parse(path).getroot().iter("compounddef"):
            name = flat(node.find("compoundname"))
            if re.search(r"\b(detail|std)\b", name) or node.get("prot") == "private":
                continue
            if node.get("kind") in ("struct", "class"):
                compound = Compound(node, language)
                found[pathlib.Path(compound.file).name].append(compound)
            elif node.get("kind") in ("namespace", "file"):
                for section in node.findall("sectiondef"):
                    for member in section.findall("memberdef"):
                        place = member.find("location")
                        key = (place.get("file"), place.get("line"), flat(member.find("name")))
                        if key not in seen and key[2] not in ("CLSDF_API", "CLSDF_EXPORT"):
                            seen.add(key)
                            found[pathlib.Path(place.get("file")).name].append(Member(member, language))
    for header in headers:
        lines = commented(header.read_text(), language == "c").split("\n")
        for member in found[header.name]:
            if member.kind == "define" and re.fullmatch(r"( \*|/\*\*) .*\*/", lines[member.line - 2]):
                beside = re.search(r"/\*\*< (.*?)( \*/|$)", lines[member.line - 1])
                at = member.text.rfind(escaped(beside.group(1).replace("\\", ""))) if beside else len(member.text)
                member.above = member.text[:at].strip()
    return found


def page(title, include, head, members, language, sections=()):
    """`sections` are the lines and titles of parts of the header."""
    parts = [f"# {title}", head, code_block(language, [f"#include <{include}>"])]
    level = 3 if sections else 2
    members = sorted(members, key=lambda m: m.line)
    plain, numbers = [], []

    def flush():
        if numbers:
            names = [m.name for m in numbers]
            parts.append("#" * level + f" `{names[0]}`" + (f" to `{names[-1]}`" if len(names) > 1 else ""))
            parts.append(numbers[0].above)
            parts.append(table([(m.code.removeprefix("#define "), m.text.removeprefix(m.above)) for m in numbers]))
        for group in grouped(plain):
            parts.append(section_of_group(group, language, level))
        plain.clear()
        numbers.clear()

    sections = list(sections)
    for member in members:
        if sections and sections[0][0] < member.line:
            flush()
            while len(sections) > 1 and sections[1][0] < member.line:
                sections.pop(0)
            parts.append(f"## {sections.pop(0)[1]}")
        is_number = member.kind == "define" and "(" not in member.code.split(" ")[1]
        if isinstance(member, Compound):
            flush()
            parts.append(section_of_compound(member, language, level))
        elif is_number:
            if plain or member.above:
                flush()
            numbers.append(member)
        else:
            if numbers:
                flush()
            plain.append(member)
    flush()
    return "\n\n".join(filter(None, parts)) + "\n"


def sections_of(path):
    """The lines and titles of the parts of a header of C, as it is read: without its head."""
    text = HEAD.sub("", path.read_text(), count=1)
    return [(text.count("\n", 0, m.start()) + 1, m.group(1)) for m in SECTION.finditer(text)]
