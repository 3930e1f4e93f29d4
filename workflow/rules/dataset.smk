# All runs of the study in one labelled file. `update` leaves it to the job, which takes over what it
# holds of run files that have not changed.


rule dataset:
    input:
        lambda wildcards: run_files(STUDY.rounds),
    output:
        update(f"{RESULTS}/dataset.nc"),
    log:
        f"{RESULTS}/logs/dataset.log",
    benchmark:
        f"{RESULTS}/benchmarks/dataset.tsv"
    conda:
        "../envs/talus.yaml"
    threads: max(1, min(len(STUDY.points) // 20, cores_here() or 1))
    resources:
        **READING,
    params:
        membership=[(point.id, point.series, point.figures) for point in STUDY.points.values()],
        amounts=[amounts(point.parameters) for point in STUDY.points.values()],
        boundaries=asked(),
        states=[name for name in STUDY.figures if FIGURES[name].particles],
        title=STUDY.title,
        code=room("dataset"),
    shell:
        'python -m sim dataset "$TALUS_STUDY" --processes {threads} > {log} 2>&1'
