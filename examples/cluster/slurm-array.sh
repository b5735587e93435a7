#!/bin/sh
# Fills one campaign store by an array of Slurm jobs: each computes a part of the units, on whatever node it gets.
#
#   SHARDS=16 sbatch --array=0-15 slurm-array.sh STORE STRUCTURE [FLAG ...]
#   SHARDS=16 sbatch --array=0-15 slurm-array.sh starling.zarr starling --thin 4
#
# Again what was killed, cancelled or ran out of time: the same line, or only the tasks that
# `barbule simulate STORE --status --shards 16` names, as in --array=3,7-9, with the same SHARDS. What is done is found and
# takes no time. Then, once: sbatch --dependency=afterok:JOB --wrap 'barbule fit starling.zarr -o starling.barbule'
#
# Store     on a file system that all nodes see. What is being written lies in it too: no other scratch space is needed.
# Crystals  keep their orders in the cache: --cache DIR in a folder that all nodes see has them computed once.
# Threads   four to a task share one preparation; more tasks of fewer threads wait less for free nodes.
# Memory    `barbule simulate … -v` says what a campaign takes; with less, fewer units are in work at once, to the same bits.
# SIMD      the store holds the bits of one instruction set: SIMD names one that all nodes have.
#
#SBATCH --job-name=barbule
#SBATCH --array=0-15
#SBATCH --cpus-per-task=4
#SBATCH --mem=2G
#SBATCH --time=01:00:00
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=%x-%A_%a.log
set -eu

if [ $# -lt 2 ]; then
    echo 'usage: sbatch slurm-array.sh STORE STRUCTURE [FLAG ...]' >&2
    exit 2
fi
task=${SLURM_ARRAY_TASK_ID:?submit this script with sbatch --array=0-15}
store=$1
structure=$2
shift 2

# Not the number of tasks of this submission, which is smaller when some are submitted again.
shards=${SHARDS:-16}
threads=${SLURM_CPUS_PER_TASK:-1}
# In MiB, of the node or of each processor; a tenth is left to the system.
memory=$((${SLURM_MEM_PER_NODE:-$((${SLURM_MEM_PER_CPU:-1024} * threads))} * 9 / 10))

exec barbule simulate "$structure" -o "$store" "$@" \
    --shard "$task/$shards" \
    --threads "$threads" --memory "${memory}MiB" --simd "${SIMD:-avx2}" --quiet
