# SPDX-License-Identifier: Apache-2.0
"""The folders are the data flow: no stage includes a later one.

- The order is RELIGHT_STAGES in CMakeLists.txt. An include names a file from the root; the
  file exists, or CMake makes it from a .in file of the stage. Its stage is not a later one:
  it is the stage itself or one that the stage's relight_add_stage(… AFTER …) names,
  directly or through another.
- OpenImageIO and OpenColorIO are seen in relight/photo and relight/composite only, OpenVDB
  in relight/volume and relight/scattering only. (Tests may use any.)
- Heavy headers (OpenVDB, CLI11, toml++, nlohmann) are not included by the headers of the
  library, for everyone who includes those would pay. (cli/ is a program.)
"""

import re

from source_tree import CPP, TreeTest, files, run, stage_of, stages

INCLUDE = re.compile(r'^\s*#\s*include\s+(["<])([^">]+)[">]')
ONLY_IN = (
    (("OpenImageIO/", "OpenColorIO/"), ("relight/photo", "relight/composite")),
    (("openvdb/",), ("relight/volume", "relight/scattering")),
)
HEAVY = ("openvdb/", "CLI/", "toml++/", "nlohmann/")


def includes(path):
    for number, line in enumerate(path.read_text().splitlines(), 1):
        found = INCLUDE.match(line)
        if found:
            yield number, found.group(1) == '"', found.group(2)


def allowed_stages(root, order):
    """For each stage with a relight_add_stage call: itself and all that it stands on."""
    by_name = {stage.rsplit("/", 1)[-1]: stage for stage in order}
    after = {}
    for stage in order:
        cmake = root / stage / "CMakeLists.txt"
        calls = re.findall(r"relight_add_stage\(([^)]*)\)", cmake.read_text()) \
            if cmake.is_file() else []
        for call in calls:
            words = re.sub(r"#.*", "", call).split()
            after.setdefault(stage, set())
            for name in words[words.index("AFTER") + 1:] if "AFTER" in words else []:
                if name.isupper():
                    break
                after[stage].add(by_name.get(name, name))
    reach = {}
    for stage in order:  # Earlier ones are complete when a later one asks for them
        if stage in after:
            reach[stage] = {stage}
            for earlier in after[stage]:
                reach[stage] |= reach.get(earlier, {earlier})
    return after, reach


def check(root):
    order = stages(root)
    after, reach = allowed_stages(root, order)
    problems = []
    for stage, earlier in after.items():
        for name in sorted(earlier):
            if name not in order:
                problems.append(f"{stage}/CMakeLists.txt: AFTER {name}, which is no stage")
            elif order.index(name) >= order.index(stage):
                problems.append(f"{stage}/CMakeLists.txt: AFTER {name}, a later stage")

    for path in files(root, CPP):
        name = path.relative_to(root).as_posix()
        stage = stage_of(name, order)
        for line, quoted, included in includes(path):
            where = f"{name}:{line}: includes {included}"
            if quoted and not (root / included).is_file() and not (
                    stage and any((root / stage).rglob(f"{included}.in"))):
                problems.append(f"{where}, which is no file from the root of the project")
            if stage is None:
                continue
            to = stage_of(included, order)
            if to and order.index(to) > order.index(stage):
                problems.append(f"{where}: {to} is a later stage than {stage}")
            elif to and stage in reach and to not in reach[stage]:
                problems.append(f"{where}, but relight_add_stage of {stage} does not say "
                                f"AFTER {to.rsplit('/', 1)[-1]}")
            for libraries, places in ONLY_IN:
                if included.startswith(libraries) and stage not in places:
                    problems.append(f"{where}, which only {' and '.join(places)} may see")
            library = stage not in ("cli", "plugin_gimp")
            if library and path.suffix == ".h" and included.startswith(HEAVY):
                problems.append(f"{where}, a heavy header; include it in the .cpp only")
    return problems


class SelfTest(TreeTest):
    STAGES = "set(RELIGHT_STAGES\n  relight/base relight/photo\n  matting relight/sky cli)\n"

    def problems(self, **contents):
        tree = {"CMakeLists.txt": self.STAGES, "relight/base/a.h": "",
                "relight/photo/p.h": "", "relight/sky/s.h": "", "matting/m.h": ""}
        tree.update(contents)
        return check(self.tree(tree))

    def test_takes_what_is_in_order(self):
        self.assertEqual(self.problems(**{
            "relight/sky/s.cpp": '#include "relight/base/a.h"\n#include <openvdbish>\n',
            "relight/photo/p.cpp": "#include <OpenImageIO/imageio.h>\n",
            "cli/main.cpp": '#include <CLI/CLI.hpp>\n#include "relight/sky/s.h"\n',
            "cli/flags.h": "#include <CLI/CLI.hpp>\n"}), [])

    def test_finds_a_later_stage(self):
        self.assert_one(self.problems(**{
            "relight/photo/p.cpp": '\n#include "relight/sky/s.h"\n'}),
            "relight/photo/p.cpp:2", "later stage")

    def test_finds_a_later_stage_in_angle_brackets(self):
        self.assert_one(self.problems(**{
            "matting/m.cpp": "#include <relight/sky/s.h>\n"}), "later stage")

    def test_finds_a_path_that_is_not_from_the_root(self):
        self.assert_one(self.problems(**{"relight/sky/s.cpp": '#include "s.h"\n'}),
                        "no file from the root")

    def test_takes_a_header_that_cmake_makes(self):
        self.assertEqual(self.problems(**{
            "relight/photo/color/c.h.in": "", "relight/photo/p.cpp": '#include "c.h"\n'}), [])

    def test_finds_an_include_that_after_does_not_name(self):
        self.assert_one(self.problems(**{
            "relight/sky/CMakeLists.txt": "relight_add_stage(sky HEADERS s.h AFTER base)",
            "relight/sky/s.cpp": '#include "relight/photo/p.h"\n'}), "AFTER photo")

    def test_takes_an_include_through_another_stage(self):
        self.assertEqual(self.problems(**{
            "relight/photo/CMakeLists.txt": "relight_add_stage(photo AFTER base LINKS x)",
            "relight/sky/CMakeLists.txt": "relight_add_stage(sky AFTER photo)",
            "relight/sky/s.cpp": '#include "relight/base/a.h"\n'}), [])

    def test_finds_after_a_later_stage(self):
        self.assert_one(self.problems(**{
            "relight/base/CMakeLists.txt": "relight_add_stage(base AFTER sky)"}),
            "AFTER relight/sky, a later stage")

    def test_finds_pixel_files_outside_photo(self):
        self.assert_one(self.problems(**{
            "relight/sky/s.cpp": "#include <OpenImageIO/imageio.h>\n"}), "only relight/photo")

    def test_finds_volumes_outside_volume(self):
        self.assert_one(self.problems(**{
            "cli/main.cpp": "#include <openvdb/openvdb.h>\n"}), "only relight/volume")

    def test_finds_a_heavy_header(self):
        for heavy in ("CLI/CLI.hpp", "toml++/toml.h", "nlohmann/json.hpp"):
            self.assert_one(self.problems(**{
                "relight/sky/s.h": f"#include <{heavy}>\n"}), "heavy")


if __name__ == "__main__":
    run(check, SelfTest)
