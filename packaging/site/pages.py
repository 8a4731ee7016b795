"""Gathers the pages of the site: the documents as they are, the first screen, the interfaces from their comments, the
examples, and llms.txt. It needs nothing but Python and, for the headers, Doxygen.

usage: pages.py SOURCES FOLDER [BUILD]

Ends with status 1 if a link leads nowhere, if a page is in no table of contents, or if the first screen shows code that no
tested document has.
"""

import pathlib
import posixpath
import re
import shutil
import subprocess
import sys

import chart
import cpp
import fortran
import python

LINK = re.compile(r"(\]\()([^)\s#]+)(#[^)\s]*)?(\))")
LANGUAGES = {".cpp": "cpp", ".hpp": "cpp", ".cl": "c", ".c": "c", ".h": "c", ".f90": "fortran", ".F90": "fortran", ".py": "python",
             ".cmake": "cmake", ".txt": "cmake", ".bash": "sh"}
# Where each language's lines of the first screen are tested; the install lines of sh.
TESTED = {"cpp": ["README.md"], "python": ["docs/python.md"], "c": ["docs/c.md"], "fortran": ["docs/fortran.md"],
          "sh": ["README.md", "docs/install.md", "docs/python.md"]}
EXAMPLES = {"C++": ("examples", ".cpp"), "C": ("bindings/c/examples", ".c"), "Fortran": ("bindings/fortran/examples", ".f90"),
            "With other programs": ("integrations", ".cpp .c .F90 .py")}
CONTENTS = {
    "Start": "docs/install docs/library docs/recipes docs/command docs/errors docs/devices docs/gpu examples/index",
    "Languages": "docs/python docs/c docs/fortran",
    "What the numbers mean": "docs/grids-and-bands docs/sign docs/accuracy docs/outer docs/formats",
    "More than a grid": "docs/segments docs/rays docs/sparse docs/scenes docs/fractions docs/time-steps docs/learning docs/pictures",
    "In a simulation": "docs/parallel docs/cuda docs/petsc docs/dealii docs/amrex docs/flow",
    "Interfaces": "interfaces/cpp interfaces/c interfaces/fortran interfaces/python",
    "Inside": "docs/method docs/papers docs/architecture docs/benchmarks benchmarks/RESULTS docs/conformance conformance/README "
              "CONTRIBUTING",
    "About": "CHANGELOG docs/licences LICENSE",
}
RECORDS = "benchmarks/ACCEPTANCE benchmarks/GPU-COMPILERS benchmarks/NIGHTLY benchmarks/REAL-MESHES benchmarks/TRIED"


