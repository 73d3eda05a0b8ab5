#!/usr/bin/env bash
# Installs or names what the tests need, then checks format, lints, tests and docs.
#
# The last line says how many tests passed and failed; the exit status is 0 only when everything is in order.
# SHEEN_SHARED: folder with the reference scenes and images, ../shared unless given.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tests/needs.sh
source tests/needs.sh

install_needs

scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
chmod 700 "$scratch"
# The window libraries want a folder of their own even under a virtual display.
export XDG_RUNTIME_DIR="${XDG_RUNTIME_DIR:-$scratch}"

# A test that finds no adapter or no virtual display fails; none is skipped.
export SHEEN_REQUIRE_GPU=1
shared=${SHEEN_SHARED:-../shared}
if [ -d "$shared/reference" ]; then
  SHEEN_SHARED=$(cd "$shared" && pwd)
  export SHEEN_SHARED SHEEN_REQUIRE_SHARED=1
else
  printf '\n######## no reference scenes at %s: tests against them are SKIPPED ########\n\n' "$shared" >&2
fi

broken=()
step() {
  printf '\n== %s\n' "$*" >&2
  "$@" || broken+=("$*")
}
all_tests() {
  # Output of passing tests is shown too: that is where a skipped test says so.
  cargo test --locked --workspace --no-fail-fast -- --show-output | tee "$scratch/tests"
}

step cargo fmt --all --check
step cargo clippy --locked --workspace --all-targets -- -D warnings
step all_tests
RUSTDOCFLAGS="${RUSTDOCFLAGS:-} -D warnings" step cargo doc --locked --workspace --no-deps

skipped=$(grep -c 'SKIPPED' "$scratch/tests" || true)
if [ "$skipped" -gt 0 ]; then
  printf '\n%s SKIPPED:\n' "$skipped" >&2
  grep 'SKIPPED' "$scratch/tests" >&2
fi
for name in "${broken[@]}"; do
  printf 'FAILED: %s\n' "$name" >&2
done
read -r passed failed < <(awk '
  /^test result:/ {
    for (i = 2; i <= NF; i++) {
      if ($i == "passed;") passed += $(i - 1)
      if ($i == "failed;") failed += $(i - 1)
    }
  }
  END { print passed + 0, failed + 0 }' "$scratch/tests")
printf '%s passed, %s failed\n' "$passed" "$failed"
[ "${#broken[@]}" -eq 0 ] && [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
