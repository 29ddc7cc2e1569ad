#!/usr/bin/env bash
# Prints the path of a Chromium that starts, installing one if there is none. Needs .venv with the development lock.
# Where there is none to be had it says so and prints nothing, and fails where CI is set.
. "$(dirname "$0")/common.sh" chromium

python=.venv/bin/python

# A path is not enough: Ubuntu's chromium-browser may be a stub, and a download may lack system libraries.
answer() {
    [ -n "$1" ] && "$1" --version >/dev/null 2>&1 </dev/null && printf '%s\n' "$1"
}

from_path() {
    local name
    for name in chromium chromium-browser google-chrome google-chrome-stable; do
        answer "$(command -v "$name")" && return 0
    done
    return 1
}

from_playwright() {
    answer "$("$python" -c '
from playwright.sync_api import sync_playwright
with sync_playwright() as playwright:
    print(playwright.chromium.executable_path)' 2>/dev/null)"
}

none() {
    say "$*"
    case ${CI:-} in
        "" | 0 | false) exit 0 ;;
        *) exit 1 ;;
    esac
}

# What drives the browser: its Node.js needs libatomic, which small systems lack.
driver() { "$python" -m playwright --version 2>&1; }

driver >/dev/null || {
    if can_apt; then
        apt_install libatomic1 || true
    fi
    problem=$(driver) || none "Playwright does not start: $problem"
}

if [ -n "${GAINSCOPE_CHROMIUM:-}" ]; then
    answer "$GAINSCOPE_CHROMIUM" && exit 0
    say "GAINSCOPE_CHROMIUM=$GAINSCOPE_CHROMIUM does not start"
    exit 1
fi

from_path && exit 0
from_playwright && exit 0
if can_apt && apt_install chromium fonts-dejavu-core; then
    from_path && exit 0
fi
say "downloading Playwright's Chromium"
"$python" -m playwright install chromium </dev/null >&2 || true
from_playwright && exit 0
if can_apt; then
    say "installing the libraries it needs"
    as_root "$python" -m playwright install-deps chromium </dev/null >&2 || true
    from_playwright && exit 0
fi

none "found none: install Chromium or Chrome (Debian: apt-get install chromium), or set GAINSCOPE_CHROMIUM to one"
