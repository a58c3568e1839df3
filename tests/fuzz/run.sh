#!/bin/sh
# run.sh FOLDER SECONDS: runs each fuzzer of FOLDER for SECONDS. Ends with one line: how many passed and failed.
set -eu
# clang 14 with AddressSanitizer aligns stacks to 32 bytes where AVX-512 spills want 64, and crashes of its own making.
CPM_ISA=v3
export CPM_ISA
folder=$1
seconds=$2
passed=0
failed=0
for fuzzer in "$folder"/fuzz_*; do
    [ -x "$fuzzer" ] && [ -f "$fuzzer" ] || continue
    echo "== $(basename "$fuzzer"), $seconds s"
    if "$fuzzer" -max_total_time="$seconds" -timeout=60 -rss_limit_mb=4096 -max_len=4096 -print_final_stats=1 \
        -artifact_prefix="$folder/" -verbosity=0; then
        passed=$((passed + 1))
    else
        failed=$((failed + 1))
    fi
done
echo "$passed passed, $failed failed"
[ "$failed" = 0 ] && [ "$passed" != 0 ]
