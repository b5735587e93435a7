#!/bin/sh
# Fills one campaign store by processes on this machine: all of SHARDS parts of the units, AT_ONCE of them at a time.
#
#   SHARDS=16 AT_ONCE=4 sh local-array.sh STORE STRUCTURE [FLAG ...]
#   SHARDS=16 AT_ONCE=4 sh local-array.sh starling.zarr starling --thin 4
#
# On one machine one process with all threads is faster, since it prepares once. This is for trying an array before it is
# submitted, and for several machines that share a folder: start it on each, they find what the others did.
#
# Again after Ctrl-C, a crash or a power failure: the same line. What is done is found and takes no time.
#
# Threads   THREADS of each process; AT_ONCE times THREADS should not be over the number of cores.
# Memory    MEMORY of each process, so AT_ONCE times that in all; with less, fewer units are in work at once, to the same bits.
# SIMD      the store holds the bits of one instruction set. Where machines differ, SIMD names one that all have.
set -u

if [ $# -lt 2 ]; then
    echo 'usage: SHARDS=n AT_ONCE=k sh local-array.sh STORE STRUCTURE [FLAG ...]' >&2
    exit 2
fi
store=$1
structure=$2
shift 2
shards=${SHARDS:-8}
at_once=${AT_ONCE:-2}
case "$shards$at_once" in
*[!0-9]*)
    echo "SHARDS=$shards AT_ONCE=$at_once: give whole numbers" >&2
    exit 2
    ;;
esac
if [ "$shards" -lt 1 ] || [ "$at_once" -lt 1 ]; then
    echo "SHARDS=$shards AT_ONCE=$at_once: give numbers from 1 on" >&2
    exit 2
fi

# worker FIRST WORD...: every AT_ONCE-th part, from FIRST on. A part that fails does not keep the others from being tried.
worker() {
    shard=$1
    shift
    failed=0
    child=
    # What runs in the background ignores Ctrl-C; this process hands it on.
    trap '[ -z "$child" ] || kill "$child" 2>/dev/null; exit 130' TERM
    while [ "$shard" -lt "$shards" ]; do
        barbule simulate "$structure" -o "$store" "$@" --shard "$shard/$shards" --threads "${THREADS:-1}" \
            --memory "${MEMORY:-2GiB}" ${SIMD:+--simd "$SIMD"} --quiet &
        child=$!
        wait "$child" || failed=1
        child=
        shard=$((shard + at_once))
    done
    exit $failed
}

workers=
first=0
while [ "$first" -lt "$at_once" ]; do
    (worker "$first" "$@") &
    workers="$workers $!"
    first=$((first + 1))
done
# shellcheck disable=SC2086
trap 'kill $workers 2>/dev/null; wait; exit 130' INT TERM
code=0
for worker in $workers; do
    wait "$worker" || code=1
done
barbule simulate "$store" --status --shards "$shards"
exit $code
