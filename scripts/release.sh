#!/bin/sh
# Build wheel and sdist, and try both where nothing else is: `make release`, before a tag.
# Other Pythons, if they are there: make release PYTHONS="python3.11 python3.12 python3.13"
set -eu
cd "$(dirname "$0")/.."
PYTHONS=${PYTHONS:-${PYTHON:-python3}}
MOST_MB=850

fail() {
    echo "dmil: $*" >&2
    exit 1
}

[ -z "$(git status --porcelain)" ] || fail "commit first: a release is what is committed"
version=$(.venv/bin/python -c 'import dmil; print(dmil.__version__)')
grep -q "^## $version" CHANGELOG.md || fail "CHANGELOG.md says nothing of $version"
grep -q "^version: $version\$" CITATION.cff || fail "CITATION.cff names another version than $version"

place=$(mktemp -d)
trap 'rm -rf "$place"' EXIT
rm -rf dist
for python in $PYTHONS; do
    echo "dmil: $version with $($python --version)"
    "$python" -m venv "$place/build"
    "$place/build/bin/pip" install --quiet --disable-pip-version-check hatchling
    [ -d dist ] || "$place/build/bin/hatchling" build
    for file in dist/*.whl dist/*.tar.gz; do
        "$python" -m venv --clear "$place/try"
        # The sdist is built again here, with what it brings.
        "$place/try/bin/pip" install --quiet --no-compile --disable-pip-version-check "$file"
        size_mb=$(du -sm "$place/try" | cut -f1)
        echo "dmil: $(basename "$file"): $size_mb MB without extras"
        [ "$size_mb" -le "$MOST_MB" ] || fail "more than $MOST_MB MB"
        (
            cd "$place"
            try/bin/dmil version
            try/bin/dmil evaluate grid:2x2 --steps 300 --seeds 2 >/dev/null
            try/bin/dmil study paper --grids 1x1 --seeds 1 --preset literal --steps 200 --out small >/dev/null
            test -s small/report.html
            rm -rf small
        )
    done
    rm -rf "$place/build"
done
du -sm "$place"/try/lib/python3*/site-packages/* | sort -rn | head -8
echo "dmil: dist/ is ready; tag v$version"
