# SPDX-License-Identifier: Apache-2.0
"""Nothing of one developer's machine is in the tree: no absolute path of a home, a scratch
or a checkout folder, in text of any kind; and no link that leads out of the tree.
"""

import os
import re

from source_tree import TreeTest, files, run, text_of

# Whole path components, not a part of an address or of a longer path
PLACES = ("ho" + "me", "Us" + "ers", "ro" + "ot", "wo" + "rk", "t" + "mp", "m" + "nt", "me" + "dia")
PATH = re.compile(r"(?<![\w.:/$}~*)-])(?:/(?:" + "|".join(PLACES) + r")/\w[^\s\"'`,;)]*"
                  r"|[A-Z]:\\+" + PLACES[1] + r"\b)")


def check(root):
    problems = []
    for path in files(root):
        name = path.relative_to(root).as_posix()
        if path.is_symlink():
            target = (path.parent / os.readlink(path)).resolve()
            if not target.is_relative_to(root.resolve()):
                problems.append(f"{name}: is a link that leads out of the project")
            continue
        for number, line in enumerate((text_of(path) or "").splitlines(), 1):
            found = PATH.search(line)
            if found:
                problems.append(f"{name}:{number}: {found.group()} is a path of one machine")
    return problems


class SelfTest(TreeTest):
    def test_takes_paths_of_the_project_and_of_every_system(self):
        self.assertEqual(check(self.tree({
            "docs/a.md": f"relight/base/a.h, https://a.org/{PLACES[0]}/x, /usr/local, ${{HOME}}/x, "
                         f"build/{PLACES[4]}/x, ../{PLACES[3]}/x, "
                         f"either/or and/{PLACES[4]}/x\n"})), [])

    def test_finds_paths_of_one_machine(self):
        for place in PLACES:
            self.assert_one(check(self.tree({"cli/a.cpp": f'\nOpen("/{place}/someone/x.jpg");\n'})),
                            "cli/a.cpp:2", f"/{place}/someone/x.jpg")
        drive = "C:" + chr(92) + PLACES[1] + chr(92) + "x"
        self.assert_one(check(self.tree({"samples/capture.toml": f"p = '{drive}'\n"})), "C:")

    def test_finds_a_link_out_of_the_tree(self):
        root = self.tree({"docs/a.md": ""})
        (root / "docs/b.md").symlink_to("a.md")
        self.assertEqual(check(root), [])
        (root / "docs/c.md").symlink_to(self.tree({"elsewhere.md": ""}) / "elsewhere.md")
        self.assert_one(check(root), "docs/c.md", "leads out")


if __name__ == "__main__":
    run(check, SelfTest)
