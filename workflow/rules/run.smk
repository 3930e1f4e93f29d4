# The fan-out: every point of the study becomes one run file.


rule warm:
    output:
        touch(f"{RESULTS}/runs/.warm"),
    log:
        f"{RESULTS}/logs/warm.log",
    benchmark:
        f"{RESULTS}/benchmarks/warm.tsv"
    conda:
        "../envs/talus.yaml"
    params:
        numerics=numerics_mark(),
    shell:
        'python -m sim warm "$TALUS_STUDY" > {log} 2>&1'


# A run may outlive the Snakemake that has started it, and Snakemake takes what it then writes for
# incomplete. `update` leaves the file to the job, which keeps it if it is whole and up to date.
#
# What makes a run file old is its point or the number of the numerics. The input must not be
# `ancient`: Snakemake does not look at the parameters of a job below one that is to run.
rule run:
    input:
        rules.warm.output,
    output:
        update(f"{RESULTS}/runs/{{point}}.nc"),
    log:
        f"{RESULTS}/logs/runs/{{point}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/runs/{{point}}.tsv"
    priority: lambda wildcards: cost(wildcards).core_seconds
    conda:
        "../envs/talus.yaml"
    threads: lambda wildcards: cost(wildcards).threads
    resources:
        mem_mb=lambda wildcards: cost(wildcards).memory,
        runtime=lambda wildcards: 10 + int(cost(wildcards).core_seconds / 20),
    params:
        point=lambda wildcards: canonical_json(parameters(wildcards)),
        numerics=numerics_mark(),
    shell:
        "python -m sim run - --output {output} --record-failure"
        " <<< {params.point:q} > {log} 2>&1"


rule runs:
    input:
        lambda wildcards: run_files(STUDY.rounds),
