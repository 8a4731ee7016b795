"""make_set.py SOURCES FOLDER: makes the conformance set, which has the digest of SOURCES/DIGEST and an archive below 1 MB
of the same bytes every time."""

import pathlib
import sys

sources, folder = map(pathlib.Path, sys.argv[1:])
sys.path.insert(0, str(sources))
import make  # noqa: E402

contents = list(make.files())
for name, content in contents:
    path = folder / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(content)
digest, expected = make.digest(contents), (sources / "DIGEST").read_text().strip()
archive = make.archive(contents)
faults = []
if digest != expected:
    faults.append(f"the digest is {digest}, and DIGEST has {expected}: if the cases changed, scripts/conformance --digest")
if archive != make.archive(contents) or len(archive) >= 1_000_000:
    faults.append(f"the archive has {len(archive)} bytes, or others when it is made again")
if len(make.CASES) < 60 or len({case.name for case in make.CASES}) != len(make.CASES):
    faults.append(f"there are {len(make.CASES)} cases, or two of the same name")
sys.exit("\n".join(faults) or None)
