#!/bin/bash
# Takes the place of `sbatch`: runs what is submitted at once, an array task by task, and prints a number as `sbatch --parsable` does.
set -e
echo "$*" >> submitted.txt
array=
while [ "${1#--}" != "$1" ]; do
  case "$1" in --array=*) array=${1#--array=} ;; esac
  shift
done
export SLURM_JOB_ID=1
if [ -z "$array" ]; then bash "$@" >> log.txt 2>&1
else for task in $(seq "${array%-*}" "${array#*-}"); do SLURM_ARRAY_TASK_ID=$task bash "$@" >> log.txt 2>&1; done; fi
echo "$(wc -l < submitted.txt);cluster"
