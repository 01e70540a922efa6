#!/usr/bin/env bash
# Runs every fuzz target for so many seconds (60), from the seeds of the folder and larger ones that the tools make. It takes
# cargo-fuzz and a nightly compiler. What crashes a target is in artifacts/TARGET.
set -euo pipefail
cd "$(dirname "$0")"
seconds=${1:-60}
cargo build --manifest-path ../../Cargo.toml --bin srp
srp=../../target/debug/srp
seeds=corpus
mkdir -p $seeds/checkpoint
cp -r seeds/. $seeds

for name in sgrt decoupled tiny wide; do
    $srp machine source $name > $seeds/machine/$name.xml
done
cp ../cases/*.c $seeds/compile/
rm -rf $seeds/forms $seeds/forms.c
$srp new program $seeds/forms.c
$srp compile $seeds/forms.c --machine tiny --emit ir,dre,schedule -o $seeds/forms
cp $seeds/forms/*.ir $seeds/forms/*.dre.xml $seeds/program/
cp $seeds/forms/*.sched.xml $seeds/schedule/
for family in S1 T1 X1 M1 F1; do
    rm -f $seeds/cases/$family.cases
    $srp hard-cases --filter $family --export $seeds/cases/$family.cases
done
rm -f $seeds/document/{report,frame}*
for machine in wide decoupled; do
    $srp report $seeds/forms.c --machine $machine --json > $seeds/document/report.$machine
    $srp render --size 8x8 --machine $machine --effort 0.01 -o $seeds/frame.png --json > $seeds/document/frame.$machine
done
for kind in report frame; do
    { printf '\2'; cat $seeds/document/$kind.wide; printf '\n---\n'; cat $seeds/document/$kind.decoupled; } > $seeds/document/$kind
    rm $seeds/document/$kind.{wide,decoupled}
done

for target in cases checkpoint compile document graph machine program scene schedule; do
    echo "== $target"
    cargo +nightly fuzz run $target -- -max_total_time=$seconds -rss_limit_mb=4096 -timeout=20 2>&1 |
        grep -E "^(Done|SUMMARY|stat::|thread|==|#.*DONE)|panicked|artifact" || true
done
