# All runs of the study in one labelled file. Without `update`: if it cannot be made because a run is
# damaged, it must be missing for a rerun to compute that again.


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
    threads: max(1, min(len(STUDY.points) // 20, cores_here() or 1))
    resources:
        **READING,
    params:
        membership=[(point.id, point.series, point.figures) for point in STUDY.points.values()],
        amounts=[amounts(point.parameters) for point in STUDY.points.values()],
        boundaries=asked(),
        states=[name for name, spec in STUDY.entries.items() if spec.particles],
        title=STUDY.title,
        code=room("dataset", "observable"),
    shell:
        'python -m sim dataset "$TALUS_STUDY" --processes {threads} > {log} 2>&1'
