"""Sums up the output of `cargo test`: how many tests read recorded data, then passed and failed over all programs.

Usage: summary.py LOG FAILED, where FAILED is 1 if an earlier step failed. Exits 1 if anything failed.
"""

import os
import pathlib
import re
import sys


def data_tests(root):
    """Names of the tests that read recorded data: they call `patrold_test_support::data`, or a helper that does."""
    function = re.compile(r"(#\[test\]\s+(?:#\[.*\]\s+)*)?(?:pub(?:\(\w+\))? )?fn (\w+)")
    tests, helpers = [], {"data"}
    for path in root.rglob("*.rs"):
        text = path.read_text(encoding="utf-8")
        if "target" in path.parts or "fn data(" in text:
            continue
        heads = list(function.finditer(text))
        for head, end in zip(heads, [h.start() for h in heads[1:]] + [len(text)]):
            body = text[head.end() : end]
            if head[1]:
                tests.append((head[2], body))
            elif "patrold_test_support" in text and re.search(r"\bdata\(", body):
                helpers.add(head[2])
    calls = re.compile(r"\b(?:" + "|".join(helpers) + r")\(")
    return sorted(name for name, body in tests if calls.search(body))


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
