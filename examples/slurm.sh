#!/bin/bash
# One comparison on several machines: a job array with one task for each of N shards of its rows.
#
#     sbatch --array=1-8 examples/slurm.sh 8 plume_8k hair --truth full
#     gobo join gobo-shards/* --out gobo-report             # when all tasks have finished
#
# N comes before the arguments of `gobo compare`. An interrupted task resumes where it stopped, requeued or resubmitted
# (`sbatch --array=3 examples/slurm.sh 8 …`). All machines need the same kind of device and driver; other rows are refused.
#SBATCH --job-name=gobo --gpus-per-node=1 --requeue
set -eu
shards=$1
shift
exec gobo compare "$@" --shard "$SLURM_ARRAY_TASK_ID/$shards" --out "gobo-shards/$SLURM_ARRAY_TASK_ID" --resume
