# All runs of the study in one labelled file.


rule dataset:
    input:
        lambda wildcards: run_files(STUDY.rounds),
    output:
        f"{RESULTS}/dataset.nc",
    log:
        f"{RESULTS}/logs/dataset.log",
    benchmark:
        f"{RESULTS}/benchmarks/dataset.tsv"
    conda:
        "../envs/talus.yaml"
    resources:
        **READING,
    params:
        membership=[(point.id, point.series, point.figures) for point in STUDY.points.values()],
        boundaries=asked(),
        states=[name for name in STUDY.figures if FIGURES[name].particles],
        title=STUDY.title,
        code=room("dataset"),
    shell:
        'python -m sim dataset "$TALUS_STUDY" > {log} 2>&1'
