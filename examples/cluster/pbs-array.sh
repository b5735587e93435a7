#!/bin/sh
# Fills one campaign store by an array of PBS jobs: each computes a part of the units, on whatever node it gets.
#
#   qsub -J 0-15 -v SHARDS=16,STORE=starling.zarr,STRUCTURE=starling pbs-array.sh
#
# qsub hands a script no words of its own: what else `barbule simulate` is to be told stands in FLAGS, as in FLAGS="--thin 4";
# commas part the variables of -v, so sets of numbers are written as ranges (400:700:20), or FLAGS is changed below.
#
# Again what was killed, deleted or ran out of time: the same line. What is done is found and takes no time. Fewer tasks are
# one range of at least two, since -J takes no list, around those that `barbule simulate STORE --status --shards 16` names, as
# in -J 7-9, with the same SHARDS. Then, once:
# qsub -W depend=afterok:JOB[] -- barbule fit "$PWD/starling.zarr" -o "$PWD/starling.barbule"
#
# Store     on a file system that all nodes see. What is being written lies in it too: no other scratch space is needed.
# Crystals  keep their orders in the cache: --cache DIR in a folder that all nodes see has them computed once.
# Threads   four to a task share one preparation; more tasks of fewer threads wait less for free nodes.
# Memory    `barbule simulate … -v` says what a campaign takes; with less, fewer units are in work at once, to the same bits.
#           MEMORY is to stay a tenth below the `mem` that is asked for.
# SIMD      the store holds the bits of one instruction set: SIMD names one that all nodes have.
#
#PBS -N barbule
#PBS -J 0-15
#PBS -l select=1:ncpus=4:mem=2gb
#PBS -l walltime=01:00:00
#PBS -r y
#PBS -j oe
set -eu

task=${PBS_ARRAY_INDEX:?submit this script with qsub -J 0-15}
cd "${PBS_O_WORKDIR:-.}"
flags=${FLAGS:-}

# Words of their own.
# shellcheck disable=SC2086
exec barbule simulate "${STRUCTURE:?name a structure by -v STRUCTURE=...}" \
    -o "${STORE:?name a store by -v STORE=...}" $flags \
    --shard "$task/${SHARDS:-16}" \
    --threads "${NCPUS:-1}" --memory "${MEMORY:-1800MiB}" --simd "${SIMD:-avx2}" --quiet
