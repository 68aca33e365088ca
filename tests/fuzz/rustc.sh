#!/usr/bin/env bash
# RUSTC_WRAPPER for the fuzzer: counters in this crate and its targets, not in what they depend on. With counters in Burn, too, the first build takes
# much longer, and the fuzzer learns nothing from them.
rustc="$1"
shift
case " $* " in
*" --crate-name ballmark "* | *" targets/"*) exec "$rustc" "$@" -Ccodegen-units=16 ;;
esac
kept=()
for argument in "$@"; do
    case "$argument" in
    -Cpasses=sancov-module | -Cllvm-args=-sanitizer-coverage* | passes=sancov-module | llvm-args=-sanitizer-coverage*) ;;
    *) kept+=("$argument") ;;
    esac
done
exec "$rustc" "${kept[@]}"
