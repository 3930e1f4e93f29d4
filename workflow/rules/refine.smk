# Boundaries between regimes, and surrogates that are not exact enough: the runs of all rounds so
# far determine the points of the next round.


checkpoint refine:
    input:
        lambda wildcards: run_files(int(wildcards.round) - 1),
    output:
        f"{RESULTS}/rounds/{{round}}.json",
    log:
        f"{RESULTS}/logs/rounds/{{round}}.log",
    benchmark:
        f"{RESULTS}/benchmarks/rounds/{{round}}.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **PLAN.reader_resources,
    params:
        boundaries=as_written(PLAN.boundary_searches),
        questions=as_written(PLAN.questions),
        code=room_code("surrogates", "observable") if PLAN.questions else room_code("dataset"),
    shell:
        'python -m sim job refine "$TALUS_STUDY" {wildcards.round} > {log} 2>&1'


rule boundaries:
    input:
        rules.dataset.output,
    output:
        report(
            f"{RESULTS}/boundaries.csv",
            caption="../report/boundaries.rst",
            category="Boundaries",
        ),
    log:
        f"{RESULTS}/logs/boundaries.log",
    benchmark:
        f"{RESULTS}/benchmarks/boundaries.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **PLAN.reader_resources,
    params:
        boundaries=as_written(PLAN.boundary_searches),
        code=room_code("dataset"),
    shell:
        'python -m sim job boundaries "$TALUS_STUDY" > {log} 2>&1'
