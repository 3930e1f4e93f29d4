# All runs of the study in one labelled file.


rule dataset:
    input:
        rules.runs.input,
    output:
        f"{RESULTS}/dataset.nc",
    log:
        f"{RESULTS}/logs/dataset.log",
    benchmark:
        f"{RESULTS}/benchmarks/dataset.tsv"
    conda:
        "../envs/talus.yaml"
    params:
        membership=[(point.id, point.series, point.figures) for point in STUDY.points.values()],
        title=STUDY.title,
        code=code("dataset.py"),
    shell:
        'python -m sim dataset "$TALUS_STUDY" > {log} 2>&1'
