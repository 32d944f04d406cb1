#!/bin/bash
# One comparison on several machines, a task of a job array for each of N shards of its rows:
#
#     sbatch --array=1-8 examples/slurm.sh 8 plume_8k hair --truth full
#     gobo join gobo-shards/* --out gobo-report             # once all are through
#
# N stands before what `gobo compare` is told. A task that was ended goes on where it was, by itself or by hand
# (`sbatch --array=3 examples/slurm.sh 8 …`). All need the same kind of device and driver: rows of others are refused.
#SBATCH --job-name=gobo --gpus-per-node=1 --requeue
set -eu
shards=$1
shift
exec gobo compare "$@" --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "gobo-shards/$SLURM_ARRAY_TASK_ID" --resume
