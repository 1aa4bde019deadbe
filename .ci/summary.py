"""Sums up the output of `cargo test`: how many tests read recorded data, then passed and failed over all programs.

Usage: summary.py LOG FAILED, where FAILED is 1 if an earlier step failed. Exits 1 if anything failed.
"""

import os
import pathlib
import re
import sys


def data_tests(root):
    """Names of the tests that ask for recorded data, read from the sources: those that name the variable, or call a
    function that does."""
    function = re.compile(r"^\s*(?:pub )?fn (\w+)(.*?)(?=^\s*(?:#\[|///|(?:pub )?fn )|\Z)", re.M | re.S)
    names, helpers, bodies = [], {"data"}, []
    for path in sorted(root.rglob("*.rs")):
        if "target" in path.parts:
            continue
        text = path.read_text(encoding="utf-8")
        for found in function.finditer(text):
            is_test = re.search(r"#\[test\]\s*$", text[: found.start()]) is not None
            asks = "PATROLD_DATA" in found[2]
            if is_test:
                bodies.append((found[1], asks, found[2], path))
            elif asks:
                helpers.add(found[1])
    calls = re.compile(r"\b(?:" + "|".join(sorted(helpers)) + r")\(")
    near = re.compile(r"PATROLD_DATA|^mod common;|common::", re.M)
    for name, asks, body, path in bodies:
        if asks or (calls.search(body) and near.search(path.read_text(encoding="utf-8"))):
            names.append(name)
    return names


def main():
    log, failed_before = sys.argv[1], sys.argv[2] != "0"
    text = pathlib.Path(log).read_text(encoding="utf-8", errors="replace")
    results = re.findall(r"^test result: \w+\. (\d+) passed; (\d+) failed; (\d+) ignored", text, re.M)
    passed, failed, ignored = (sum(int(r[i]) for r in results) for i in range(3))

    names = data_tests(pathlib.Path("."))
    where = os.environ.get("PATROLD_DATA")
    if where:
        ran = sum(bool(re.search(rf"^test (\S+::)?{name} \.\.\.", text, re.M)) for name in names)
        print(f"data tests: {ran} ran on {where}")
    else:
        print(f"data tests: 0 ran, {len(names)} skipped (no ../shared/data and no PATROLD_DATA)")
    if ignored:
        print(f"ignored: {ignored}")
    if failed_before and not failed:
        print("a step before or around the tests failed, see above")
    print(f"{passed} passed, {failed} failed")
    return 1 if failed or failed_before or not results else 0


if __name__ == "__main__":
    sys.exit(main())
