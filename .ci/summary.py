"""Sums up the output of `cargo test`: how many tests read recorded data, then passed and failed over all programs.

Usage: summary.py LOG FAILED, where FAILED is 1 if an earlier step failed. Exits 1 if anything failed.
"""

import os
import pathlib
import re
import sys


def data_tests(root):
    """Names of the tests that ask for recorded data, read from the sources."""
    asks = re.compile(r"\b(data|data_dir|recorded|recording|recordings)\(")
    names = []
    for path in sorted(root.rglob("*.rs")):
        if "target" in path.parts:
            continue
        text = path.read_text(encoding="utf-8")
        if "PATROLD_DATA" not in text and "common::data" not in text:
            continue
        for body in re.split(r"#\[test\]", text)[1:]:
            name = re.search(r"\bfn (\w+)", body)
            end = body.find("\n#[test]")
            if name and asks.search(body[: end if end > 0 else len(body)]):
                names.append(name.group(1))
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
