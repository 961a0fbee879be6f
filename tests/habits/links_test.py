# SPDX-License-Identifier: Apache-2.0
"""Pointers lead somewhere.

A link of a page names a file of the project, seen from the page, and a place in it that
exists: an <a id="place"></a> or a heading. So does docs/page.md#place in the comments of code,
seen from the root. Addresses of the web are not followed.
"""

import re

from source_tree import CPP, TreeTest, files, run, text_of

LINK = re.compile(r"\[[^\]]*\]\(([^)\s]+)\)")
POINTER = re.compile(r"\b(docs/[\w/-]+\.md(?:#[\w-]+)?)")


def places(page):
    """The anchors of a page, its own and those that a forge makes of headings."""
    text = page.read_text()
    found = set(re.findall(r'<a id="([^"]+)"></a>', text))
    for heading in re.findall(r"^#+ (.+)$", text, re.M):
        words = re.sub(r"[^\w\- ]", "", heading.lower())
        found.add(words.replace(" ", "-"))
    return found


def fault_of(target, place):
    """What is wrong with a pointer to `place` in the file `target`, or None."""
    if not target.exists():
        return "does not exist"
    if place and target.suffix == ".md" and place not in places(target):
        return f"has no place #{place}"
    return None


def check(root):
    problems = []
    for path in files(root, (".md", *CPP)):
        name = path.relative_to(root).as_posix()
        page = path.suffix == ".md"
        for number, line in enumerate((text_of(path) or "").splitlines(), 1):
            if page:
                found = LINK.findall(re.sub(r"`[^`]*`", "", line))
            else:
                found = POINTER.findall(line)
            for link in found:
                if re.match(r"[a-z]+:", link):
                    continue
                file, _, place = link.partition("#")
                target = (path.parent if page else root) / file if file else path
                fault = fault_of(target, place)
                if fault:
                    problems.append(f"{name}:{number}: {link}: {file or name} {fault}")
    return problems


class SelfTest(TreeTest):
    PAGES = {"docs/a.md": '# On light\n<a id="sun"></a>\n', "cli/a.cpp": ""}

    def problems(self, **changed):
        return check(self.tree({**self.PAGES, **changed}))

    def test_takes_links_that_lead_somewhere(self):
        self.assertEqual(self.problems(**{
            "docs/b.md": "[a](a.md#sun) [b](#c-d) [c](../cli/a.cpp) [w](https://x.org/y.md)\n"
                         "`[no link](none.md)`\n## C d\n",
            "cli/a.cpp": "// docs/a.md#on-light, docs/a.md#sun and docs/a.md.\n"}), [])

    def test_finds_a_page_that_is_not_there(self):
        self.assert_one(self.problems(**{"docs/b.md": "[a](c.md)\n"}), "c.md does not exist")
        self.assert_one(self.problems(**{"cli/a.cpp": "// docs/c.md\n"}), "does not exist")

    def test_finds_a_picture_that_is_not_there(self):
        self.assert_one(self.problems(**{"docs/b.md": "\n![a](c.png)\n"}), "docs/b.md:2")

    def test_finds_a_place_that_is_not_there(self):
        self.assert_one(self.problems(**{"docs/b.md": "[a](a.md#moon)\n"}), "no place #moon")
        self.assert_one(self.problems(**{"cli/a.cpp": "// docs/a.md#moon\n"}), "#moon")
        self.assert_one(self.problems(**{"docs/b.md": "[a](#moon)\n"}), "docs/b.md has no")


if __name__ == "__main__":
    run(check, SelfTest)
