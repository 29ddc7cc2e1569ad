"""Known vulnerabilities of what the image is made of:  .venv-release/bin/python scripts/audit.py [--unasked-is-fine]

pip-audit asks the Python Package Index about every package of requirements/serve.txt. Of packages that it could not ask
about it says "no known vulnerabilities" as well; here that is no audit. Ends with status 0 where all were asked about
and nothing is known, 1 where something is known, 2 where not all could be asked about (unless that is said to be fine).
"""

from __future__ import annotations

import json
import subprocess
import sys

LOCK = "requirements/serve.txt"
CLEAN, KNOWN, UNASKED = 0, 1, 2
OPTIONS = ["--require-hashes", "--disable-pip", "--progress-spinner", "off", "--format", "json", "-r", LOCK]


def verdict(report: str, trouble: str = "") -> tuple[int, list[str]]:
    """Status, and what is to be said, from what pip-audit wrote as JSON and as trouble."""
    try:
        packages = json.loads(report)["dependencies"]
    except (ValueError, LookupError, TypeError):
        last = trouble.strip().splitlines()[-1:] or ["it said nothing"]
        return UNASKED, [f"THE AUDIT WAS NOT MADE: {last[0]}"]
    known = [
        f"{package['name']} {package['version']}: {found['id']}, mended in {', '.join(found['fix_versions']) or 'none'}"
        for package in packages
        for found in package.get("vulns", ())
    ]
    unasked = [package["name"] for package in packages if "vulns" not in package]
    if unasked or not packages:
        listed = ", ".join(unasked[:5]) + (", ..." if len(unasked) > 5 else "")
        share = f"{len(unasked)} of {len(packages)} packages"
        status = KNOWN if known else UNASKED
        return status, [*known, f"THE AUDIT WAS NOT MADE of {share}, the index did not tell: {listed}"]
    return (KNOWN, known) if known else (CLEAN, [f"{len(packages)} packages, nothing is known against them"])


def main(arguments: list[str]) -> int:
    done = subprocess.run([sys.executable, "-m", "pip_audit", *OPTIONS], capture_output=True, text=True, check=False)
    status, said = verdict(done.stdout, done.stderr)
    print("\n".join(f"audit: {line}" for line in said))
    return CLEAN if status == UNASKED and "--unasked-is-fine" in arguments else status


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
