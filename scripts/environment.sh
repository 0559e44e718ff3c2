# shellcheck shell=bash
# Sourced by the scripts beside it: `prepare EXTRA...` makes sure that .venv at the root of the repository
# holds Impromptu with those extras, at the versions in constraints.txt. Only what is missing is installed.

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)"
venv="$root/.venv"
torch_cpu_index="https://download.pytorch.org/whl/cpu"

say() { printf '%s\n' "$*" >&2; }

fail() {
    say "$@"
    exit 1
}

# Whether the command $1 is a Python that Impromptu runs on, with the modules $2 (a, b).
is_python() {
    "$1" -c "import sys; assert (3, 11) <= sys.version_info < (3, 14); import $2" >/dev/null 2>&1
}

find_python() {
    local python
    for python in python3 python3.13 python3.12 python3.11; do
        if is_python "$python" "venv, ensurepip"; then
            echo "$python"
            return
        fi
    done
    for python in python3 python3.13 python3.12 python3.11; do
        if is_python "$python" sys; then
            fail "$python cannot make a virtual environment. Type this, then start again:" \
                $'\n'"    sudo apt install $python-venv"
        fi
    done
    fail "Python 3.11, 3.12 or 3.13 was not found. Type this, then start again:" \
        $'\n'"    sudo apt install python3 python3-venv"
}

make_venv() {
    if is_python "$venv/bin/python" pip; then return; fi
    local python
    python="$(find_python)"
    say "Making $venv with $("$python" --version)"
    rm -rf "$venv"
    "$python" -m venv "$venv"
}

# PyPI's torch brings gigabytes of CUDA; PyTorch's own index has a build without.
torch_index() {
    if timeout 10 "$venv/bin/python" - "$torch_cpu_index/torch/" >/dev/null 2>&1 <<'PROBE'; then
import sys, urllib.request
urllib.request.urlopen(sys.argv[1], timeout=5).close()
PROBE
        echo "--extra-index-url=$torch_cpu_index"
    fi
}

# What decides whether an installation is up to date; the root is in it because the package is not copied.
fingerprint() {
    (cd "$root" && pwd && cat pyproject.toml constraints.txt) | sha256sum | cut -d ' ' -f 1
}

# The clients of other makers that the tests drive, each in .venv-peers/NAME with what tests/peers/NAME.txt lists.
# Without dependencies, which are listed too: MAVProxy names a gigabyte of graphics that it does not need here.
prepare_peers() {
    local name place wanted
    for name in mavproxy dronekit; do
        place="$root/.venv-peers/$name"
        wanted="$root/tests/peers/$name.txt"
        if cmp -s "$wanted" "$place/installed"; then continue; fi
        say "Installing $name into $place (once)"
        rm -rf "$place"
        "$venv/bin/python" -m venv "$place"
        "$place/bin/python" -m pip install -qq --disable-pip-version-check --no-deps -r "$wanted"
        cp "$wanted" "$place/installed"
    done
}

prepare() {
    make_venv
    local extra current missing=() options=()
    current="$(fingerprint)"
    for extra in "$@"; do
        if [ "$(cat "$venv/impromptu-$extra" 2>/dev/null)" != "$current" ]; then missing+=("$extra"); fi
    done
    if [ ${#missing[@]} -eq 0 ]; then return; fi
    extra="$(IFS=,; echo "${missing[*]}")"
    say "Installing impromptu[$extra] into $venv (some minutes, once)"
    case ",$extra," in *,train,*) mapfile -t options < <(torch_index) ;; esac
    "$venv/bin/python" -m pip install -qq --disable-pip-version-check \
        "${options[@]}" -c "$root/constraints.txt" -e "${root}[${extra}]"
    for extra in "${missing[@]}"; do echo "$current" >"$venv/impromptu-$extra"; done
}