class Site:
    def __init__(self, sources, folder, build):
        self.sources, self.folder, self.build = sources, folder, build
        self.faults, self.listings, self.made = [], set(), set()

    def write(self, name, text):
        path = self.folder / name
        self.made.add(name)
        if path.exists() and path.read_text() == text:
            return  # what has not changed is not read again
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def linked(self, name, text):
        """The text of a page with links to files of the sources led to their pages."""
        def replaced(match):
            target = match.group(2)
            if re.match(r"[a-z]+:", target):
                return match.group(0)
            path = (self.sources / name).parent / target
            if not path.exists():
                self.faults.append(f"{name}: {target} does not exist")
                return match.group(0)
            path = path.resolve().relative_to(self.sources.resolve())
            place = str(path)
            if (self.sources / path).is_dir():
                place = "examples/index.md" if path.name == "examples" else self.listing(path)
            elif path.suffix == ".png":
                self.copy(place)
            elif place == "README.md":
                place = "index.md"
            elif path.suffix != ".md":
                place = self.listing(path)
            up = "../" * (len(pathlib.PurePath(name).parts) - 1)
            return match.group(1) + up + place + (match.group(3) or "") + match.group(4)

        parts = re.split(r"(^```.*?^```|`[^`\n]*`)", text, flags=re.S | re.M)
        return "".join(part if i % 2 else LINK.sub(replaced, part) for i, part in enumerate(parts))

    def copy(self, name, place=None):
        path = self.folder / (place or name)
        self.made.add(place or name)
        path.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(self.sources / name, path)

    def listing(self, path):
        """The page of a file or folder that a page links, and that is none itself."""
        if path.name == "LICENSE":
            return "LICENSE.md"
        if path.parent.name == "examples" and path.suffix in LANGUAGES:
            return f"{path.with_suffix('')}-{path.suffix[1:]}.md"
        place = f"files/{path}.md"
        if place not in self.made:
            source = self.sources / path
            if source.is_dir():
                text = "\n".join(sorted(child.name + "/" * child.is_dir() for child in source.iterdir()))
            else:
                text = source.read_text(errors="replace")
            self.write(place, f"---\norphan: true\n---\n\n# {path}\n\n" + cpp.code_block(LANGUAGES.get(path.suffix, "text"), [text]))
        return place

    def documents(self):
        names = [f"docs/{path.name}" for path in sorted((self.sources / "docs").glob("*.md"))]
        names += [f"benchmarks/{path.name}" for path in sorted((self.sources / "benchmarks").glob("*.md"))]
        for name in [*names, "conformance/README.md", "CHANGELOG.md", "CONTRIBUTING.md"]:
            text = self.linked(name, (self.sources / name).read_text())
            self.write(name, f"---\norphan: true\n---\n\n{text}" if name.removesuffix(".md") in RECORDS.split() else text)
        self.write("LICENSE.md", "# Licence\n\n" + cpp.code_block("text", [(self.sources / "LICENSE").read_text().rstrip()]))

    def interfaces(self):
        warnings = []
        work = self.folder / "_doxygen"
        shutil.rmtree(work, ignore_errors=True)
        headers = sorted((self.sources / "lib/include/clsdf").glob("*.h*"))
        headers = [h for h in headers if h.name not in ("export.hpp", "clsdf.hpp")]
        c_include = self.sources / "bindings/c/include"
        parts = re.findall(r'^#include "(clsdf/c/.*)"', (c_include / "clsdf.h").read_text(), re.M)
        c_headers = [c_include / name for name in ("clsdf.h", *parts, "clsdf_io.h")]
        listed = {"cpp": [], "c": [], "fortran": []}
        if shutil.which("doxygen"):
            for language, files in (("cpp", headers), ("c", c_headers)):
                found = cpp.read(files, work / language, language, warnings)
                for header in files:
                    is_c = language == "c"
                    name = f"{language}-{header.stem.replace('_', '-')}"
                    is_part = is_c and header.parent != c_include
                    include = "clsdf.h" if is_part else header.name if is_c else f"clsdf/{header.name}"
                    text = cpp.page(str(header.relative_to(c_include)) if is_c else header.name, include,
                                    cpp.head_of(header) if is_c else "", found[header.name], language,
                                    cpp.sections_of(header) if is_c else ())
                    self.write(f"interfaces/{name}.md", f"---\ntocdepth: 2\n---\n\n{text}")
                    listed[language].append(name)
            shutil.rmtree(work)
        else:
            print("pages.py: doxygen is not installed, so the site has no pages of the headers", file=sys.stderr)
        for name in ("clsdf", "clsdf_io"):
            text = fortran.Module(self.sources / f"bindings/fortran/{name}.f90").page(name)
            self.write(f"interfaces/fortran-{name.replace('_', '-')}.md", f"---\ntocdepth: 2\n---\n\n{text}")
            listed["fortran"].append(f"fortran-{name.replace('_', '-')}")
        stubs = sorted(self.build.glob("python/**/_core.pyi")) if self.build else []
        self.write("interfaces/python.md", python.page(self.sources / "bindings/python/clsdf", stubs[0] if stubs else None))
        guides = {"cpp": ("C++", "library"), "c": ("C", "c"), "fortran": ("Fortran", "fortran")}
        for language, names in listed.items():
            title, guide = guides[language]
            self.write(f"interfaces/{language}.md", f"# {title}'s interface\n\nFrom the comments of the "
                       f"{'modules' if language == 'fortran' else 'headers'}; whole programs are in [its page](../docs/{guide}.md).\n\n"
                       "```{toctree}\n:maxdepth: 1\n\n" + "\n".join(names) + "\n```\n")
        self.faults += warnings

    def examples(self):
        groups = []
        for title, (folder, endings) in EXAMPLES.items():
            paths = sorted(p for p in (self.sources / folder).rglob("*") if p.suffix in endings.split() and "tests" not in p.parts
                           and "include" not in p.parts and p.stem not in ("example", "CMakeLists"))
            names = []
            for path in paths:
                name = str(path.relative_to(self.sources))
                place = self.listing(path.relative_to(self.sources)) if path.parent.name == "examples" else f"{name}.md"
                text, code = self.head_of(path)
                output = self.output_of(path)
                parts = [f"# {path.stem.replace('_', ' ').capitalize()}", text, cpp.code_block(LANGUAGES[path.suffix], [code.strip()])]
                if output:
                    parts += ["It prints, on a machine of two cores:", cpp.code_block("text", [output])]
                self.write(place, "\n\n".join(filter(None, parts)) + "\n")
                names.append(f"../{place.removesuffix('.md')}")
            groups.append(f"## {title}\n\n```{{toctree}}\n:maxdepth: 1\n\n" + "\n".join(names) + "\n```")
        pictures = ("Pictures of fields, with the commands that draw them: [pictures](../docs/pictures.md). "
                    "Short programs for single tasks: [recipes](../docs/recipes.md).")
        self.write("examples/index.md", "# Examples\n\nPrograms that a simulation code could start from. Each checks its own result, "
                   f"and is a test.\n\n{pictures}\n\n" + "\n\n".join(groups) + "\n")

    @staticmethod
    def head_of(path):
        """The comment at the head of a program, as Markdown, and the rest."""
        source = path.read_text()
        if path.suffix == ".py":
            match = re.match(r'(?:#!.*\n)?"""(.*?)"""\n', source, re.S)
            text = match.group(1) if match else ""
        else:
            match = re.match(r"(?:(?://|!>?) ?.*\n)+|/\*.*?\*/\n", source, re.S if source.startswith("/*") else 0)
            text = re.sub(r"^(// ?|!>? ?|/\* ?| \*/? ?)|\*/$", "", match.group(0), flags=re.M) if match else ""
        paragraphs = []
        for paragraph in text.strip().split("\n\n"):
            is_command = re.match(r"(mpirun|example_|\w+ \[|usage:)", paragraph)
            paragraphs.append(cpp.code_block("text", [paragraph]) if is_command else cpp.escaped(paragraph))
        return "\n\n".join(paragraphs), source[match.end():] if match else source

    def output_of(self, path):
        """What a built example in C++ prints; nothing without a build."""
        program = self.build / "examples" / f"example_{path.stem}" if self.build and path.suffix == ".cpp" else None
        if program is None or not program.exists() or "mpi.h" in path.read_text():
            return ""
        work = self.folder / "_run"
        work.mkdir(exist_ok=True)
        try:
            ran = subprocess.run([program], cwd=work, capture_output=True, text=True, timeout=60)
        except subprocess.TimeoutExpired:
            return ""
        shutil.rmtree(work)
        if ran.returncode != 0:
            self.faults.append(f"{path.name} ends with {ran.returncode}: {ran.stderr}")
        return ran.stdout.strip()

    def first_screen(self):
        readme = (self.sources / "README.md").read_text()
        text = (self.sources / "packaging/site/index.md").read_text()
        for language, code in re.findall(r"^[`~]{3}(cpp|python|c|fortran|sh)\n(.*?)^[`~]{3}", text, re.S | re.M):
            tested = "\n".join((self.sources / page).read_text() for page in TESTED[language])
            lines = {line.split("  #")[0].strip() for line in tested.split("\n")}
            for line in code.strip().split("\n"):
                if line.split("  #")[0].strip() not in lines:
                    self.faults.append(f"index.md: no tested document has the line: {line}")
        drawn = chart.chart_of(readme)
        caption = ("Stanford bunny, 256^3 samples, a half width of 10%, two cores of an Intel Xeon, and one GPU "
                   "([what is timed](docs/benchmarks.md), [figures](benchmarks/RESULTS.md)). Lower and further left is better.")
        text = text.replace("CHART", f"```{{raw}} html\n{drawn}\n```\n\n{caption}")
        rest = readme[readme.index("## Pick it if"):readme.index("## Read on")]
        contents = [f"```{{toctree}}\n:hidden:\n:caption: {title}\n\n{pages.replace(' ', chr(10))}\n```" for title, pages in CONTENTS.items()]
        self.write("index.md", self.linked("index.md", text) + self.linked("README.md", rest) + "\n" + "\n\n".join(contents) + "\n")
        self.copy("docs/images/bunny_cut.png")

    def list_for_models(self):
        """llms.txt: a line for each page, with its first sentence; the pages are Markdown there."""
        lines = ["# clsdf", "", "> Exact signed distance fields of triangle meshes, on any processor and, by OpenCL, on GPUs. MIT licence. "
                 "C++, C, Fortran, Python and a command.", ""]
        for title, names in CONTENTS.items():
            lines += [f"## {title}", ""]
            for name in names.split():
                text = (self.folder / f"{name}.md").read_text()
                heading = re.search(r"^# (.*)", text, re.M).group(1)
                paragraphs = [" ".join(part.split()) for part in re.sub(r"^```.*?^```", "", text, flags=re.S | re.M).split("\n\n")]
                prose = next((part for part in paragraphs if part[:1] not in "#|-<:!"), "")
                first = re.sub(r"\*\*|\\", "", re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", prose))
                sentence = re.match(r".*?[.:](?= [A-Z]|$)|.*", first).group(0)
                lines.append(f"- [{heading}](_sources/{name}.md)" + (f": {sentence}" if sentence else ""))
            lines.append("")
        self.write("_extra/llms.txt", "\n".join(lines))

    def check_contents(self):
        """Each page is in a table of contents or says that it is in none, and the tables name pages: Sphinx warns of others."""
        pages = {name.removesuffix(".md"): (self.folder / name).read_text() for name in self.made if name.endswith(".md")}
        listed = {"index"}
        for page, text in pages.items():
            for table in re.findall(r"^```\{toctree\}\n(.*?)^```", text, re.S | re.M):
                for name in re.findall(r"^[^:\s].*", table, re.M):
                    name = posixpath.normpath(posixpath.join(posixpath.dirname(page), name))
                    listed.add(name)
                    if name not in pages:
                        self.faults.append(f"{page}.md: its table of contents names {name}, which is no page")
        for page in sorted(pages.keys() - listed):
            if not pages[page].startswith("---\norphan: true\n"):
                self.faults.append(f"{page}.md is in no table of contents: add it to CONTENTS or to RECORDS of pages.py")

    def make(self):
        self.documents()
        self.interfaces()
        self.examples()
        self.first_screen()
        self.check_contents()
        if not self.faults:
            self.list_for_models()
        self.copy("packaging/site/conf.py", "conf.py")
        self.copy("packaging/site/site.css", "_static/site.css")
        for path in sorted(self.folder.rglob("*")):
            if path.is_file() and str(path.relative_to(self.folder)) not in self.made:
                path.unlink()  # of an earlier run


def main():
    if len(sys.argv) not in (3, 4):
        print(__doc__.strip(), file=sys.stderr)
        return 2
    site = Site(*(pathlib.Path(word) for word in sys.argv[1:3]), pathlib.Path(sys.argv[3]) if len(sys.argv) > 3 else None)
    site.make()
    for fault in site.faults:
        print(f"pages.py: {fault}", file=sys.stderr)
    return 1 if site.faults else 0


if __name__ == "__main__":
    sys.exit(main())
