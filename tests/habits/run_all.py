# SPDX-License-Identifier: Apache-2.0
"""All habit checks of this checkout, one after the other; for pre-commit and by hand."""

import pathlib
import subprocess
import sys

here = pathlib.Path(__file__).resolve().parent
failed = 0
for script in sorted(here.glob("*_test.py")):
    done = subprocess.run([sys.executable, "-B", str(script)], check=False)
    failed += done.returncode not in (0, 77)
sys.exit(1 if failed else 0)
