#!/bin/bash
#SBATCH --array=0-19
#SBATCH --ntasks=1
#SBATCH --cpus-per-task=1
#SBATCH --requeue
# Runs a planned sweep as an array of jobs: sbatch slurm.sh DIR. What is missing afterwards, if anything, is run by
#     sbatch --array=$(supercoil sweep status DIR --missing-of 20) slurm.sh DIR
# The folder must be on a file system that all nodes see. SHARDS is fixed, so that a part of the array means the same shards.
SHARDS=20
exec supercoil sweep run "$1" --shard "$SLURM_ARRAY_TASK_ID/$SHARDS" --jobs "${SLURM_CPUS_PER_TASK:-1}" --quiet
