# Shared by the scripts beside it; sourced with the name under which they speak.
set -euo pipefail
speaker=$1
cd "$(dirname "${BASH_SOURCE[0]}")/.."

# Standard output belongs to what a script answers.
say() { printf '%s: %s\n' "$speaker" "$*" >&2; }

as_root() {
    if [ "$(id -u)" = 0 ]; then
        "$@"
    else
        sudo -n "$@"
    fi
}

can_apt() { command -v apt-get >/dev/null && as_root true 2>/dev/null; }

apt_install() {
    say "installing $*"
    local install=(env DEBIAN_FRONTEND=noninteractive apt-get install -y --no-install-recommends "$@")
    # Package lists may be missing or old: fetched only where the first try fails.
    as_root "${install[@]}" </dev/null >&2 || { as_root apt-get update </dev/null >&2 && as_root "${install[@]}" </dev/null >&2; }
}
