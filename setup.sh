#!/bin/sh
# Set up everything that `make demo` needs: system libraries where they are missing and may be installed, and a virtual
# environment in .venv with the package. Says what it does; does nothing twice.
# With --tests all that `make test` and the documents need as well, a Chromium among it.
set -eu
cd "$(dirname "$0")"
PYTHON=${PYTHON:-python3}

fail() { echo "setup: $1" >&2; exit 2; }

install() { # Debian packages, as root or by sudo
    if ! command -v apt-get >/dev/null 2>&1; then
        fail "missing: $*; install them with your system's package manager"
    fi
    if [ "$(id -u)" = 0 ]; then as_root=""; elif command -v sudo >/dev/null 2>&1; then as_root="sudo"; else
        fail "missing: $*; run as root: apt-get install $*"
    fi
    echo "setup: installing $*" >&2
    $as_root apt-get update -qq >/dev/null 2>&1 || true # an old list may do
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq "$@" >/dev/null \
        || fail "apt-get install $* failed"
}

command -v "$PYTHON" >/dev/null 2>&1 || install python3
"$PYTHON" -c 'import sys; sys.exit(sys.version_info < (3, 11))' \
    || fail "expected Python 3.11 or newer, got $("$PYTHON" -V 2>&1); set PYTHON=/path/to/python3.11"
"$PYTHON" -c 'import ensurepip, venv' 2>/dev/null || install "$("$PYTHON" -c \
    'import sys; print(f"python3.{sys.version_info[1]}-venv")')"

# Open3D, which draws the pictures, is linked against these, though nothing opens a window; OpenMP's runtime.
missing=""
for pair in libusb-1.0.so.0:libusb-1.0-0 libgomp.so.1:libgomp1 libGL.so.1:libgl1 libEGL.so.1:libegl1 \
    libX11.so.6:libx11-6 libudev.so.1:libudev1 libidn2.so.0:libidn2-0; do
    "$PYTHON" -c "import ctypes; ctypes.CDLL('${pair%%:*}')" 2>/dev/null || missing="$missing ${pair##*:}"
done
# shellcheck disable=SC2086
[ -z "$missing" ] || install $missing

extras="" stamp=.venv/installed
if [ "${1:-}" = --tests ]; then extras="[formats,ros,test,docs]" stamp=.venv/installed-tests; fi

# The tests look at pages in a real browser. Where there is none and none can be had, those tests are skipped.
if [ "${1:-}" = --tests ] && ! command -v chromium >/dev/null 2>&1 && ! command -v google-chrome >/dev/null 2>&1; then
    (install chromium) || echo "setup: no Chromium: the pages are not tested in a browser" >&2
fi

pip_install() { .venv/bin/python -m pip install -q --no-compile --disable-pip-version-check "$@"; }

compile_kernels() { # those of a first answer, which take some 15 seconds of one core
    .venv/bin/python -c 'import spherefunc_bullet as sf
from spherefunc_bullet.scenes.household.household import household_objects
sf.classify(next(one.mesh for one in household_objects() if one.name == "mug_01"))' >/dev/null 2>&1 || true
}

[ -x .venv/bin/python ] || "$PYTHON" -m venv .venv
if [ ! -f "$stamp" ] || [ pyproject.toml -nt "$stamp" ] || [ spherefunc_bullet/__init__.py -nt "$stamp" ]; then
    echo "setup: installing the package${extras:+ with $extras} into .venv (some 400 MB to download the first time)" >&2
    # First what the kernels need, so that they are compiled on one core while pip, which uses one, installs the rest.
    pip_install numba scipy trimesh networkx pillow lazy-loader
    pip_install --no-deps -e .
    compile_kernels &
    pip_install "spherefunc-bullet$extras"
    # Compiled on all cores, which pip does on one, without what nothing here imports: other packages' tests, the
    # notebook widgets that Open3D names; ours too, for those who have Python write no bytecode. Of files that are no
    # Python, such as templates, compiling complains.
    .venv/bin/python -W ignore -m compileall -qq -j 0 .venv/lib spherefunc_bullet fast_sim scenes compare \
        -x "/(tests?|pip|setuptools|dash|plotly|narwhals|jedi|IPython|prompt_toolkit|fontTools|pybullet_envs)/" \
        >/dev/null || true
    wait
    touch .venv/installed "$stamp"
fi

# PyBullet has wheels up to Python 3.11. On newer ones it is compiled, once: the wheel is kept for the next environment.
wheels=${XDG_CACHE_HOME:-$HOME/.cache}/spherefunc-bullet/wheels
built() { ls "$wheels"/pybullet-*-cp"$("$PYTHON" -c 'import sys; print(*sys.version_info[:2], sep="")')"-*.whl 2>/dev/null; }

compile_pybullet() {
    command -v g++ >/dev/null 2>&1 || install g++
    "$PYTHON" -c 'import os, sys, sysconfig as s; sys.exit(not os.path.exists(s.get_path("include") + "/Python.h"))' \
        || install "$("$PYTHON" -c 'import sys; print(f"python3.{sys.version_info[1]}-dev")')"
    echo "setup: PyBullet has no wheel for $("$PYTHON" -V): compiling it once, some 5 minutes on two idle cores" \
        "(BULLET=no leaves it out); the wheel is kept in $wheels" >&2
    mkdir -p "$wheels" build
    CFLAGS=-g0 .venv/bin/python -m pip wheel -q --no-deps --disable-pip-version-check -w "$wheels" "pybullet>=3.2.7" \
        >build/pybullet.log 2>&1 &
    compiler=$! seconds=0
    while sleep 2 && kill -0 $compiler 2>/dev/null; do
        seconds=$((seconds + 2))
        [ $((seconds % 60)) != 0 ] || echo "setup: compiling PyBullet, $((seconds / 60)) min" >&2
    done
    wait $compiler
}

if ! .venv/bin/python -c "import importlib.util as u, sys; sys.exit(u.find_spec('pybullet') is None)" \
    && [ "${BULLET:-yes}" != no ]; then
    { [ -n "$(built)" ] || compile_pybullet; } \
        && .venv/bin/python -m pip install -q --no-deps --disable-pip-version-check "$(built | tail -n 1)" \
        || echo "setup: PyBullet could not be compiled (build/pybullet.log): the bullet backend is left out" >&2
fi

# What debuggers and linkers alone read: nine tenths of PyBullet's library, and 180 MB in all.
if [ ! -f .venv/stripped ] && command -v strip >/dev/null 2>&1; then
    find .venv/lib \( -name 'pybullet.*.so' -o -name 'eglRenderer.*.so' -o -name 'libllvmlite.so' \
        -o -path '*/fontTools/*.so' -o -path '*/kiwisolver/*.so' \) -exec strip --strip-unneeded {} +
    touch .venv/stripped
fi
