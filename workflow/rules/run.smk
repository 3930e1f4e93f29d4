# The fan-out: every point of the study becomes one run file.


rule warm:
    output:
        WARM,
    log:
        f"{RESULTS}/logs/warm.log",
    benchmark:
        f"{RESULTS}/benchmarks/warm.tsv"
    conda:
        "../envs/talus.yaml"
    threads: len({point.parameters.system for point in STUDY.points.values()}) or 1
    resources:
        mem_mb=memory(1200),
        runtime=30,
    params:
        numerics=numerics_mark(),
    shell:
        'python -m sim warm "$TALUS_STUDY" --processes {threads} > {log} 2>&1 && echo {params.numerics:q} > {output}'


# A run may outlive the Snakemake that has started it, and Snakemake takes what it then writes for
# incomplete. `update` leaves the file to the job, which keeps it if it is whole and up to date.
#
# The name of a run file holds a hash of the point, so what makes the file old is the number of the
# numerics, and that more is wanted than it holds; the points themselves, which change with the
# batch, are derived from the output.
# The input must not be `ancient`: Snakemake does not look at the parameters of a job below one that
# is to run.
#
# After a failure, Snakemake would put back the files as they were when the job began, those too that
# the job has finished since; hence the end of its backups. And there is no shell in between: it
# would not wait, on SIGTERM, until the run has saved its state.
RUN = (
    "rm -f {params.backups:q}; "
    "exec python -m sim batch {params.folder} <<< {params.points:q} 2> {log}"
)


rule run:
    input:
        rules.warm.output,
        START,
        lambda wildcards: origin_file(wildcards.point),
    output:
        update(run_file("{point}")),
    log:
        f"{RESULTS}/logs/jobs/{{point}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/runs/{{point}}.tsv"
    priority: lambda wildcards: seconds([wildcards.point])
    conda:
        "../envs/talus.yaml"
    threads: lambda wildcards: costs([wildcards.point])[0].threads
    resources:
        mem_mb=lambda wildcards: memory(costs([wildcards.point])[0].memory),
        runtime=lambda wildcards: minutes([wildcards.point]),
    params:
        folder=lambda wildcards, output: RESULTS,
        backups=lambda wildcards, output: [f".snakemake/backups/{path}" for path in output],
        points=lambda wildcards, output: in_json([wildcards.point]),
        amount=lambda wildcards: amount(wildcards.point),
        numerics=numerics_mark(),
    shell:
        RUN


# Short points that are to be run, or run on, share a process, and on a cluster a job.
for batch, points in BATCHES.items():

    rule:
        name:
            batch
        input:
            rules.warm.output,
            START,
        output:
            update([run_file(point) for point in points]),
        log:
            f"{RESULTS}/logs/jobs/{batch}.log",
        benchmark:
            f"{RESULTS}/benchmarks/runs/{batch}.tsv"
        priority: seconds(points)
        conda:
            "../envs/talus.yaml"
        threads: 1
        resources:
            mem_mb=memory(max(cost.memory for cost in costs(points))),
            runtime=minutes(points),
        params:
            folder=lambda wildcards, output: RESULTS,
            backups=lambda wildcards, output: [f".snakemake/backups/{path}" for path in output],
            points=lambda wildcards, output: in_json(Path(path).stem for path in output),
            amount=amount(points[0]),
            numerics=numerics_mark(),
        shell:
            RUN


workflow.ruleorder(*BATCHES, "run")


rule runs:
    input:
        lambda wildcards: run_files(STUDY.rounds),
