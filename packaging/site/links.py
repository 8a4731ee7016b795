"""Follows every link, picture, script and style of the pages in a folder, with its anchor, and the links of llms.txt. Links
to other sites are counted and not followed.

usage: links.py FOLDER

Ends with status 1 if a link leads nowhere.
"""

import html.parser
import pathlib
import re
import sys
import urllib.parse


class Page(html.parser.HTMLParser):
    def __init__(self, text):
        super().__init__()
        self.anchors, self.links = {"", "top"}, []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        values = dict(attributes)
        self.anchors |= {value for name, value in attributes if name in ("id", "name") and value}
        self.links += [values[name] for name in ("href", "src") if values.get(name)]


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(__doc__.strip(), file=sys.stderr)
        return 2
    folder = pathlib.Path(sys.argv[1]).resolve()
    pages = {path: Page(path.read_text()) for path in folder.rglob("*.html")}
    links = [(path, link) for path, page in pages.items() for link in page.links]
    for target in re.findall(r"\]\(([^)]*)\)", (folder / "llms.txt").read_text()):
        links.append((folder / "llms.txt", target))
    others, faults = 0, []
    for path, link in links:
        if re.match(r"[a-z]+:|//", link):
            others += 1
            continue
        place, _, anchor = link.partition("#")
        target = (path.parent / urllib.parse.unquote(place.partition("?")[0])).resolve() if place else path
        if not target.is_file():
            faults.append(f"{path.relative_to(folder)}: {link} is no file")
        elif target in pages and urllib.parse.unquote(anchor) not in pages[target].anchors:
            faults.append(f"{path.relative_to(folder)}: {link} has no such anchor")
    for fault in faults:
        print(f"links.py: {fault}", file=sys.stderr)
    print(f"{len(pages)} pages, {len(links) - others} links within them, {len(faults)} of them broken; {others} to other sites")
    return 1 if faults or not pages else 0


if __name__ == "__main__":
    sys.exit(main())
