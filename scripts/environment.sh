#!/usr/bin/env bash
# Makes .venv hold what requirements/NAME.txt locks:  scripts/environment.sh serve|dev|bench
# or an environment of its own:                       scripts/environment.sh release .venv-release
# Quick when nothing changed: the lock that was installed last is kept in it and compared.
. "$(dirname "$0")/common.sh" environment

name=$1
lock=requirements/$name.txt
environment=${2:-.venv}
stamp=$environment/installed-$name.txt
python=$environment/bin/python

suits() { "$1" -c 'import sys; sys.exit(sys.version_info < (3, 11))' >/dev/null 2>&1; }

makes_environments() { "$1" -c 'import ensurepip, venv' >/dev/null 2>&1; }

# Looks at every interpreter on the path, not only the first of a name: that may be a shim which does not start.
find_python() {
    local candidate
    while IFS= read -r candidate; do
        if suits "$candidate" && "$@" "$candidate"; then
            printf '%s\n' "$candidate"
            return 0
        fi
    done < <(type -aP python3 python3.11 python3.12 python3.13 python3.14 python3.15)
    return 1
}

# Debian keeps ensurepip in a package of its own.
install_python() {
    local bare package=python3-venv
    if bare=$(find_python true); then
        package=$("$bare" -c 'import sys; print("python{}.{}-venv".format(*sys.version_info))')
    fi
    if can_apt && apt_install "$package" && find_python makes_environments; then
        return 0
    fi
    say "needs Python 3.11 or newer with its venv and ensurepip modules (Debian, Ubuntu: apt-get install $package);" \
        "python3 on the path is $(python3 --version 2>/dev/null || echo missing or broken)"
    return 1
}

if suits "$python" && cmp -s "$lock" "$stamp"; then
    exit 0
fi

if ! suits "$python" || ! "$python" -m pip --version >/dev/null 2>&1; then
    base=$(find_python makes_environments || install_python)
    say "creating $environment with $base"
    "$base" -m venv --clear "$environment"
fi

say "installing $lock"
# Wheels alone: building from source would fetch build tools that no hash covers.
"$python" -m pip install --quiet --disable-pip-version-check --no-input --require-hashes --only-binary :all: -r "$lock"
cp "$lock" "$stamp"
