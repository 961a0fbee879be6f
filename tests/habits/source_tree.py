# SPDX-License-Identifier: Apache-2.0
"""The source tree as the habit checks see it, and the frame they share.

A check is a function root -> list of problems, each one line "path:line: what is wrong".
"""

import pathlib
import re
import sys
import tempfile
import unittest

FOLDERS = ("relight", "matting", "cli", "plugin_gimp", "tests", "samples", "docs", ".ci")
CPP = (".h", ".cpp")


def files(root, suffixes=None):
    """Every file of the project, sorted; build results and git's own are not part of it."""
    root = pathlib.Path(root)
    found = [p for p in root.iterdir() if p.is_file()] if root.is_dir() else []
    for folder in FOLDERS:
        found += [p for p in (root / folder).rglob("*") if p.is_file()]
    found = [p for p in found if "__pycache__" not in p.parts]
    return sorted(p for p in found if suffixes is None or p.suffix in suffixes)


def text_of(path):
    """The text of a file, or None when it is not text (a picture, a volume)."""
    data = path.read_bytes()
    if b"\0" in data[:4096]:
        return None
    try:
        return data.decode("utf-8")
    except UnicodeDecodeError:
        return None


def stages(root):
    """The folders of RELIGHT_STAGES in the top CMakeLists.txt, in order."""
    text = (pathlib.Path(root) / "CMakeLists.txt").read_text()
    found = re.search(r"set\(RELIGHT_STAGES\s+([^)]*)\)", text)
    if not found:
        raise SystemExit(f"{root}/CMakeLists.txt: has no set(RELIGHT_STAGES …)")
    return found.group(1).split()


def stage_of(path, order):
    """The stage that a path below the root belongs to, or None."""
    path = pathlib.PurePosixPath(path)
    for stage in order:
        if path.is_relative_to(stage):
            return stage
    return None


def run(check, self_tests):
    """The whole of a script: `x_test.py ROOT`, or `x_test.py --self-test`."""
    if sys.argv[1:] == ["--self-test"]:
        suite = unittest.defaultTestLoader.loadTestsFromTestCase(self_tests)
        sys.exit(0 if unittest.TextTestRunner().run(suite).wasSuccessful() else 1)
    here = pathlib.Path(__file__).resolve().parents[2]
    problems = check(pathlib.Path(sys.argv[1]) if sys.argv[1:] else here)
    if problems:
        print("\n".join(problems))
    sys.exit(1 if problems else 0)


class TreeTest(unittest.TestCase):
    """A self-test that writes a small source tree: tree({path: text}) gives its root."""

    def tree(self, contents):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        root = pathlib.Path(folder.name)
        for path, text in contents.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text)
        return root

    def assert_one(self, problems, *words):
        """Exactly one problem, and it says all of these words."""
        self.assertEqual(len(problems), 1, problems)
        for word in words:
            self.assertIn(word, problems[0])
