#!/usr/bin/env bash
# Counts rays that meshes lose and false hits of our triangle tests beside Embree's, with so many rays of each mesh and aim
# (1000). It takes g++ and libembree-dev 3 of Debian, and installs the latter where it may.
set -euo pipefail
cd "$(dirname "$0")/../.."
rays=${1:-1000}
if [ ! -e /usr/include/embree3/rtcore.h ]; then
    apt-get install -y libembree-dev >/dev/null ||
        { echo "skipped: libembree-dev is absent" >&2; exit 0; }
fi
cargo build --release --bin srp
srp=target/release/srp
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
g++ -std=c++17 -O2 tests/embree/hits.cpp -o "$work/hits" -lembree3
$srp watertight --rays "$rays" --export "$work/meshes"
"$work/hits" "$work/meshes"
$srp watertight --rays "$rays" --beside "$work/meshes/embree" --beside "$work/meshes/embree-robust"
