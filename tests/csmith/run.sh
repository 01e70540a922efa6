#!/bin/sh
# Programs of csmith (the Debian package `csmith`) by the host's compiler and by `srp run`.
#
#   tests/csmith/run.sh [COUNT [SEED]]     SRP names the command, default target/release/srp
#
# `long` has 32 bits here, so that the host's compiler is asked for 32 bits too where it can.
set -eu
count=${1:-100}
seed=${2:-1}
here=$(cd "$(dirname "$0")" && pwd)
srp=${SRP:-$here/../../target/release/srp}
command -v csmith > /dev/null || { echo "csmith is not installed" >&2; exit 2; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
m32=
echo 'int main(void) { return 0; }' > "$work/t.c"
cc -m32 -o "$work/t" "$work/t.c" 2> /dev/null && m32=-m32
differing=0
i=0
while [ "$i" -lt "$count" ]; do
    s=$((seed + i))
    i=$((i + 1))
    # It leaves a file where it runs.
    (cd "$work" && csmith --seed "$s" --no-packed-struct --no-argc --concise) > "$work/p.c"
    cc $m32 -w -fwrapv -frounding-math -O1 -I "$here" -o "$work/p" "$work/p.c" || continue
    timeout 5 "$work/p" > "$work/expected" || continue
    for engine in ir interp; do
        status=0
        "$srp" run "$work/p.c" -I "$here" -fno-auto-kernel --engine "$engine" --limit 200000000 \
            > "$work/found" 2> "$work/errors" || status=$?
        if [ "$status" -ne 0 ] && grep -q "limit\|steps\|has not ended" "$work/errors"; then
            continue
        fi
        if ! cmp -s "$work/expected" "$work/found"; then
            echo "seed $s: --engine $engine differs"
            head -n 3 "$work/errors"
            differing=$((differing + 1))
        fi
    done
done
echo "$count programs, $differing differences"
[ "$differing" -eq 0 ]
