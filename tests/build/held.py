"""held.py SOURCE SCRATCH: scripts/nightly in a repository of its own, with stand-ins for CMake and CTest.

It promises: the order (failed, changed, oldest), a row for each test that ended, none of a tree with changes, and a run
that goes on where the last one ended.
"""

import json
import os
import pathlib
import shutil
import subprocess
import sys
import unittest

SOURCE, SCRATCH = pathlib.Path(sys.argv[1]), pathlib.Path(sys.argv[2])

# Tests by preset: the labels, and the file whose contents decide the outcome.
TESTS = {"release": ["core", "points", "segments"], "sanitize": ["core", "points", "segments"]}

CTEST = """#!/usr/bin/env python3
import json, pathlib, re, sys, time
tree = pathlib.Path(sys.argv[sys.argv.index("--test-dir") + 1])
names = TESTS.get(tree.name, [])
if "--show-only=json-v1" in sys.argv:
    gone = pathlib.Path("outcome", "gone")
    names = [n for n in names if not gone.exists() or n not in gone.read_text()]
    print(json.dumps({"tests": [{"name": n + "_test", "properties": [{"name": "LABELS", "value": [n]}]} for n in names]}))
    sys.exit()
if pathlib.Path("outcome", "dies").exists():
    sys.exit(8)
wanted = re.compile(sys.argv[sys.argv.index("-R") + 1])
with open("calls.txt", "a") as calls:
    for number, name in enumerate(n for n in names if wanted.match(n + "_test")):
        calls.write(f"{tree.name} {name}\\n")
        calls.flush()
        outcome = pathlib.Path("outcome", tree.name, name)
        text = outcome.read_text().strip() if outcome.exists() else "Passed"
        print(f"      Start {number}: {name}_test", flush=True)
        if text == "hangs":
            time.sleep(60)
        print(f"    {number + 1}/9 Test #{number}: {name}_test ....   {text}    0.25 sec", flush=True)
"""


