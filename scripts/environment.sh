#!/bin/sh
# Build or complete .venv: `scripts/environment.sh run` for what dmil needs, `... dev` for the checks too.
# The Makefile calls it only when a pinned version or pyproject.toml has changed.
set -eu
cd "$(dirname "$0")/.."
kind=$1
PYTHON=${PYTHON:-python3}

fail() {
    printf 'dmil: %s\n' "$@" >&2
    exit 1
}

command -v "$PYTHON" >/dev/null 2>&1 ||
    fail "there is no '$PYTHON' here." "Install Python 3.11 to 3.13, or name one: make study PYTHON=/path/to/python3"
version=$("$PYTHON" -c 'import sys; print("%d.%d" % sys.version_info[:2])')
case $version in
    3.11 | 3.12 | 3.13) ;;
    *) fail "'$PYTHON' is Python $version; dmil needs 3.11, 3.12 or 3.13." \
        "Name another one: make study PYTHON=/path/to/python3" ;;
esac

# Debian ships venv without the part that installs pip.
if ! "$PYTHON" -c 'import ensurepip' >/dev/null 2>&1; then
    mend="apt-get install --yes python$version-venv"
    if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null 2>&1; then
        echo "dmil: installing python$version-venv"
        { apt-get update && DEBIAN_FRONTEND=noninteractive $mend; } >/dev/null ||
            fail "could not install python$version-venv; try: apt-get update && $mend"
    else
        fail "'$PYTHON' cannot make virtual environments." "This mends it: sudo $mend"
    fi
fi

# An environment of another Python version, or a half-made one, is no use.
if ! .venv/bin/python -m pip --version >/dev/null 2>&1 ||
    [ "$(.venv/bin/python -c 'import sys; print("%d.%d" % sys.version_info[:2])')" != "$version" ]; then
    echo "dmil: making .venv with Python $version"
    "$PYTHON" -m venv --clear .venv
fi

# Without --no-compile pip compiles every module of every package; Python does it for those in use.
install() {
    .venv/bin/python -m pip install --no-compile --quiet --disable-pip-version-check "$@"
}

if [ "$kind" = dev ]; then list=constraints-dev.txt; else list=constraints.txt; fi
echo "dmil: installing the packages of $list"
install --require-hashes --only-binary=:all: --requirement "$list"
if [ "$kind" = dev ]; then
    echo "dmil: installing the packages of constraints-torch.txt"
    install --only-binary=:all: --requirement constraints-torch.txt
fi
install --no-deps --no-build-isolation --editable .
