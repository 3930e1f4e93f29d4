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
    params:
        membership=[(point.id, point.series, point.figures) for point in STUDY.points.values()],
        boundaries=asked(),
        title=STUDY.title,
        code=code(
            "caveats.py",
            "dataset.py",
            "gathered.py",
            "outcome.py",
            "measures/*.py",
            "figures/spec*.py",
            *(REFINEMENT if STUDY.boundaries else ()),
        ),
    shell:
        'python -m sim dataset "$TALUS_STUDY" > {log} 2>&1'
