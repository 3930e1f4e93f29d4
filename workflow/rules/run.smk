# One run file for every point of the study.


# What it says, that it compiles, is for the user as well.
rule warm:
    output:
        f"{RESULTS}/runs/.warm",
    log:
        f"{RESULTS}/logs/warm.log",
    benchmark:
        f"{RESULTS}/benchmarks/warm.tsv"
    conda:
        "../envs/talus.yaml"
    threads: 2 * len({point.parameters.system for point in STUDY.points.values()}) or 1
    resources:
        mem_mb=PLAN.memory(1200),
        runtime=30,
    params:
        numerics=numerics_mark(),
    shell:
        'python -m sim job warm "$TALUS_STUDY" --processes {threads} 2>&1 | tee {log} && echo {params.numerics:q} > {output}'


# A run may outlive the Snakemake that started it. Snakemake would take the file that it writes
# then for incomplete. `update` leaves the file to the job, which keeps it if it is whole and up to date.
#
# The name of a run file contains a hash of the point. So a file is only outdated by another number
# of the numerics, or by larger amounts. The points depend on the batch, so they are no rerun
# trigger: they are derived from the output.
# The input must not be `ancient`: Snakemake ignores the parameters of a job below a job to run.
#
# After a failure, Snakemake would restore all files from the start of the job, even those that the
# job has finished since; so the job deletes its backups. `exec` leaves no shell in between, which
# on SIGTERM would not wait until the run has saved its state.
RUN = (
    "rm -f {params.backups:q}; "
    "exec python -m sim job batch {params.folder} <<< {params.points:q} 2> {log}"
)


rule run:
    input:
        lambda wildcards: run_inputs(wildcards.point),
    output:
        update(PLAN.run_file("{point}")),
    log:
        f"{RESULTS}/logs/jobs/{{point}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/runs/{{point}}.tsv"
    priority: lambda wildcards: PLAN.core_seconds([wildcards.point])
    conda:
        "../envs/talus.yaml"
    threads: lambda wildcards: PLAN.estimates([wildcards.point])[0].threads
    resources:
        mem_mb=lambda wildcards: PLAN.memory(PLAN.estimates([wildcards.point])[0].memory),
        runtime=lambda wildcards: PLAN.minutes([wildcards.point]),
    params:
        folder=lambda wildcards, output: RESULTS,
        backups=lambda wildcards, output: [f".snakemake/backups/{path}" for path in output],
        points=lambda wildcards, output: PLAN.points_json([wildcards.point]),
        amount=lambda wildcards: PLAN.amount_text(wildcards.point),
        numerics=numerics_mark(),
    shell:
        RUN


# Processes of MPI are tasks of a batch system; here they count as threads. The engine starts them
# itself, by TALUS_MPIEXEC. Other jobs have no resource `mpi`, which would change how they start.
if MPI_POINTS:

    use rule run as run_mpi with:
        wildcard_constraints:
            point="|".join(MPI_POINTS),
        threads: lambda wildcards: MPI_POINTS[wildcards.point] if local_cores() else 1
        resources:
            mem_mb=lambda wildcards: PLAN.memory(PLAN.estimates([wildcards.point])[0].memory),
            runtime=lambda wildcards: PLAN.minutes([wildcards.point]),
            tasks=lambda wildcards: MPI_POINTS[wildcards.point],
            mpi="mpiexec",


# Short points to run or to continue share a process, and on a cluster a job.
for batch, points in BATCHES.items():

    rule:
        name:
            batch
        input:
            rules.warm.output,
            START_FILE,
        output:
            update([PLAN.run_file(point) for point in points]),
        log:
            f"{RESULTS}/logs/jobs/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/runs/{batch}.tsv"
        priority: PLAN.core_seconds(points)
        conda:
            "../envs/talus.yaml"
        threads: 1
        resources:
            mem_mb=PLAN.memory(max(cost.memory for cost in PLAN.estimates(points))),
            runtime=PLAN.minutes(points),
        params:
            folder=lambda wildcards, output: RESULTS,
            backups=lambda wildcards, output: [f".snakemake/backups/{path}" for path in output],
            points=lambda wildcards, output: PLAN.points_json(Path(path).stem for path in output),
            amount=PLAN.amount_text(points[0]),
            numerics=numerics_mark(),
        shell:
            RUN


workflow.ruleorder(*BATCHES, *(["run_mpi"] if MPI_POINTS else []), "run")


rule runs:
    input:
        lambda wildcards: run_files(STUDY.rounds),