class Held(unittest.TestCase):
    def setUp(self):
        self.tree = SCRATCH / self.id().rpartition(".")[2]
        shutil.rmtree(self.tree, ignore_errors=True)
        for folder in ("scripts", "programs", "benchmarks", "lib/segments", "lib/points", "lib/foundations/core", "kernels/points"):
            (self.tree / folder).mkdir(parents=True)
        shutil.copy(SOURCE / "scripts" / "nightly", self.tree / "scripts")
        self.file("lib/foundations/core/a.hpp", "")
        self.file("lib/points/a.cpp", '#include "core/a.hpp"\n')
        self.file("lib/segments/a.cpp", '#include "points/a.hpp"\n')
        self.file(".gitignore", "/build/\n/programs/\n/outcome/\n/calls.txt\n/home/\n")
        for name, text in (("ctest", CTEST.replace("TESTS", repr(TESTS))), ("cmake", "#!/bin/sh\n[ \"$1\" != --build ] || [ ! -e outcome/unbuilt ]\n")):
            self.file(f"programs/{name}", text)
            (self.tree / "programs" / name).chmod(0o755)
        self.git("init", "--quiet", "--initial-branch=main")
        self.commit("first")

    def file(self, path, text):
        (self.tree / path).parent.mkdir(parents=True, exist_ok=True)
        (self.tree / path).write_text(text)

    def git(self, *arguments, text=None):
        return subprocess.run(["git", "-c", "user.name=a", "-c", "user.email=a@b", *arguments], cwd=self.tree, check=True,
                              input=text, stdout=subprocess.PIPE, text=True).stdout.strip()

    def commit(self, message):
        self.git("add", ".")
        self.git("commit", "--quiet", "--allow-empty", f"--message={message}")
        return self.git("rev-parse", "--short=8", "HEAD")

    def night(self, *arguments, kinds=("release", "address")):
        options = [option for kind in kinds for option in ("--kind", kind)]
        return subprocess.run([sys.executable, "scripts/nightly", *options, *arguments], cwd=self.tree, text=True,
                              stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                              env={**os.environ, "PATH": f"{self.tree}/programs:{os.environ['PATH']}"})

    def rows(self):
        lines = (self.tree / "benchmarks/HELD.tsv").read_text().splitlines()
        self.assertEqual(lines[1:], sorted(lines[1:]))
        return {tuple(line.split("\t")[:2]): line.split("\t")[2:] for line in lines[1:]}

    def calls(self):
        calls = self.tree / "calls.txt"
        called = calls.read_text().split("\n")[:-1] if calls.exists() else []
        calls.unlink(missing_ok=True)
        return called

    def test_every_test_of_a_kind_gets_a_row_with_its_commit(self):
        head = self.git("rev-parse", "--short=8", "HEAD")
        self.file("outcome/sanitize/points", "***Failed")
        self.file("outcome/release/core", "***Skipped")
        run = self.night()
        self.assertEqual(run.returncode, 1, run.stdout)
        self.assertEqual(self.rows(), {
            ("address", "core_test"): [head, "0.2", "passed"], ("address", "points_test"): [head, "0.2", f"failed at {head}"],
            ("address", "segments_test"): [head, "0.2", "passed"], ("release", "core_test"): [head, "0.2", "skipped"],
            ("release", "points_test"): [head, "0.2", "passed"], ("release", "segments_test"): [head, "0.2", "passed"]})
        page = (self.tree / "benchmarks/NIGHTLY.md").read_text()
        self.assertIn("| points | 0 | **fails** |", page)
        self.assertIn(f"Fails: address points_test, failed at {head}.", page)
        self.assertLessEqual(len(page.splitlines()), 60)

    def test_failed_rows_come_first_then_those_with_changes_then_the_oldest(self):
        self.file("outcome/release/segments", "***Failed")
        self.night(kinds=["release"])
        self.commit("rows")
        self.calls()
        # What points includes has changed; nothing that core has.
        self.file("lib/points/a.cpp", '#include "core/a.hpp"\n\n')
        self.commit("points")
        listed = self.night("--list", kinds=["release"]).stdout.splitlines()
        self.assertEqual([line.split(":")[0] for line in listed], ["release segments_test", "release points_test", "release core_test"])
        # What all include has.
        self.file("lib/foundations/core/a.hpp", "\n")
        self.file("outcome/release/segments", "Passed")
        self.commit("core")
        self.night("--only", "points", kinds=["release"])
        self.assertEqual(self.calls(), ["release points"])
        listed = self.night("--list", kinds=["release"]).stdout.splitlines()
        self.assertEqual([line.split(":")[0] for line in listed], ["release segments_test", "release core_test", "release points_test"])

    def test_a_run_that_is_ended_loses_one_test_and_the_next_one_begins_with_it(self):
        self.file("outcome/release/points", "hangs")
        run = self.night("--minutes", "0.05", kinds=["release"])
        self.assertIn("The time is over", run.stdout)
        rows = self.rows()
        self.assertEqual([rows["release", f"{name}_test"][2] for name in TESTS["release"]], ["passed", "waiting", "waiting"])
        self.assertEqual(self.calls(), ["release core", "release points"])
        self.file("outcome/release/points", "Passed")
        shutil.rmtree(self.tree / "build")
        listed = self.night("--list", kinds=["release"]).stdout.splitlines()
        self.assertEqual([line.split(":")[0] for line in listed], ["release points_test", "release segments_test", "release core_test"])
        self.night(kinds=["release"])
        self.assertEqual({row[2] for row in self.rows().values()}, {"passed"})

    def test_a_test_that_is_longer_than_a_run_waits_for_a_longer_one(self):
        self.file("outcome/release/core", "hangs")
        self.night("--minutes", "0.1", kinds=["release"])
        self.assertGreater(float(self.rows()["release", "core_test"][1]), 1)
        self.calls()
        run = self.night("--minutes", "0.05", kinds=["release"])
        self.assertEqual(self.calls(), ["release points", "release segments"])
        self.assertEqual(run.returncode, 3, run.stdout)
        self.assertIn("NOT RUN: 1 rows", run.stdout)

    def test_nothing_is_written_while_sources_are_changed(self):
        self.file("lib/points/a.cpp", "int changed;\n")
        run = self.night(kinds=["release"])
        self.assertIn("not written", run.stdout)
        self.assertFalse((self.tree / "benchmarks/HELD.tsv").exists())

    def test_what_cannot_be_built_or_run_fails_and_keeps_its_seconds(self):
        self.night(kinds=["release"])
        for way in ("unbuilt", "dies"):
            self.file(f"outcome/{way}", "")
            run = self.night(kinds=["release"])
            self.assertEqual(run.returncode, 1, run.stdout)
            self.assertEqual({(row[1], row[2].split(" at ")[0]) for row in self.rows().values()}, {("0.2", "failed")})
            (self.tree / "outcome" / way).unlink()
            self.night(kinds=["release"])
            self.assertEqual({row[2] for row in self.rows().values()}, {"passed"})

    def test_a_skipped_test_stays_failed_and_one_that_this_machine_lacks_keeps_its_row(self):
        self.file("outcome/release/core", "***Failed")
        self.night(kinds=["release"])
        self.file("outcome/release/core", "***Skipped")
        self.file("outcome/gone", "points")
        self.night(kinds=["release"])
        rows = self.rows()
        self.assertTrue(rows["release", "core_test"][2].startswith("failed at"))
        self.assertEqual(rows["release", "points_test"][2], "passed")
        self.night("--page", kinds=["release"])
        self.assertEqual(self.rows(), rows)
        self.night("--forget", kinds=["release"])
        self.assertNotIn(("release", "points_test"), self.rows())

    def test_rows_that_passed_too_long_ago_are_named(self):
        self.night()
        self.commit("rows")
        self.assertEqual(self.night("--oldest", "3", kinds=()).returncode, 0)
        head = self.git("rev-parse", "HEAD")
        history = [f"commit refs/heads/main\ncommitter a <a@b> {number} +0000\ndata 0\n" + (f"from {head}\n" if number == 0 else "")
                   for number in range(601)]
        self.git("fast-import", "--quiet", "--force", text="\n".join(history) + "\n")
        self.night(kinds=["address"])
        run = self.night("--oldest", "3", kinds=())
        self.assertEqual(run.returncode, 1)
        self.assertEqual(len(run.stdout.splitlines()), 4, run.stdout)
        self.assertTrue(run.stdout.startswith("   602 commits ago: release"), run.stdout)

    def test_a_commit_that_is_not_known_is_told(self):
        self.night()
        record = self.tree / "benchmarks/HELD.tsv"
        record.write_text(record.read_text().replace(self.git("rev-parse", "--short=8", "HEAD"), "01234567"))
        run = self.night("--oldest", "1", kinds=())
        self.assertEqual(run.returncode, 1)
        self.assertIn("01234567 of 6 rows", run.stdout)

    def test_a_kind_that_is_none_is_refused(self):
        run = self.night(kinds=["nonsense"])
        self.assertEqual(run.returncode, 2)
        self.assertIn("release, address, threads", run.stdout)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
